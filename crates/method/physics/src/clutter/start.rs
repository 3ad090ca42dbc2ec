//! Poses from which bodies fall.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use glam::{DQuat, DVec3};
use rand::RngExt;

use super::{DropRole, EDGE_M, Heap, MAX_DROPS, footprint};
use crate::resolve::inside;
use geometry::Pose;
use geometry::collision_shape::CollisionShape;
use geometry::drop_cast::drop_height;

/// Distance above the first contact, meters.
const GAP_M: f64 = 0.004;

/// Largest tilt of a body that falls on any side, radians, and of one that falls standing.
const TILT_RAD: f64 = 0.35;
const STANDING_TILT_RAD: f64 = 0.02;

/// Share of the bodies that are to fall standing which do.
const STANDING_SHARE: f64 = 0.9;

/// Places that are tried for a standing body, of which the lowest is taken: it needs level ground.
const STANDING_PLACES: usize = 8;

/// Places that are tried for others at the highest density, where they fill gaps; at low ones they fall anywhere.
const MAX_PLACES: f64 = 10.0;

/// Areas onto which a body falls for the first time and after failures, in regions.
const WIDENINGS: [usize; MAX_DROPS] = [1, 3, usize::MAX];

/// Horizontal distance to the table's edge is restored in this many shifts.
const SHIFTS: usize = 3;

/// The six sides of a body with the area that it covers on each.
pub(super) struct Sides {
    areas_m2: [f64; 6],
}

impl Sides {
    pub fn new(shape: &CollisionShape) -> Self {
        let area_m2 = |rotation| {
            let outline = footprint(shape, &Pose { translation_m: DVec3::ZERO, rotation });
            let corners = (0..outline.len()).map(|k| (outline[k], outline[(k + 1) % outline.len()]));
            0.5 * corners.map(|(a, b)| a.perp_dot(b)).sum::<f64>()
        };
        Self { areas_m2: rotations().map(area_m2) }
    }

    /// Mean area seen from above of a body that lies on a drawn side.
    pub fn mean_area_m2(&self) -> f64 {
        let weights = self.weights();
        let total: f64 = weights.iter().sum();
        self.areas_m2.iter().zip(weights).map(|(area_m2, weight)| area_m2 * weight).sum::<f64>() / total
    }

    /// Bodies fall on large sides more often: a book stands on its edge rarely.
    fn weights(&self) -> [f64; 6] {
        self.areas_m2.map(|area_m2| area_m2.max(1e-9).powi(2))
    }

    /// The rotation that turns a drawn side down.
    fn draw(&self, chance: f64) -> DQuat {
        let weights = self.weights();
        let mut left = chance * weights.iter().sum::<f64>();
        for (rotation, weight) in rotations().into_iter().zip(weights) {
            left -= weight;
            if left < 0.0 {
                return rotation;
            }
        }
        DQuat::IDENTITY
    }
}

/// Upright, upside down, and on the four other sides.
fn rotations() -> [DQuat; 6] {
    [
        DQuat::IDENTITY,
        DQuat::from_rotation_x(PI),
        DQuat::from_rotation_x(FRAC_PI_2),
        DQuat::from_rotation_x(-FRAC_PI_2),
        DQuat::from_rotation_y(FRAC_PI_2),
        DQuat::from_rotation_y(-FRAC_PI_2),
    ]
}

impl Heap<'_> {
    /// A random pose just above what lies below it: in the drop region, or after failures in a wider one.
    pub(super) fn draw_start(&mut self, body: usize) -> Pose {
        let role = self.problem.roles[body - 1];
        let is_standing = role == DropRole::Standing && self.rng.random_range(0.0..1.0) < STANDING_SHARE;
        let filling = self.problem.density.clamp(0.0, 1.0).powi(3);
        let places =
            if is_standing { STANDING_PLACES } else { 1 + ((MAX_PLACES - 1.0) * filling).round() as usize };
        let rotation = self.draw_rotation(body, is_standing);
        let widening = WIDENINGS[self.drops[body].clamp(1, MAX_DROPS) - 1];
        let mut best: Option<Pose> = None;
        for _ in 0..places {
            let center = self.region.draw(widening, &mut self.rng);
            let pose = self.above(body, rotation, center);
            if best.is_none_or(|other| pose.translation_m.z < other.translation_m.z) {
                best = Some(pose);
            }
        }
        best.unwrap_or(self.starts[body])
    }

    fn draw_rotation(&mut self, body: usize, is_standing: bool) -> DQuat {
        let yaw_rad = self.rng.random_range(0.0..TAU);
        let (way_rad, chance) = (self.rng.random_range(0.0..TAU), self.rng.random_range(0.0..1.0));
        let max_tilt_rad = if is_standing { STANDING_TILT_RAD } else { TILT_RAD };
        let tilt_rad = self.rng.random_range(0.0..max_tilt_rad);
        let axis = DVec3::new(way_rad.cos(), way_rad.sin(), 0.0);
        let side = match &self.sides[body] {
            Some(sides) if !is_standing => sides.draw(chance),
            _ => DQuat::IDENTITY,
        };
        DQuat::from_axis_angle(axis, tilt_rad) * DQuat::from_rotation_z(yaw_rad) * side
    }

    /// The body with its box centered at a place, moved inside the table's edge, above its first contact.
    fn above(&self, body: usize, rotation: DQuat, center: glam::DVec2) -> Pose {
        let shape = &self.shapes[body];
        let mut pose = Pose { translation_m: DVec3::ZERO, rotation };
        let (low, high) = shape.bounds(&pose);
        pose.translation_m = (center - 0.5 * (low + high).truncate()).extend(0.0);
        for _ in 0..SHIFTS {
            let (missing_m, way) =
                inside::missing(self.problem.outline, &footprint(shape, &pose), 0.4 * EDGE_M);
            if missing_m <= 0.0 {
                break;
            }
            pose.translation_m += way.extend(0.0);
        }
        let z = drop_height(shape, rotation, pose.translation_m.truncate(), &self.placed(body));
        pose.translation_m.z = z.unwrap_or(-low.z) + GAP_M;
        pose
    }
}
