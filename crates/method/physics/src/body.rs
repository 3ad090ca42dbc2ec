//! A rigid body of the simulation.

use geometry::{ConvexHull, Friction, MassProperties, Pose};

/// One object (or the table) with its collision geometry and physical properties.
#[derive(Clone, Debug, PartialEq)]
pub struct Body {
    /// Name in errors and reports.
    pub name: String,
    /// Collision geometry in the object's frame, meters.
    pub hulls: Vec<ConvexHull>,
    pub world_from_object: Pose,
    pub mass: MassProperties,
    /// Simulation takes the dynamic coefficient, as the exported formats with one number do.
    pub friction: Friction,
    /// 0 = no bounce.
    pub restitution: f64,
    /// Rolling friction as a length (MuJoCo's convention), meters; 0 = rolls freely.
    pub rolling_friction_m: f64,
    /// Never moves (the table).
    pub fixed: bool,
}
