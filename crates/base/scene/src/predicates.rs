//! Predicates: whether posed objects satisfy relations, arrangements and requests of a description.
//!
//! Objects are convex footprints on the table with a yaw and a height range, in the world frame (meters, radians; x to
//! the right, y to the back). Directions are as seen from the front edge. Each test has a documented tolerance that a
//! settled scene meets; the layout aims closer. Pure functions; a comparison of two footprints costs the product of
//! their corners.

mod arrangements;
mod places;
mod unmet;

use std::f64::consts::{FRAC_PI_2, PI};

use glam::{DVec2, DVec3};

use crate::description::RelationKind;
pub use arrangements::{arrangement_holds, pyramid_layers};
use geometry::polygon::{convex_distance_m, convex_hull_2d, depth_in_convex_m};
use geometry::pose::wrap_angle_rad;
use geometry::{Outline, Pose};
pub use places::{edge_distance_m, is_at_place, place_shares};
pub use unmet::{Unmet, UnmetDemand, unmet};

/// Tolerance of stated distances, meters.
pub const DISTANCE_TOLERANCE_M: f64 = 0.01;
/// Tolerance of stated yaws and of facing, radians (10 degrees).
pub const YAW_TOLERANCE_RAD: f64 = PI / 18.0;
/// Tolerance of a stated position of the center, meters.
pub const POSITION_TOLERANCE_M: f64 = 0.02;
/// Free distance up to which an object is next to another one without a stated distance, meters.
pub const NEXT_TO_M: f64 = 0.15;
/// Free distance up to which an object is around another one, meters.
pub const AROUND_M: f64 = 0.5;
/// Vertical tolerance of contacts, meters.
pub const CONTACT_TOLERANCE_M: f64 = 0.015;

/// Overlap that a direction still permits, meters.
const MAX_DIRECTION_OVERLAP_M: f64 = 0.015;

/// The vertical projection of a posed object, with its yaw and height range.
#[derive(Clone, Debug, PartialEq)]
pub struct PosedFootprint {
    corners: Vec<DVec2>,
    center: DVec2,
    /// Rotation about the vertical axis; at 0 the front faces the front edge.
    pub yaw_rad: f64,
    /// Lowest point above the table top, meters.
    pub bottom_m: f64,
    /// Highest point above the table top, meters.
    pub top_m: f64,
}

impl PosedFootprint {
    /// The convex hull of the projected points.
    pub fn new(points: &[DVec2], yaw_rad: f64, bottom_m: f64, top_m: f64) -> Self {
        let corners = convex_hull_2d(points);
        let first = corners.first().copied().unwrap_or_default();
        let (low, high) = corners.iter().fold((first, first), |(l, h), &c| (l.min(c), h.max(c)));
        Self { corners, center: 0.5 * (low + high), yaw_rad, bottom_m, top_m }
    }

    /// The projection of points in the world, meters, of an object in that pose. A pose without a yaw has yaw 0.
    pub fn of_points(world_points: impl IntoIterator<Item = DVec3>, world_from_object: &Pose) -> Self {
        let (mut bottom_m, mut top_m) = (f64::INFINITY, f64::NEG_INFINITY);
        let mut corners: Vec<DVec2> = Vec::new();
        for point in world_points {
            (bottom_m, top_m) = (bottom_m.min(point.z), top_m.max(point.z));
            corners.push(point.truncate());
        }
        Self::new(&corners, world_from_object.yaw_rad().unwrap_or(0.0), bottom_m, top_m)
    }

    /// Turned about the world's vertical axis.
    fn turned(&self, by_rad: f64) -> Self {
        let turn = DVec2::from_angle(by_rad);
        let corners: Vec<DVec2> = self.corners.iter().map(|corner| turn.rotate(*corner)).collect();
        Self::new(&corners, wrap_angle_rad(self.yaw_rad + by_rad), self.bottom_m, self.top_m)
    }

    /// Convex counter-clockwise.
    pub fn corners(&self) -> &[DVec2] {
        &self.corners
    }

    /// Center of the axis-aligned box.
    pub fn center(&self) -> DVec2 {
        self.center
    }

