//! Motion problems of picks and places: what an execution asks its planner, without a simulation.
//!
//! An object is grasped where candidates by geometry say, and put to a random free place on the table or on another
//! object. Base, straight motions and obstacles are those of an execution. Two motions are left to the planner: with
//! an empty hand from home to before the grasp, and with the object from where it was raised to above its place.
//!
//! World frame, SI units; configurations are joint positions. Equal scenes, settings and seeds give equal problems.

use geometry::{DQuat, DVec2, Pose};
use nalgebra::Isometry3;
use rand::seq::SliceRandom;
use rand::{Rng, RngExt};
use robot::collision::{Arm, ArmError, Obstacle};
use robot::model::Robot;
use robot::model::limits::JointLimits;
use robot::planning::{PlanFailure, PlanOptions, Planner, Problem};
use robot::trajectory::{Trajectory, TrajectoryError};
use runtime::seed::child_rng;
use serde::Serialize;
use tasks::{GoalPredicate, PosedObject, PredicateKind};

use super::attempt::held_as;
use super::base::{bases, reaches_table, tool_poses};
use super::motions::{Motions, PickOption, PlaceOption};
use super::place::PlaceSearch;
use super::release::ReleaseTrials;
use super::scene::{SceneError, Shapes, TaskScene};
use super::settings::ExecutionSettings;
use super::transit::{FreePath, plan_free, time_free};
use crate::grasp::{Grasp, GraspSettings, untested_grasps};

/// Random points of the table that are tried before it has no free place.
const POINTS: usize = 200;
/// Free places whose motions are tried before there is no problem.
const PLACES: usize = 3;

/// A motion that is left to the planner.
#[derive(Clone, Debug)]
pub struct MotionProblem {
    /// Arm with the object that it holds.
    pub arm: Arm,
    pub obstacles: Vec<Obstacle>,
    pub start: Vec<f64>,
    pub goal: Vec<f64>,
    limits: Vec<JointLimits>,
    shares: [f64; 2],
}

/// An object that is picked up and put down.
#[derive(Clone, Debug)]
pub struct PickAndPlace {
    pub object: String,
    /// Support that the object is put on; `None` for the table.
    pub support: Option<String>,
    /// From home to before the grasp.
    pub transit: MotionProblem,
    /// From the raised object to above its place.
    pub carry: MotionProblem,
}

/// Reason why an object gives no problem.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum NoProblem {
    TooHeavy,
    NoGrasp,
    NoFreePlace,
    /// From no place of the base both the grasps and the place are reached.
    OutOfReach,
    /// No grasp has free straight motions to and from it.
    NoStraightPick,
    /// With no grasp the straight motions to and from the place are free.
    NoStraightPlace,
    /// The spheres of the arm, or those of what it holds, touch something at an end of a motion.
    EndInCollision,
}

impl MotionProblem {
    fn problem<'b>(&'b self, goals: &'b [Vec<f64>]) -> Problem<'b> {
        Problem { arm: &self.arm, obstacles: &self.obstacles, start: &self.start, goals }
    }

    /// Plans a path as an execution does.
    ///
    /// # Errors
    /// Why there is none.
    pub fn plan(&self, settings: &ExecutionSettings, rng: &mut impl Rng) -> Result<FreePath, PlanFailure> {
        plan_free(&self.problem(std::slice::from_ref(&self.goal)), settings, rng)
    }

    /// The motion along a planned path as an execution makes it.
    ///
    /// # Errors
    /// If the path is malformed, or the motion is not free.
    pub fn time(&self, found: &FreePath) -> Result<Trajectory, TrajectoryError> {
        time_free(&self.problem(std::slice::from_ref(&self.goal)), found, &self.limits, self.shares)
    }

    /// Whether nothing touches at either end.
    fn has_free_ends(&self) -> bool {
        let planner = Planner::new(&self.arm, &self.obstacles, PlanOptions::default());
        [&self.start, &self.goal].into_iter().all(|end| planner.check_start(end).is_ok())
    }
}

/// Makes problems in one scene with one robot.
pub struct PickAndPlaces<'a> {
    scene: &'a TaskScene,
    shapes: Shapes,
    robot: &'a Robot,
    grasp_settings: &'a GraspSettings,
    settings: &'a ExecutionSettings,
    seed: u64,
}

impl<'a> PickAndPlaces<'a> {
    /// # Errors
    /// If an object has a hull that is not convex.
    pub fn new(
        scene: &'a TaskScene,
        robot: &'a Robot,
        grasp_settings: &'a GraspSettings,
        settings: &'a ExecutionSettings,
        seed: u64,
    ) -> Result<Self, SceneError> {
        Ok(Self { scene, shapes: Shapes::new(scene)?, robot, grasp_settings, settings, seed })
    }

