//! Model of a robot: its links, joints, limits and shapes, as read from a file, and the views that others compute with.
//!
//! `parse` makes a checked `Robot` from the format in `file`. `cover` computes spheres from shapes, and `ArmSpheres`
//! shows an arm to the planner as the `SphereModel` that it needs.

mod arm_spheres;
pub mod cover;
mod error;
mod file;
pub mod library;
pub mod limits;
pub mod link;
mod parse;
mod robot;
mod self_collision;
pub mod shape;
pub mod sphere_model;

pub use arm_spheres::ArmSpheres;
pub use error::ModelError;
pub use limits::JointLimits;
pub use link::{Inertia, Joint, JointDrive, JointMotion, Link, MovingJoint, MovingKind, PositionSource};
pub use robot::{Gripper, Home, IgnoredPair, Material, Robot, Tool};
pub use self_collision::checked_pairs;
pub use shape::{Primitive, Shape, ShapeRole};
pub use sphere_model::{LinkPose8, LinkPoses8, LinkSphere, SphereModel, Spheres8};
