//! Robot arms as data, and what follows from the data: kinematics, collision, planning, trajectories, files.
//!
//! A robot is a file in `config/robots/`; nothing here knows the name of one. Lengths are meters, angles radians,
//! masses kilograms, times seconds, and matrices are those of nalgebra. Kinematics compute in `f64`; the collision
//! checks of the planner compute eight configurations at a time in `f32`. The crate depends on no other crate of the
//! workspace and reads no clock, no file and no environment.

pub mod collision;
pub mod export;
pub mod inverse;
pub mod kinematics;
pub mod model;
pub mod planning;
pub mod trajectory;
