//! Points that all cameras see, as one cloud in the world.
//!
//! Points are centers of pixels that show the table, an object or the robot; floor and backdrop are left out. Of an
//! even choice of these, each point is the one that is farthest from all before it (farthest point sampling), so that
//! small objects have points too, and the first points of a cloud are spread over the scene as well.

use geometry::Vec3;

use crate::stage::CameraView;

/// Pixels among which a point is chosen, for each point.
const CHOICES: usize = 4;

/// The points of one frame, as [`episodes::point_cloud::PointCloud`] has them.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Points {
    pub positions_m: Vec<f32>,
    pub colors: Vec<u8>,
    pub instance_ids: Vec<u16>,
}

struct Point {
    at_m: Vec3,
    color: [u8; 3],
    instance_id: u16,
}

/// `count` points of what the cameras see. They are repeated from the first on where fewer pixels show something, and
/// at the origin without an instance where none does.
pub(crate) fn points(views: &[CameraView], count: usize) -> Points {
    let shown = |(view, pixel): &(usize, usize)| {
        let view = &views[*view];
        view.ids[*pixel] != 0 && view.depth_m[*pixel] > 0.0
    };
    let pixels =
        views.iter().enumerate().flat_map(|(view, seen)| (0..seen.ids.len()).map(move |p| (view, p)));
    let pixels: Vec<(usize, usize)> = pixels.filter(shown).collect();
    let stride = (pixels.len() / (CHOICES * count).max(1)).max(1);
    let choices: Vec<Point> =
        pixels.iter().step_by(stride).map(|(view, pixel)| point(&views[*view], *pixel)).collect();
    let at_m: Vec<Vec3> = choices.iter().map(|point| point.at_m).collect();
    let chosen = farthest(&at_m, count);
    let mut points = Points { positions_m: Vec::new(), colors: Vec::new(), instance_ids: Vec::new() };
    let nothing = Point { at_m: Vec3::ZERO, color: [0; 3], instance_id: 0 };
    let in_order = chosen.iter().cycle().map(|index| &choices[*index]);
    for point in in_order.chain(std::iter::repeat(&nothing)).take(count) {
        points.positions_m.extend(point.at_m.to_array());
        points.colors.extend(point.color);
        points.instance_ids.push(point.instance_id);
    }
    points
}

/// The point in the center of a pixel.
fn point(view: &CameraView, pixel: usize) -> Point {
    let width_px = view.image.width_px() as usize;
    let (column, row) = (pixel % width_px, pixel / width_px);
    let [fx, _, cx, _, fy, cy, ..] = view.intrinsics;
    let depth_m = f64::from(view.depth_m[pixel]);
    let in_camera_m =
        [(column as f64 + 0.5 - cx) / fx * depth_m, (row as f64 + 0.5 - cy) / fy * depth_m, depth_m];
    let pose = &view.world_from_camera;
    let world = |axis: usize| {
        let row = &pose[4 * axis..4 * axis + 4];
        let turned: f64 = row.iter().zip(in_camera_m).map(|(entry, along_m)| entry * along_m).sum();
        (turned + row[3]) as f32
    };
    let rgba = &view.image.as_rgba()[4 * pixel..4 * pixel + 3];
    Point {
        at_m: Vec3::new(world(0), world(1), world(2)),
        color: [rgba[0], rgba[1], rgba[2]],
        instance_id: u16::try_from(view.ids[pixel]).unwrap_or(u16::MAX),
    }
}

/// Up to `count` places in the list, from the first on, each farthest from all before it.
fn farthest(at_m: &[Vec3], count: usize) -> Vec<usize> {
    let mut nearest_m2 = vec![f32::INFINITY; at_m.len()];
    let mut chosen = Vec::with_capacity(count.min(at_m.len()));
    let mut next = 0;
    while chosen.len() < count.min(at_m.len()) {
        chosen.push(next);
        let latest_m = at_m[next];
        // It stays chosen, also where others are at its place.
        nearest_m2[next] = f32::NEG_INFINITY;
        let mut farthest_m2 = f32::NEG_INFINITY;
        for (index, (nearest_m2, at_m)) in nearest_m2.iter_mut().zip(at_m).enumerate() {
            *nearest_m2 = nearest_m2.min(at_m.distance_squared(latest_m));
            if *nearest_m2 > farthest_m2 {
                (next, farthest_m2) = (index, *nearest_m2);
            }
        }
    }
    chosen
}

#[cfg(test)]
mod tests {
    use super::*;
    use imaging::Image;

    /// Sees from 1 m above straight down; the center of its 4 x 2 pixels is on the optical axis.
    fn view(ids: [u32; 8], depth_m: [f32; 8]) -> CameraView {
        let rgba = (0..8).flat_map(|pixel| [10 * pixel, 0, 100, 255]).collect();
        CameraView {
            image: Image::from_rgba(4, 2, rgba).expect("an image"),
            depth_m: depth_m.to_vec(),
            ids: ids.to_vec(),
            intrinsics: [2.0, 0.0, 2.0, 0.0, 2.0, 1.0, 0.0, 0.0, 1.0],
            #[rustfmt::skip]
            world_from_camera: [
                1.0, 0.0, 0.0, 0.0,
                0.0, -1.0, 0.0, 0.0,
                0.0, 0.0, -1.0, 1.0,
                0.0, 0.0, 0.0, 1.0,
            ],
        }
    }

    #[test]
    fn points_are_where_pixels_show_something() {
        let views = [view([0, 3, 0, 0, 0, 0, 0, 2], [1.0, 0.5, 1.0, 1.0, 1.0, 1.0, 1.0, 0.9])];
        let points = points(&views, 5);
        assert_eq!(points.instance_ids, [3, 2, 3, 2, 3], "repeated where there are too few");
        assert_eq!(points.colors[..6], [10, 0, 100, 70, 0, 100]);
        // Half a pixel left of the center and above it, half a meter down: a quarter of the depth.
        assert_eq!(points.positions_m[..3], [-0.125, 0.125, 0.5]);
        let second = &points.positions_m[3..6];
        assert!((second[0] - 0.675).abs() < 1e-6 && (second[1] + 0.225).abs() < 1e-6, "{second:?}");
        assert!((second[2] - 0.1).abs() < 1e-6, "{second:?}");
    }

    #[test]
    fn without_anything_in_sight_points_are_at_the_origin() {
        let points = points(&[view([0; 8], [0.0; 8])], 2);
        assert_eq!((points.positions_m, points.instance_ids), (vec![0.0; 6], vec![0, 0]));
    }

    #[test]
    fn each_point_is_the_farthest_from_those_before() {
        let line: Vec<Vec3> = (0..101).map(|x| Vec3::new(x as f32, 0.0, 0.0)).collect();
        assert_eq!(farthest(&line, 4), [0, 100, 50, 25]);
        let mut all = farthest(&line, 200);
        all.sort_unstable();
        assert_eq!(all, (0..101).collect::<Vec<_>>(), "each once");
        assert_eq!(farthest(&[Vec3::ONE; 3], 3).len(), 3, "also where they coincide");
        assert_eq!(farthest(&[], 3), Vec::<usize>::new());
    }
}
