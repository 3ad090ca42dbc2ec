//! Resolution of the simulation of a world.

use serde::{Deserialize, Serialize};

/// Settings of a simulation with contacts that hold objects.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WorldOptions {
    /// Steps per simulated second; with fewer, gripped objects creep.
    pub steps_per_s: f64,
    /// Solver iterations per step.
    pub solver_iterations: usize,
    /// Number of passes per solver iteration that compute velocities without pushing overlaps apart; more of them let
    /// friction converge where several points of a pad share the force.
    pub friction_iterations: usize,
    /// Natural frequency of contacts, hertz; more is stiffer. At most a quarter of steps times iterations.
    pub contact_frequency_hz: f64,
    /// Typical size of objects, meters; scales the engine's tolerances.
    pub length_unit_m: f64,
    /// Damping of the linear and angular velocity of objects, 1/s.
    pub damping_per_s: f64,
}

impl Default for WorldOptions {
    /// 500 steps a second with 8 iterations: a box of 500 g between pads that are shaken slips by less than a
    /// micrometer. The engine makes contacts as stiff as the lighter body allows: at 700 Hz a nut of 2 g between pads
    /// yields by a millimeter to 40 N.
    fn default() -> Self {
        Self {
            steps_per_s: 500.0,
            solver_iterations: 8,
            friction_iterations: 1,
            contact_frequency_hz: 700.0,
            length_unit_m: 0.02,
            damping_per_s: 0.05,
        }
    }
}

impl WorldOptions {
    /// For trials of grasps, where a millimeter decides: with a single friction iteration, objects with several points
    /// of contact creep by a millimeter or more while they are shaken; more than four change nothing.
    pub fn for_trials() -> Self {
        Self { friction_iterations: 4, ..Self::default() }
    }
}