    /// Candidates for grasps of an object, best first.
    ///
    /// # Errors
    /// If it is too heavy, or has none.
    pub fn grasps(&self, object: usize) -> Result<Vec<Grasp>, NoProblem> {
        let body = &self.scene.objects[object];
        if body.mass.mass_kg > self.settings.max_payload_kg(self.robot.gripper()) {
            return Err(NoProblem::TooHeavy);
        }
        let mut rng = child_rng(self.seed, &format!("grasps of {}", body.name));
        let found = untested_grasps(body, self.robot, self.grasp_settings, &mut rng);
        if found.is_empty() { Err(NoProblem::NoGrasp) } else { Ok(found) }
    }

    /// A problem with an object, which is put on another one, or on the table. Which grasp and which place depends on
    /// the seed and the names.
    ///
    /// # Errors
    /// Why there is none.
    pub fn problem(
        &self,
        object: usize,
        support: Option<usize>,
        grasps: &[Grasp],
    ) -> Result<PickAndPlace, NoProblem> {
        let name = |index: usize| self.scene.objects[index].name.as_str();
        let stream = format!("pick {} and place on {}", name(object), support.map_or("the table", name));
        let mut rng = child_rng(self.seed, &stream);
        let places = self.places(object, support, &mut rng);
        let mut why_not = NoProblem::NoFreePlace;
        for place in &places {
            let now = self.scene.objects[object].world_from_object;
            let work = vec![tool_poses(&[now], grasps), tool_poses(&[*place], grasps)];
            why_not = why_not.max(NoProblem::OutOfReach);
            for base in bases(self.scene, self.robot, work, self.settings) {
                match self.motions(object, grasps, place, base, &mut rng) {
                    Ok((transit, carry)) => {
                        let names =
                            (name(object).to_owned(), support.map(|support| name(support).to_owned()));
                        return Ok(PickAndPlace { object: names.0, support: names.1, transit, carry });
                    }
                    Err(reason) => why_not = why_not.max(reason),
                }
            }
        }
        Err(why_not)
    }

    /// A few free places for an object.
    fn places(&self, object: usize, support: Option<usize>, rng: &mut impl Rng) -> Vec<Pose> {
        let poses = self.scene.poses();
        let now = self.shapes.posed(&poses);
        let trials = ReleaseTrials::new(self.scene, &self.shapes, &now, &poses, object, &[], &[]);
        let search = PlaceSearch {
            outline: &self.scene.outline,
            shapes: &self.shapes,
            table: self.shapes.posed_table(self.scene),
            start: &now,
            now: &now,
            object,
            wanted: PLACES,
            trials: &trials,
        };
        match support {
            Some(support) => search.places(&[on(&now[object], &now[support])], &[]),
            None => {
                let (low, high) = self.scene.outline.bounds();
                let mut drawn = || {
                    let share = DVec2::new(rng.random_range(0.0..1.0), rng.random_range(0.0..1.0));
                    let turn_rad = rng.random_range(-std::f64::consts::PI..std::f64::consts::PI);
                    search.free_place(
                        low + share * (high - low),
                        DQuat::from_rotation_z(turn_rad),
                        &[&now[object]],
                    )
                };
                (0..POINTS).filter_map(|_| drawn()).take(PLACES).collect()
            }
        }
    }

    /// Both motions from one place of the base, with a random one of the grasps that allow them.
    fn motions(
        &self,
        object: usize,
        grasps: &[Grasp],
        place: &Pose,
        base: Isometry3<f64>,
        rng: &mut impl Rng,
    ) -> Result<(MotionProblem, MotionProblem), NoProblem> {
        let poses = self.scene.poses();
        let home = &self.robot.home().positions;
        let motions = Motions::new(self.scene, self.robot, base, self.settings);
        let motions = motions.ok().filter(reaches_table).ok_or(NoProblem::OutOfReach)?;
        let mut picks = motions.picks(object, &poses, grasps, home);
        if picks.is_empty() {
            return Err(NoProblem::NoStraightPick);
        }
        picks.shuffle(rng);
        let neighbors = motions.neighbors(object, &poses);
        let mut why_not = NoProblem::NoStraightPlace;
        for pick in &picks {
            let held = held_as(object, &pick.grasp);
            let Some(raised) = pick.lift.last() else { continue };
            let Some(option) = motions.place(&held, place, &neighbors, raised, 0.0) else { continue };
            let Ok([transit, carry]) = self.ends(&motions, object, &poses, pick, &option) else { continue };
            if transit.has_free_ends() && carry.has_free_ends() {
                return Ok((transit, carry));
            }
            why_not = NoProblem::EndInCollision;
        }
        Err(why_not)
    }

