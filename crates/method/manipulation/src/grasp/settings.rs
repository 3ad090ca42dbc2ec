//! Settings of the search for grasps and of their trials.

use serde::{Deserialize, Serialize};

/// Section `[grasps]`: settings of [`grasps`](super::grasps).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GraspSettings {
    /// Points drawn on the surface.
    pub surface_points: usize,
    /// Angles about the closing line from which the hand comes.
    pub approach_angles: usize,
    /// Difference between the greatest opening and the thickest object, meters.
    pub opening_margin_m: f64,
    /// The pads open by so much more than the object is thick on each side, where the gripper allows, meters.
    pub clearance_m: f64,
    /// Length of the straight motion of the hand to the object, meters.
    pub approach_m: f64,
    /// Distance that the hand keeps from the table, meters.
    pub table_gap_m: f64,
    /// The most candidates that are kept.
    pub max_candidates: usize,
    /// The most candidates that are tried in simulation.
    pub max_trials: usize,
    /// The most further candidates that are tried where none of these was stable.
    pub max_more_trials: usize,
    /// Trials end when so many were stable.
    pub wanted_stable: usize,
    pub trial: TrialSettings,
}

/// Section `[grasps.trial]`: what a trial does with a grasped object.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TrialSettings {
    /// Closing speed of each finger, m/s.
    pub closing_speed_m_s: f64,
    /// Height to which the object is lifted, meters.
    pub lift_m: f64,
    /// Duration of the lift, seconds.
    pub lift_s: f64,
    /// The amplitude of shaking along each axis of the world, meters.
    pub shake_m: f64,
    /// Frequency of shaking, hertz.
    pub shake_hz: f64,
    /// Duration of shaking, seconds.
    pub shake_s: f64,
    /// Duration of the hold at rest, seconds.
    pub hold_s: f64,
    /// The gripped point may move so much in the hand while it is shaken, meters.
    pub max_slip_m: f64,
    /// The object may turn so much in the hand from when it was gripped, radians.
    pub max_turn_rad: f64,
}
