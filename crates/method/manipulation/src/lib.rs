//! Robots that work in scenes: the simulated arm, grasps, and the execution of tasks.
//!
//! The world frame is right-handed with +z up and the table top at z = 0; lengths are meters, angles radians, masses
//! kilograms, forces newtons. Scenes come as [`physics::Body`] with `glam` types; robots come from the crate `robot`
//! with `nalgebra` types, and [`frames`] converts between them. Everything is a function of its arguments: equal
//! inputs and random numbers give equal bytes. The crate reads no clock, no file and no environment.
//!
//! - [`execution`]: a task as a sequence of picks and places, planned and simulated
//! - [`grasp`]: grasps of objects, tried in simulation
//! - [`link_meshes`]: what is seen of a robot
//! - [`world`]: an arm with a gripper among rigid bodies, simulated

pub mod execution;
pub mod frames;
pub mod grasp;
pub mod link_meshes;
pub mod mechanism;
mod swept;
pub mod world;
#[cfg(test)]
mod test_scenes;
