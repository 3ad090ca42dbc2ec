//! Result types of the image reader: camera, table top, objects.

use glam::DVec2;

use super::measured_depth::DepthUse;
use super::pixels::Pixels;
use super::shape_fit::{PosedPrimitive, PrimitiveKind};
use geometry::{Camera, Pose, Rgb};
use imaging::Mask;

/// Content of an image. Unit of length: width of the table top. Frame: origin at the center of the top, +z up, +x
/// to the right and +y away from the front edge.
#[derive(Clone, Debug)]
pub struct ImageReading {
    /// Camera of the whole image.
    pub camera: Camera,
    pub table: TableReading,
    /// Farthest first.
    pub objects: Vec<ObjectReading>,
    /// Masks, as large as the image, of what was found and does not stand on the table.
    pub left_out: Vec<Mask>,
    /// Pixels, as large as the image, of what stands on the table and is none of the objects.
    pub unread: Mask,
    /// Pixels, as large as the image, of the bare top.
    pub bare_top: Mask,
    /// Contribution of the depth image; `None` without one.
    pub depth: Option<DepthUse>,
}

/// Shape class of a table top.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TopShape {
    Rectangle,
    Circle,
    Oval,
    /// Three corners, rounded.
    Triangle,
    /// Any other outline, and every top that the image crops.
    Irregular,
}

/// The table top.
#[derive(Clone, Debug)]
pub struct TableReading {
    pub shape: TopShape,
    /// Depth in widths; 1 for a circle.
    pub depth: f64,
    /// Edge of the top, counter-clockwise.
    pub outline: Vec<DVec2>,
    /// Edge in pixels of the image, in the order of growing angle.
    pub outline_px: Vec<DVec2>,
    /// Mean color of the bare top.
    pub color: Rgb,
    /// Height above the floor in widths; `None` if the feet are not visible.
    pub height: Option<f64>,
    /// Overlap of the shape with the predicted outline, 0..1.
    pub fit: f64,
}

/// One object on the table.
#[derive(Clone, Debug)]
pub struct ObjectReading {
    /// Visible pixels, as large as the image.
    pub mask: Mask,
    /// Fitted primitive. For an object on another object it stands on the table along the same rays.
    pub solid: PosedPrimitive,
    /// Mean color.
    pub color: Rgb,
    /// Index of the supporting object in [`ImageReading::objects`]; `None` = the table.
    pub stands_on: Option<usize>,
}

impl ImageReading {
    /// Scale of an object relative to its primitive on the table: less than 1 for an object on another one, which
    /// is nearer to the camera; 1 on the table.
    pub fn support_scale(&self, index: usize) -> f64 {
        let (mut at, mut height) = (self.objects[index].stands_on, 0.0);
        for _ in 0..self.objects.len() {
            let Some(k) = at else { break };
            height += self.objects[k].solid.size.z;
            at = self.objects[k].stands_on;
        }
        let eye = self.camera.world_from_camera.translation_m.z;
        ((eye - height) / eye).clamp(0.2, 1.0)
    }

    /// The reading with all lengths multiplied, for example by the width of the top in meters.
    pub fn scaled(mut self, factor: f64) -> Self {
        let pose = &mut self.camera.world_from_camera;
        *pose = Pose { translation_m: factor * pose.translation_m, rotation: pose.rotation };
        self.table.height = self.table.height.map(|h| factor * h);
        self.table.outline.iter_mut().for_each(|p| *p *= factor);
        self.objects.iter_mut().for_each(|object| object.solid = object.solid.scaled(factor));
        if let Some(DepthUse::Used { meters_per_unit, .. }) = &mut self.depth {
            *meters_per_unit /= factor;
        }
        self
    }

    /// Meters per unit of the reading as a depth image measured them.
    pub fn measured_meters_per_unit(&self) -> Option<f64> {
        match self.depth {
            Some(DepthUse::Used { meters_per_unit, .. }) => Some(meters_per_unit),
            Some(DepthUse::Unused(_)) | None => None,
        }
    }
}

/// The camera of the image, from that of the working copy. Without a stated principal point it is the center.
pub(crate) fn whole_image(
    camera: &Camera,
    center_px: Option<DVec2>,
    [width_px, height_px]: [u32; 2],
    scale: f64,
) -> Camera {
    let center_px = center_px.unwrap_or(0.5 * DVec2::new(f64::from(width_px), f64::from(height_px)));
    Camera {
        width_px,
        height_px,
        fx: camera.fx / scale,
        fy: camera.fy / scale,
        cx: center_px.x,
        cy: center_px.y,
        world_from_camera: camera.world_from_camera,
    }
}

