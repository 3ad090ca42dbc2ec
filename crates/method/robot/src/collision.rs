//! Collision of a robot's spheres with obstacles and with each other.
//!
//! The planner asks a fast checker that computes eight configurations at a time in `f32`: coarse spheres before fine
//! ones, and only against obstacles whose boxes are near. A slow check in `f64` measures exact distances; it verifies
//! what was planned. All positions are in the frame of the robot's base, in meters.
//!
//! - [`arm`]: joints and bodies of spheres; [`obstacle`], [`polyhedron`]: solids and exact distances
//! - [`checker`]: the fast check; [`lane_arm`], [`lane_world`]: its data; [`lanes`]: its arithmetic
//! - [`exact`]: clearances and certified paths

pub mod arm;
pub mod checker;
mod enclosing;
pub mod exact;
mod from_robot;
pub mod lane_arm;
mod lane_vector;
mod lane_world;
pub mod lanes;
pub mod obstacle;
pub mod polyhedron;
mod sine;
#[cfg(test)]
pub(crate) mod tests;

pub use arm::{Arm, ArmBody, ArmError, ArmJoint, JointMotion, Sphere};
pub use checker::Checker;
pub use exact::{Clearance, Contact, PathContact};
pub use obstacle::{Obstacle, ObstacleError};
pub use polyhedron::{ConvexPolyhedron, PolyhedronError};
