//! Point clouds of an episode: what all cameras see at one time, as points with color and instance.
//!
//! Every frame has equally many points. They are in the world, in meters, so that clouds of several cameras are one.

use crate::pixels::zlib;

/// Most points of a frame.
pub const MAX_POINTS: u32 = 65_536;

/// The points of one frame.
#[derive(Clone, Copy, Debug)]
pub struct PointCloud<'a> {
    /// x, y, z of each point in the world, meters.
    pub positions_m: &'a [f32],
    /// Red, green, blue of each.
    pub colors: &'a [u8],
    /// The instance of each; 0 is none.
    pub instance_ids: &'a [u16],
}

/// Point clouds of an episode unit: zlib streams of little-endian numbers, one a frame. Empty where they are not
/// recorded, or no format needs them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PointCloudTrack {
    /// f32, meters: point x 3.
    pub positions_zlib: Vec<Vec<u8>>,
    /// u8: point x 3.
    pub colors_zlib: Vec<Vec<u8>>,
    /// u16.
    pub ids_zlib: Vec<Vec<u8>>,
}

impl PointCloudTrack {
    /// Adds the points of the next frame.
    pub(crate) fn add(&mut self, cloud: &PointCloud) {
        let bytes: Vec<u8> = cloud.positions_m.iter().flat_map(|number| number.to_le_bytes()).collect();
        self.positions_zlib.push(zlib(&bytes));
        self.colors_zlib.push(zlib(cloud.colors));
        let ids: Vec<u8> = cloud.instance_ids.iter().flat_map(|id| id.to_le_bytes()).collect();
        self.ids_zlib.push(zlib(&ids));
    }

    /// All of its lists.
    pub(crate) fn lists(&self) -> [&Vec<Vec<u8>>; 3] {
        [&self.positions_zlib, &self.colors_zlib, &self.ids_zlib]
    }
}

/// Fault of the points of a frame of a dataset that has `points` of them, and the correction.
pub(crate) fn fault_of(cloud: Option<&PointCloud>, points: Option<u32>) -> Option<(String, &'static str)> {
    let (cloud, points) = match (cloud, points) {
        (None, None) => return None,
        (Some(cloud), Some(points)) => (cloud, points as usize),
        (None, Some(_)) => {
            return Some(("the points are missing".into(), "give them, or describe the dataset without"));
        }
        (Some(_), None) => return Some(("points are given".into(), "describe the dataset with points")),
    };
    let lists = [
        ("coordinates", cloud.positions_m.len(), 3 * points),
        ("numbers of colors", cloud.colors.len(), 3 * points),
        ("instance ids", cloud.instance_ids.len(), points),
    ];
    if let Some((what, given, expected)) = lists.iter().find(|(_, given, expected)| given != expected) {
        let what = format!("the points have {given} {what}, not {expected}");
        return Some((what, "give three coordinates, three numbers of color and one id for each point"));
    }
    let infinite = cloud.positions_m.iter().find(|number| !number.is_finite());
    infinite.map(|number| (format!("a coordinate of a point is {number}"), "use finite numbers in meters"))
}
