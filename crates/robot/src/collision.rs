//! Collision of a robot's spheres with obstacles and with each other.
//!
//! The planner asks a fast checker that computes eight configurations at a time in `f32`: coarse spheres before fine
//! ones, and only against obstacles whose boxes are near. A slow check in `f64` measures exact distances; it verifies
//! what was planned. All positions are in the frame of the robot's base, in meters.

pub mod lanes;
mod sine;