    /// Lowest and highest corner of the axis-aligned box.
    pub fn bounds(&self) -> (DVec2, DVec2) {
        self.corners.iter().fold((self.center, self.center), |(l, h), &c| (l.min(c), h.max(c)))
    }

    /// Extent from the center along a unit direction, meters.
    pub fn extent_m(&self, direction: DVec2) -> f64 {
        self.corners.iter().map(|c| (*c - self.center).dot(direction)).fold(0.0, f64::max)
    }

    /// Free distance to another footprint, meters; negative on overlap.
    pub fn distance_m(&self, other: &Self) -> f64 {
        convex_distance_m(&self.corners, &other.corners)
    }

    /// Direction of the long side: [`long_side_rad`].
    pub fn long_side_rad(&self) -> f64 {
        long_side_rad(&self.corners, self.yaw_rad)
    }

    /// World direction of the front.
    pub fn front(&self) -> DVec2 {
        DVec2::from_angle(self.yaw_rad - FRAC_PI_2)
    }
}

/// By so much a side is longer than the other one, as a factor, where an object has a long side.
const LONGER: f64 = 1.1;

/// Direction of the longer side of a convex footprint with that yaw, radians, up to half turns: that of its own x axis,
/// unless it is longer along y. A ruler parallel to a keyboard has parallel long sides.
pub fn long_side_rad(corners: &[DVec2], yaw_rad: f64) -> f64 {
    let extent_m = |direction: DVec2| {
        let along = corners.iter().map(|corner| corner.dot(direction));
        let range = (f64::INFINITY, f64::NEG_INFINITY);
        let (low, high) = along.fold(range, |(low, high), at| (low.min(at), high.max(at)));
        high - low
    };
    let x = DVec2::from_angle(yaw_rad);
    if extent_m(x.perp()) > LONGER * extent_m(x) { yaw_rad + FRAC_PI_2 } else { yaw_rad }
}

/// A relation between posed footprints.
#[derive(Clone, Copy, Debug)]
pub struct PosedRelation<'a> {
    pub kind: RelationKind,
    pub object: &'a PosedFootprint,
    /// `None` = the table.
    pub target: Option<&'a PosedFootprint>,
    pub second_target: Option<&'a PosedFootprint>,
    /// Stated free distance.
    pub distance_m: Option<f64>,
}