    /// The two motions that a pick and a place leave to the planner.
    fn ends(
        &self,
        motions: &Motions,
        object: usize,
        poses: &[Pose],
        pick: &PickOption,
        option: &PlaceOption,
    ) -> Result<[MotionProblem; 2], ArmError> {
        let limits = self.robot.limits().to_vec();
        let end = |path: Option<&Vec<f64>>| path.cloned().unwrap_or_default();
        let transit = MotionProblem {
            arm: motions.arms.whole.clone(),
            obstacles: motions.obstacles(poses, &[]),
            start: self.robot.home().positions.clone(),
            goal: end(pick.approach.first()),
            limits: limits.clone(),
            shares: self.settings.free_shares,
        };
        let hulls = &self.scene.objects[object].hulls;
        let tool_from_object = held_as(object, &pick.grasp).tool_from_object;
        let carry = MotionProblem {
            arm: motions.arms.holding(self.robot, hulls, &tool_from_object)?,
            obstacles: motions.obstacles(poses, &[object]),
            start: end(pick.lift.last()),
            goal: end(option.lower.first()),
            limits,
            shares: self.settings.carrying_shares,
        };
        Ok([transit, carry])
    }
}

/// Predicate that an object rests on another one.
fn on(object: &PosedObject, support: &PosedObject) -> GoalPredicate {
    GoalPredicate {
        predicate: PredicateKind::On,
        object: object.name.clone(),
        target: Some(support.name.clone()),
        second_target: None,
    }
}

#[cfg(test)]
mod tests {
    use geometry::shapes::block;
    use geometry::{DVec3, Outline};
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    use super::*;
    use crate::test_scenes::box_body;

    fn scene() -> TaskScene {
        let corners = [(-0.6, -0.4), (0.6, -0.4), (0.6, 0.4), (-0.6, 0.4)].map(DVec2::from);
        let top = block(DVec3::new(1.2, 0.8, 0.03)).translated(DVec3::new(0.0, 0.0, -0.03));
        let cuboid = |name: &str, size_m: [f64; 3], mass_kg: f64, at: DVec2| {
            box_body(name, block(DVec3::from(size_m)), mass_kg, Pose::upright(at.extend(0.0), 0.3))
        };
        TaskScene {
            table: physics::Body { fixed: true, ..box_body("table", top, 10.0, Pose::IDENTITY) },
            outline: Outline::new(corners.to_vec()).expect("a rectangle"),
            objects: vec![
                cuboid("block_1", [0.045; 3], 0.1, DVec2::new(-0.15, 0.05)),
                cuboid("tray_1", [0.2, 0.2, 0.02], 0.5, DVec2::new(0.15, -0.05)),
                cuboid("tower_1", [0.05, 0.05, 0.25], 0.3, DVec2::new(0.0, 0.1)),
                cuboid("anvil_1", [0.05; 3], 30.0, DVec2::new(-0.4, 0.2)),
                cuboid("crate_1", [0.15; 3], 0.5, DVec2::new(0.4, 0.2)),
            ],
        }
    }

    fn with_problems<T>(seed: u64, work: impl FnOnce(&PickAndPlaces, &ExecutionSettings) -> T) -> T {
        let (scene, robot) = (scene(), Robot::built_in("panda", None).expect("built in"));
        let (grasps, settings) = (test_settings::section("grasps"), test_settings::section("execution"));
        let problems = PickAndPlaces::new(&scene, &robot, &grasps, &settings, seed).expect("boxes");
        work(&problems, &settings)
    }

    #[test]
    fn both_motions_are_planned_and_touch_nothing() {
        with_problems(3, |problems, settings| {
            let grasps = problems.grasps(0).expect("a small block");
            for support in [None, Some(1)] {
                let found = problems.problem(0, support, &grasps).expect("a problem");
                assert_eq!(found.support.as_deref(), support.map(|_| "tray_1"));
                for motion in [&found.transit, &found.carry] {
                    let path = motion.plan(settings, &mut ChaCha8Rng::seed_from_u64(1)).expect("a path");
                    assert_eq!(
                        (path.path.first(), path.path.last()),
                        (Some(&motion.start), Some(&motion.goal))
                    );
                    assert_eq!(motion.arm.certify_path(&path.path, &motion.obstacles, 0.0, 1e-3), Ok(()));
                    assert!(motion.time(&path).expect("a motion").duration_s() > 0.3);
                }
                assert_eq!(found.carry.obstacles.len() + 1, found.transit.obstacles.len());
                assert_eq!(found.carry.arm.bodies().len(), found.transit.arm.bodies().len() + 1);
            }
        });
    }

    #[test]
    fn seeds_decide_problems() {
        let goals = |seed| {
            with_problems(seed, |problems, _| {
                let found = problems.problem(0, None, &problems.grasps(0).expect("a small block"));
                found.map(|found| (found.transit.goal, found.carry.goal)).expect("a problem")
            })
        };
        assert_eq!(goals(1), goals(1));
        assert_ne!(goals(1), goals(2));
    }

    #[test]
    fn what_cannot_be_taken_gives_no_problem() {
        with_problems(1, |problems, _| {
            assert_eq!(problems.grasps(3).err(), Some(NoProblem::TooHeavy));
            assert_eq!(problems.grasps(4).err(), Some(NoProblem::NoGrasp));
        });
    }
}
