//! Limits of the objects that a robot can grasp and lift, as numbers.

use std::collections::BTreeMap;

use geometry::parallel_grasp::{Gripper, parallel_grasp};
use geometry::shells::Shell;
use geometry::solid_query::MeshSolid;
use glam::DVec2;
use scene::InstanceId;
use serde::{Deserialize, Serialize};

use crate::convex_width::narrowest_width_m;
use crate::posed_object::ObjectShape;

/// Coefficient of friction between finger and object.
const FRICTION: f64 = 0.5;

/// The limits of a robot that decide whether it can move an object.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RobotLimits {
    /// As tasks name it.
    pub name: String,
    /// Widest distance between the fingers, meters.
    pub max_opening_m: f64,
    /// Opening that must stay free on both sides together, meters.
    pub opening_margin_m: f64,
    /// Largest mass that it lifts, kilograms.
    pub max_payload_kg: f64,
    /// Objects of the scene whose grasps were tried in simulation, and whether one of them held. It decides whether the
    /// robot can grasp these; the width decides for the others.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub held: BTreeMap<InstanceId, bool>,
}

impl RobotLimits {
    /// Limits of a robot that has tried no grasp.
    pub fn new(
        name: impl Into<String>,
        max_opening_m: f64,
        opening_margin_m: f64,
        max_payload_kg: f64,
    ) -> Self {
        Self { name: name.into(), max_opening_m, opening_margin_m, max_payload_kg, held: BTreeMap::new() }
    }

    /// Widest object between the fingers, meters.
    pub fn max_width_m(&self) -> f64 {
        self.max_opening_m - self.opening_margin_m
    }
}

/// Width at which a gripper can grasp a shape in its upright pose, or the width that is too much.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum GraspWidth {
    /// Distance between the fingers, meters.
    Fits(f64),
    /// Between its narrowest sides, meters; no narrower part can be grasped.
    TooWide(f64),
}

/// The width at which a gripper grasps a shape, at most `widest_m` ([`RobotLimits::max_width_m`]): between its
/// narrowest sides, or where [`parallel_grasp`] finds a grasp on its hulls (a wall, a handle). Takes milliseconds. What
/// is too wide by this may have a grasp that holds nevertheless, across a part of a round object.
pub fn grasp_width(shape: &ObjectShape, widest_m: f64) -> GraspWidth {
    let narrowest_m = narrowest_m(shape);
    if narrowest_m <= widest_m {
        return GraspWidth::Fits(narrowest_m);
    }
    let shells: Vec<Shell> = shape
        .hulls()
        .iter()
        .map(|hull| Shell { points: hull.points.clone(), triangles: hull.triangles.clone() })
        .collect();
    let Ok(solid) = MeshSolid::from_shells(&shells) else {
        return GraspWidth::TooWide(narrowest_m);
    };
    let gripper = Gripper { opening_m: widest_m, ..Gripper::COMMON };
    match parallel_grasp(&solid, shape.hulls(), shape.center_of_mass_m, FRICTION, gripper) {
        Some(grasp) => GraspWidth::Fits(grasp.contacts_m[0].distance(grasp.contacts_m[1])),
        None => GraspWidth::TooWide(narrowest_m),
    }
}

/// Smallest horizontal width of the whole object in its upright pose, meters.
pub fn narrowest_m(shape: &ObjectShape) -> f64 {
    let points: Vec<DVec2> =
        shape.hulls().iter().flat_map(|hull| &hull.points).map(|point| point.truncate()).collect();
    narrowest_width_m(&points)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_scenes::{container, solid_box};

    #[test]
    fn narrow_side_and_wall_are_grasped() {
        let width = |object: crate::PosedObject| grasp_width(&object.shape, 0.075);
        assert!(
            matches!(width(solid_box("a", [0.2, 0.05, 0.1], [0.0; 3])), GraspWidth::Fits(w) if (w - 0.05).abs() < 1e-6)
        );
        assert!(
            matches!(width(solid_box("a", [0.2, 0.15, 0.1], [0.0; 3])), GraspWidth::TooWide(w) if w > 0.075)
        );
        // A wall of 4 mm.
        assert!(matches!(width(container("a", [0.2, 0.15, 0.1], [0.0; 3])), GraspWidth::Fits(w) if w < 0.02));
    }
}
