//! Places for bodies that do not stay where they fall.

use glam::DVec2;

use super::{EDGE_M, Heap, TABLE, footprint};
use crate::resolve::inside;
use geometry::Pose;
use geometry::drop_cast::{PosedShape, are_closer, drop_height};

/// Distance between candidate places, meters.
const STEP_M: f64 = 0.015;

/// Free space around a body that is set down, meters.
const CLEARANCE_M: f64 = 0.004;

impl Heap<'_> {
    /// The pose before everything, moved to the nearest place of the table that is free; where it was if none is.
    pub(super) fn free_place(&self, body: usize) -> Pose {
        let before = self.problem.bodies[body].world_from_object;
        let others = self.placed(body);
        let table = [PosedShape {
            shape: &self.shapes[TABLE],
            world_from_object: self.problem.bodies[TABLE].world_from_object,
        }];
        let (low, high) = self.problem.outline.bounds();
        let rings = ((high - low).length() / STEP_M).ceil() as u32;
        for ring in 0..rings {
            let count = if ring == 0 { 1 } else { 6 + 4 * ring.min(16) };
            for k in 0..count {
                let turn_rad = std::f64::consts::TAU * f64::from(k) / f64::from(count);
                let mut pose = before;
                pose.translation_m += (DVec2::from_angle(turn_rad) * STEP_M * f64::from(ring)).extend(0.0);
                let outline = footprint(&self.shapes[body], &pose);
                if inside::missing(self.problem.outline, &outline, 0.4 * EDGE_M).0 > 0.0 {
                    continue;
                }
                let xy = pose.translation_m.truncate();
                let Some(z) = drop_height(&self.shapes[body], pose.rotation, xy, &table) else { continue };
                pose.translation_m.z = z + 0.0005;
                let own = PosedShape { shape: &self.shapes[body], world_from_object: pose };
                // The table is the first.
                if !others[1..].iter().any(|other| are_closer(&own, other, CLEARANCE_M)) {
                    return pose;
                }
            }
        }
        before
    }
}