/// Estimated support of an object.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SupportEstimate {
    /// Center of its footprint in the image.
    pub base_px: DVec2,
    /// Height of the support above the table; 0 = the table.
    pub height: f64,
}

/// Range of an object's support height, as a share of the supporting object's height.
const SUPPORT_HEIGHT_RANGE: [f64; 2] = [0.35, 2.5];

/// Assigns the support of each object: another object whose top face contains the contact point.
///
/// With support estimates (one [`SupportEstimate`] per object) the support height must be near the height of that
/// face, and the footprint center may lie on the face instead of the contact point.
pub(crate) fn assign_supports(
    objects: &mut [ObjectReading],
    camera: &Camera,
    stands: Option<&[SupportEstimate]>,
) {
    let contacts: Vec<Option<DVec2>> = objects
        .iter()
        .map(|object| {
            let [x0, _, x1, y1] = object.mask.bbox_px()?;
            let lowest = (x0..x1).filter(|&x| object.mask.contains(x, y1 - 1)).collect::<Vec<_>>();
            let center = *lowest.get(lowest.len() / 2)?;
            Some(DVec2::new(f64::from(center) + 0.5, f64::from(y1)))
        })
        .collect();
    let tops: Vec<Vec<DVec2>> = objects.iter().map(|object| top_face(&object.solid, camera)).collect();
    let supports: Vec<Option<usize>> = (0..objects.len())
        .map(|i| {
            let carries = |j: usize, p: DVec2| {
                tops[j].len() > 2
                    && super::polygon::contains(&tops[j], p)
                    && objects[j].mask.area_px() > objects[i].mask.area_px() / 3
            };
            let others = (0..objects.len()).filter(|&j| j != i);
            let Some(stand) = stands.map(|stands| stands[i]) else {
                let contact = contacts[i]?;
                return others.into_iter().find(|&j| carries(j, contact));
            };
            let share = |j: usize| stand.height / objects[j].solid.size.z.max(1e-9);
            let [lowest, highest] = SUPPORT_HEIGHT_RANGE;
            others
                .filter(|&j| {
                    carries(j, stand.base_px) || contacts[i].is_some_and(|contact| carries(j, contact))
                })
                .filter(|&j| (lowest..=highest).contains(&share(j)))
                .min_by(|&a, &b| share(a).ln().abs().total_cmp(&share(b).ln().abs()))
        })
        .collect();
    for (object, support) in objects.iter_mut().zip(supports) {
        object.stands_on = support;
    }
    // Two objects cannot support each other: the smaller one lies on top.
    for i in 0..objects.len() {
        if let Some(j) = objects[i].stands_on
            && objects[j].stands_on.is_some()
            && objects[j].mask.area_px() >= objects[i].mask.area_px()
        {
            objects[j].stands_on = None;
        }
    }
    for i in 0..objects.len() {
        let mut at = i;
        for _ in 0..objects.len() {
            match objects[at].stands_on {
                Some(next) => at = next,
                None => break,
            }
        }
        if objects[at].stands_on.is_some() {
            objects[i].stands_on = None;
        }
    }
}

/// Outline of a primitive's top face in the image; empty for kinds that support nothing.
fn top_face(solid: &PosedPrimitive, camera: &Camera) -> Vec<DVec2> {
    if matches!(solid.kind, PrimitiveKind::Upright { .. } | PrimitiveKind::Inflated { .. }) {
        return Vec::new();
    }
    let corners = solid.footprint();
    let corners = corners.iter().map(|p| camera.project(p.extend(solid.size.z)).map(|(pixel, _)| pixel));
    let corners: Option<Vec<DVec2>> = corners.collect();
    super::polygon::convex_hull(&corners.unwrap_or_default())
}

/// Mean in linear light, as sRGB.
pub(crate) fn mean_color(pixels: &Pixels, indices: &[usize]) -> Rgb {
    let mut sum = [0.0_f64; 3];
    for &index in indices {
        (0..3).for_each(|c| sum[c] += f64::from(pixels.log_light[index][c].exp()));
    }
    Rgb(sum.map(|s| {
        let light = (s / indices.len().max(1) as f64) as f32;
        if light <= 0.003_130_8 { 12.92 * light } else { 1.055 * light.powf(1.0 / 2.4) - 0.055 }
    }))
}