/// Whether a relation holds on a table with this outline.
///
/// - Left, right, front, behind: the center lies on that side within 45 degrees, or beside the target's extent; the
///   footprints overlap along the direction by at most 1.5 cm.
/// - With a distance: the free distance is as stated within [`DISTANCE_TOLERANCE_M`].
/// - Next to: at most [`NEXT_TO_M`] apart, not overlapping. Around: at most [`AROUND_M`] apart.
/// - Between: the center projects into the central third of the segment between the centers of the targets, at most a
///   quarter of its length (at least 2 cm) off, and overlaps neither.
/// - Facing: the front points to the target's center (without a target: to the table's) within
///   [`YAW_TOLERANCE_RAD`]. Parallel: the long sides are, within the same tolerance.
/// - On, stacked: the center is above the target and the bottom between the target's bottom and top. In: the same, and
///   the bottom is below the rim.
/// - Places and distances to edges: [`is_at_place`], [`edge_distance_m`].
///
/// A relation that needs a target and has none does not hold.
pub fn holds(relation: &PosedRelation, table: &Outline) -> bool {
    use RelationKind::{
        Around, Behind, Between, Facing, In, InFrontOf, LeftOf, NextTo, On, ParallelTo, RightOf, StackedOn,
    };
    let object = relation.object;
    let distance_holds = |target: &PosedFootprint, max_m: f64| {
        let free_m = object.distance_m(target);
        match relation.distance_m {
            Some(stated_m) => (free_m - stated_m).abs() <= DISTANCE_TOLERANCE_M,
            None => free_m <= max_m,
        }
    };
    match (relation.kind, relation.target) {
        (On | StackedOn, Some(target)) => {
            is_above(object, target)
                && object.bottom_m > target.bottom_m + 0.001
                && object.bottom_m <= target.top_m + CONTACT_TOLERANCE_M
        }
        (In, Some(target)) => {
            is_above(object, target)
                && object.bottom_m > target.bottom_m - 0.002
                && object.bottom_m < target.top_m
        }
        // Without a target the table is the supporter.
        (On | StackedOn | In, None) => object.bottom_m.abs() <= CONTACT_TOLERANCE_M,
        (LeftOf | RightOf | InFrontOf | Behind, Some(target)) => {
            direction_of(relation.kind).is_some_and(|way| is_toward(object, target, way))
                && distance_holds(target, f64::INFINITY)
        }
        (NextTo, Some(target)) => {
            distance_holds(target, NEXT_TO_M) && object.distance_m(target) > -DISTANCE_TOLERANCE_M
        }
        (Around, Some(target)) => distance_holds(target, AROUND_M),
        (Between, Some(first)) => {
            relation.second_target.is_some_and(|second| is_between(object, first, second))
        }
        (Facing, target) => {
            let (low, high) = table.bounds();
            let toward = target.map_or(0.5 * (low + high), PosedFootprint::center) - object.center;
            let off = wrap_angle_rad(toward.to_angle() - object.front().to_angle()).abs();
            toward.length() < 1e-6 || off <= YAW_TOLERANCE_RAD
        }
        (ParallelTo, target) => {
            let turn = object.long_side_rad() - target.map_or(0.0, PosedFootprint::long_side_rad);
            wrap_angle_rad(2.0 * turn).abs() <= 2.0 * YAW_TOLERANCE_RAD
        }
        (kind, None) => match edge_distance_m(kind, object, table) {
            Some(free_m) => match relation.distance_m {
                Some(stated_m) => (free_m - stated_m).abs() <= DISTANCE_TOLERANCE_M,
                None => free_m <= NEXT_TO_M,
            },
            None => is_at_place(kind, object.center, table).unwrap_or(false),
        },
        (_, Some(_)) => false,
    }
}

/// World direction of a directed relation; `None` for all others.
pub fn direction_of(kind: RelationKind) -> Option<DVec2> {
    Some(match kind {
        RelationKind::LeftOf => -DVec2::X,
        RelationKind::RightOf => DVec2::X,
        RelationKind::InFrontOf => -DVec2::Y,
        RelationKind::Behind => DVec2::Y,
        _ => return None,
    })
}

/// Yaw of what faces the person who sits at a point of the table: outside the nearest edge, facing inward. At the front
/// edge it is 0.
pub fn seat_yaw_rad(at: DVec2, table: &Outline) -> f64 {
    let outward = table.nearest_on_edge(at) - at;
    outward.try_normalize().map_or(0.0, |outward| wrap_angle_rad(outward.to_angle() + FRAC_PI_2))
}

fn is_toward(object: &PosedFootprint, target: &PosedFootprint, way: DVec2) -> bool {
    let offset = object.center - target.center;
    let along = offset.dot(way);
    let across = offset.dot(way.perp()).abs();
    let clear_m = along - object.extent_m(-way) - target.extent_m(way);
    along > 0.0 && clear_m >= -MAX_DIRECTION_OVERLAP_M && across <= along.max(target.extent_m(way.perp()))
}

fn is_between(object: &PosedFootprint, first: &PosedFootprint, second: &PosedFootprint) -> bool {
    let segment = second.center - first.center;
    let length_m = segment.length();
    if length_m < 1e-6 {
        return false;
    }
    let offset = object.center - first.center;
    let share = offset.dot(segment) / (length_m * length_m);
    let off_m = (offset.perp_dot(segment) / length_m).abs();
    (1.0 / 3.0..=2.0 / 3.0).contains(&share)
        && off_m <= (0.25 * length_m).max(0.02)
        && object.distance_m(first) >= 0.0
        && object.distance_m(second) >= 0.0
}

/// Whether the center lies above the target's footprint; 1 cm beyond its edge is tolerated.
fn is_above(object: &PosedFootprint, target: &PosedFootprint) -> bool {
    depth_in_convex_m(&target.corners, object.center) > -DISTANCE_TOLERANCE_M
}

#[cfg(test)]
mod tests;
