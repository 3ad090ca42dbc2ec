//! A robot as files for simulators: URDF, MJCF and USD, made of its own primitives.
//!
//! All three have the same links, joints, limits, masses, shapes and tool frame. Link names are those of the robot's
//! file. What differs is stated in the module of each format.

mod in_scene;
mod mjcf;
mod numbers;
mod urdf;
mod usd;

use crate::model::Robot;
use crate::model::checked_pairs;

pub use in_scene::{mjcf_prefix, write_mjcf_in_scene, write_urdf_in_scene, write_usd_in_scene};
pub use mjcf::write_mjcf;
pub use urdf::write_urdf;
pub use usd::write_usd;

/// The contact settings of the MJCF file: without them, MuJoCo lets what is gripped creep.
pub mod contact {
    pub const TIMESTEP_S: f64 = 0.002;
    /// Ratio of frictional to normal constraint impedance.
    pub const IMPRATIO: f64 = 10.0;
    pub const NOSLIP_ITERATIONS: u32 = 10;
    /// Time constant and damping ratio of the equality between the fingers.
    pub const MIMIC_SOLREF: [f64; 2] = [0.005, 1.0];
    /// Time constant and damping ratio of contacts of pads, and their impedance: a grip of 40 N sinks in by 0.1 mm.
    pub const PAD_SOLREF: [f64; 2] = [0.004, 1.0];
    pub const PAD_SOLIMP: [f64; 3] = [0.95, 0.99, 0.001];
    /// The weight of a pad's contact parameters against those of what it touches.
    pub const PAD_SOLMIX: f64 = 1000.0;
    /// Torsional and rolling friction of all shapes, in meters.
    pub const TORSIONAL_FRICTION_M: f64 = 0.005;
    pub const ROLLING_FRICTION_M: f64 = 0.0001;
    /// Sliding friction of shapes that are no pads.
    pub const HOUSING_FRICTION: f64 = 0.3;
}

/// The pairs of links with colliding shapes that need no check: simulators must not let them collide either.
fn excluded_pairs(robot: &Robot) -> Vec<(usize, usize)> {
    let checked = checked_pairs(robot);
    let collides = |index: &usize| robot.links()[*index].shapes.iter().any(|shape| shape.collides());
    let colliding: Vec<usize> = (0..robot.links().len()).filter(collides).collect();
    let pairs =
        colliding.iter().flat_map(|a| colliding.iter().filter(move |b| a < *b).map(move |b| (*a, *b)));
    pairs.filter(|pair| !checked.contains(pair)).collect()
}

/// The name of the file's model: that of the robot, with its variant.
fn model_name(robot: &Robot) -> String {
    match robot.variant() {
        Some(variant) => format!("{}_{variant}", robot.name()),
        None => robot.name().to_owned(),
    }
}

#[cfg(test)]
mod tests;
