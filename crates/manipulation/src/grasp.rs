//! Grasps of an object with the gripper of a robot: antipodal candidates, checked against shapes, tested in physics.
//!
//! Points of the surface are drawn evenly by area. A line through such a point, along its normal or the horizontal
//! nearest to it, leaves the object at an opposite point; if both normals are within the cone of friction and the
//! pads open wide enough, the fingers can close there (antipodal grasps: Nguyen, "Constructing force-closure grasps",
//! 1988). The hand comes from several angles about that line. Candidates with the best score whose hand touches
//! neither object nor table, while it approaches, opened, or closed, are tried in simulation: the hand closes, lifts
//! the object, shakes and holds it. Grasps that keep the object are stable.
//!
//! The object stands as its `world_from_object` says, on a plane at its lowest point. Grasps are given in the frame of
//! the object; z of the tool points away from the arm, and the fingers close along y. A grasp and its mirror image,
//! turned by half a turn about z of the tool, are one grasp; users may turn it.

mod antipodal;
mod export;
mod hand_shape;
mod patch;
mod settings;
mod solid;
mod trial;

use geometry::{DVec3, Pose};
use physics::Body;
use rand::Rng;
use robot::model::Robot;
use serde::{Deserialize, Serialize};

use crate::world::{WorldError, WorldOptions};
use antipodal::{Candidate, candidates};

pub(crate) use export::gripper_joint;
pub use export::{grasp_file, isaac_grasp_yaml};
pub use hand_shape::HandShape;
pub use scene::grasps::GraspVerdict as Verdict;
pub use settings::{GraspSettings, TrialSettings};
pub use solid::HullSolid;
pub use trial::{TrialResult, try_grasp, try_grasp_with};

/// A grasp of one object.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Grasp {
    /// The tool when the fingers have closed.
    pub object_from_tool: Pose,
    /// How far the pads are apart when they hold the object.
    pub opening_m: f64,
    /// How far they are apart when the hand approaches.
    pub pregrasp_opening_m: f64,
    /// With how much force each pad presses, newtons.
    pub force_n: f64,
    /// 0..=1: the score of the candidate, and above 0.5 only if it was stable.
    pub confidence: f64,
    pub verdict: Verdict,
    /// How far the gripped point moved in the hand while it was shaken; 0 if it was not tried.
    pub slip_m: f64,
    /// By how much the object turned in the hand from when it was gripped; 0 if it was not tried.
    pub turn_rad: f64,
}

/// Finds grasps of an object, the stable ones first, each group by falling confidence.
///
/// Candidates are tried in the order of their score until enough are stable. Equal arguments and random numbers give
/// equal grasps. Tens of milliseconds, and about a quarter of a second for each trial.
///
/// # Errors
/// If the object cannot be simulated: a hull is broken, or its mass is not positive.
pub fn grasps(
    object: &Body,
    robot: &Robot,
    settings: &GraspSettings,
    rng: &mut impl Rng,
) -> Result<Vec<Grasp>, WorldError> {
    let hand = HandShape::new(robot);
    let found = candidates(object, &hand, settings, rng);
    let mut grasps = Vec::with_capacity(found.len());
    let (mut stable, mut tried) = (0, 0);
    for candidate in &found {
        let mut grasp = untested(candidate, robot.gripper().grip_force_n);
        if stable < settings.wanted_stable && tried < settings.max_trials {
            tried += 1;
            let result = try_grasp(object, robot, &grasp, &settings.trial, &WorldOptions::default())?;
            (grasp.verdict, grasp.slip_m, grasp.turn_rad) = (result.verdict, result.slip_m, result.turn_rad);
            grasp.force_n = result.force_n;
            if let Some(opening_m) = result.opening_m {
                grasp.opening_m = opening_m;
            }
            if grasp.verdict == Verdict::Stable {
                stable += 1;
                grasp.confidence = 0.5 + 0.5 * candidate.score;
            }
        }
        grasps.push(grasp);
    }
    let rank = |grasp: &Grasp| match grasp.verdict {
        Verdict::Stable => 0,
        Verdict::Untested => 1,
        Verdict::Slipped => 2,
        Verdict::Dropped => 3,
    };
    grasps.sort_by(|a, b| rank(a).cmp(&rank(b)).then(b.confidence.total_cmp(&a.confidence)));
    Ok(grasps)
}

/// The candidates of [`grasps`] by falling score, none of them tried. Tens of milliseconds.
pub fn untested_grasps(
    object: &Body,
    robot: &Robot,
    settings: &GraspSettings,
    rng: &mut impl Rng,
) -> Vec<Grasp> {
    let found = candidates(object, &HandShape::new(robot), settings, rng);
    found.iter().map(|candidate| untested(candidate, robot.gripper().grip_force_n)).collect()
}

fn untested(candidate: &Candidate, force_n: f64) -> Grasp {
    Grasp {
        object_from_tool: candidate.object_from_tool,
        opening_m: candidate.width_m,
        pregrasp_opening_m: candidate.pregrasp_opening_m,
        force_n,
        confidence: 0.5 * candidate.score,
        verdict: Verdict::Untested,
        slip_m: 0.0,
        turn_rad: 0.0,
    }
}

impl Grasp {
    /// The direction in which the hand approaches, in the frame of the object.
    pub fn approach(&self) -> DVec3 {
        self.object_from_tool.transform_vector(DVec3::Z)
    }

    /// The same grasp with the fingers swapped.
    pub fn mirrored(&self) -> Self {
        let half_turn = Pose::upright(DVec3::ZERO, std::f64::consts::PI);
        Self { object_from_tool: self.object_from_tool * half_turn, ..*self }
    }
}

#[cfg(test)]
mod tests;
