//! Vertical drops of one body, shared by placement on supporters and in containers.

use glam::{DQuat, DVec2};

use super::Scene;
use geometry::Pose;
use geometry::drop_cast::{PosedShape, drop_height};

/// Center of the body's bounding box seen from above, world xy, meters.
pub(super) fn center_of(scene: &Scene, body: usize, poses: &[Pose]) -> DVec2 {
    let (low, high) = scene.shapes[body].bounds(&poses[body]);
    0.5 * (low + high).truncate()
}

/// Pose of the body with that rotation, dropped at `xy` onto the supporters; `None` if it hits none of them.
pub(super) fn dropped(
    scene: &Scene,
    body: usize,
    rotation: DQuat,
    xy: DVec2,
    supporters: &[PosedShape],
) -> Option<Pose> {
    let z = drop_height(&scene.shapes[body], rotation, xy, supporters)?;
    Some(Pose { translation_m: xy.extend(z), rotation })
}
