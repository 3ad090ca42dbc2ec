//! Grasps of an object with the gripper of a robot: antipodal candidates, checked against shapes, tested in physics.
//!
//! Points of the surface are drawn evenly by area. A line through such a point, along its normal or the horizontal
//! nearest to it, leaves the object at an opposite point; if both normals are within the cone of friction and the
//! pads open wide enough, the fingers can close there (antipodal grasps: Nguyen, "Constructing force-closure grasps",
//! 1988). The hand comes from several angles about that line. Candidates with the best score whose hand touches
//! neither object nor table, while it approaches, opened, or closed, are tried in simulation: the hand closes, lifts
//! the object, shakes and holds it. Grasps that keep the object are stable. Where none is, those that slipped are tried
//! with less force, and then a second search has more candidates tried.
//!
//! The object stands as its `world_from_object` says, on a plane at its lowest point. Grasps are given in the frame of
//! the object; z of the tool points away from the arm, and the fingers close along y. A grasp and its mirror image,
//! turned by half a turn about z of the tool, are one grasp; users may turn it.

mod antipodal;
mod export;
mod hand_shape;
mod patch;
mod second_search;
mod settings;
mod solid;
mod trial;

use geometry::{DVec3, Pose};
use physics::Body;
use rand::Rng;
use robot::model::Robot;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::world::{WorldError, WorldOptions};
use antipodal::{Candidate, candidates};

use second_search::{Experience, excess, more_candidates};

pub(crate) use export::gripper_joint;
pub use export::{grasp_file, grasps_of_file, isaac_grasp_yaml};
pub use hand_shape::HandShape;
pub use scene::grasps::GraspVerdict as Verdict;
pub use settings::{GraspSettings, TrialSettings};
pub use solid::HullSolid;
pub use trial::{TrialResult, try_grasp, try_grasp_gently, try_grasp_with};

/// Of the grasps that slipped, so many are tried with less force before others are sought.
const EASY_TRIALS: usize = 6;
/// With so many stable grasps the second search ends: it finds the few of difficult objects, and each trial takes time.
const ENOUGH: usize = 3;

/// A grasp of one object.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(
    rename = "ExecutedGrasp",
    description = "A grasp of a parallel gripper; the tool closes along its y axis and comes along its z axis."
)]
pub struct Grasp {
    /// The tool when the fingers have closed.
    pub object_from_tool: Pose,
    /// Distance of the pads from each other when they hold the object, meters.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub opening_m: f64,
    /// Distance of the pads from each other when the hand approaches, meters.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub pregrasp_opening_m: f64,
    /// Force of each pad, newtons.
    #[schemars(range(min = 0.0, max = 10_000.0))]
    pub force_n: f64,
    /// 0..=1: the score of the candidate, and above 0.5 only if it was stable.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub confidence: f64,
    pub verdict: Verdict,
    /// Distance that the gripped point moved in the hand while it was shaken, meters; 0 if it was not tried.
    #[schemars(range(min = 0.0, max = 1000.0))]
    pub slip_m: f64,
    /// Angle by which the object turned in the hand since it was gripped, radians; 0 if it was not tried.
    #[schemars(range(min = 0.0, max = 3.2))]
    pub turn_rad: f64,
}

/// Finds grasps of an object, the stable ones first, each group by falling confidence.
///
/// Candidates are tried in the order of their score until enough are stable. Where none was, `max_more_trials` others
/// follow. Equal arguments and random numbers give equal grasps. Tens of milliseconds, and about a quarter of a second
/// for each trial.
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
        if stable < settings.wanted_stable && tried < settings.max_trials {
            tried += 1;
            let grasp = tried_grasp(object, robot, candidate, settings)?;
            stable += usize::from(grasp.verdict == Verdict::Stable);
            grasps.push(grasp);
        } else {
            grasps.push(untested(candidate, robot.gripper().grip_force_n));
        }
    }
    if stable == 0 && tried > 0 && settings.max_more_trials > 0 {
        try_more(object, robot, settings, &hand, &mut grasps, rng)?;
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

/// Tries the best grasps with less force, then candidates of the second search, where no grasp was stable.
fn try_more(
    object: &Body,
    robot: &Robot,
    settings: &GraspSettings,
    hand: &HandShape,
    grasps: &mut Vec<Grasp>,
    rng: &mut impl Rng,
) -> Result<(), WorldError> {
    let mut stable = 0;
    let mut held: Vec<usize> =
        (0..grasps.len()).filter(|&index| grasps[index].verdict == Verdict::Slipped).collect();
    held.sort_by(|&a, &b| excess(&grasps[a], settings).total_cmp(&excess(&grasps[b], settings)));
    for index in held.into_iter().take(EASY_TRIALS) {
        if stable < settings.wanted_stable {
            stable += usize::from(made_stable(object, robot, &mut grasps[index], settings)?);
        }
    }
    if stable > 0 {
        return Ok(());
    }
    let mut experience = Experience::default();
    for grasp in grasps.iter().filter(|grasp| grasp.verdict != Verdict::Untested) {
        experience.add(grasp, settings);
    }
    let mut more = more_candidates(object, hand, settings, rng);
    for _ in 0..settings.max_more_trials {
        let Some(candidate) = experience.take_best(&mut more) else { break };
        let mut grasp = tried_grasp(object, robot, &candidate, settings)?;
        if grasp.verdict == Verdict::Slipped {
            made_stable(object, robot, &mut grasp, settings)?;
        }
        experience.add(&grasp, settings);
        stable += usize::from(grasp.verdict == Verdict::Stable);
        grasps.push(grasp);
        if stable == settings.wanted_stable.min(ENOUGH) {
            break;
        }
    }
    Ok(())
}

/// Whether a grasp that slipped is stable with less force; it is changed only then.
fn made_stable(
    object: &Body,
    robot: &Robot,
    grasp: &mut Grasp,
    settings: &GraspSettings,
) -> Result<bool, WorldError> {
    let result = try_grasp_gently(object, robot, grasp, &settings.trial, &WorldOptions::for_trials())?;
    let is_stable = result.verdict == Verdict::Stable;
    if is_stable {
        grasp.take(&result);
    }
    Ok(is_stable)
}

/// A candidate after its trial.
fn tried_grasp(
    object: &Body,
    robot: &Robot,
    candidate: &Candidate,
    settings: &GraspSettings,
) -> Result<Grasp, WorldError> {
    let mut grasp = untested(candidate, robot.gripper().grip_force_n);
    let result = try_grasp(object, robot, &grasp, &settings.trial, &WorldOptions::for_trials())?;
    grasp.take(&result);
    Ok(grasp)
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

    /// Notes what a trial said. The confidence must be that of an untested grasp.
    fn take(&mut self, result: &TrialResult) {
        (self.verdict, self.slip_m, self.turn_rad) = (result.verdict, result.slip_m, result.turn_rad);
        self.force_n = result.force_n;
        if let Some(opening_m) = result.opening_m {
            self.opening_m = opening_m;
        }
        if self.verdict == Verdict::Stable {
            self.confidence += 0.5;
        }
    }

    /// The same grasp with the fingers swapped.
    pub fn mirrored(&self) -> Self {
        let half_turn = Pose::upright(DVec3::ZERO, std::f64::consts::PI);
        Self { object_from_tool: self.object_from_tool * half_turn, ..*self }
    }
}

#[cfg(test)]
mod tests;
