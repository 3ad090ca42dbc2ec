//! The motions of a pick and of a place: which of them an arm can make.

use geometry::{DVec3, Pose};
use nalgebra::{Isometry3, Vector3};
use rand::Rng;
use robot::collision::{Arm, ArmError, ConvexPolyhedron, Obstacle};
use robot::model::Robot;
use robot::planning::straight::{StraightOptions, straight_by};
use robot::planning::{PlanFailure, PlanOptions, Planner, Problem};
use robot::trajectory::{Trajectory, TrajectoryError};

use super::obstacles::{PlannerArms, Surroundings, polyhedra, stand};
use super::reach::Reach;
use super::scene::TaskScene;
use super::settings::ExecutionSettings;
use super::transit::{plan_free, time_free, timing};
use crate::frames::{from_vector, to_isometry};
use crate::grasp::{Grasp, HandShape};

/// Configurations that are tried for one pose of the tool.
const CONFIGURATIONS: usize = 4;
/// Held objects touch what they rest on; their way is checked from this far above it, meters.
const OFF_SUPPORT_M: f64 = 0.004;
/// Reduced clearance where neighbors leave no more room, meters: each finger may pass the object that it will grasp at
/// this distance, and no part of the hand comes closer than [`NARROW_GAP_M`]; servos do not stop exactly at their
/// targets.
const NARROW_M: f64 = 0.003;
const NARROW_GAP_M: f64 = 0.001;

/// An arm at its place in a scene.
pub(crate) struct Motions<'a> {
    pub scene: &'a TaskScene,
    pub robot: &'a Robot,
    pub reach: Reach<'a>,
    pub arms: PlannerArms,
    pub hand: HandShape,
    pub world_from_base: Isometry3<f64>,
    pub settings: &'a ExecutionSettings,
    /// The hulls of the table and of each object, in their own frames.
    table_solids: Vec<ConvexPolyhedron>,
    solids: Vec<Vec<ConvexPolyhedron>>,
}

/// A grasp that the arm reaches straight, and from which it can raise the object.
#[derive(Clone, Debug)]
pub(crate) struct PickOption {
    pub grasp: Grasp,
    /// From before the grasp to it, and from it upward.
    pub approach: Vec<Vec<f64>>,
    pub lift: Vec<Vec<f64>>,
}

/// A place that the arm reaches straight from above with the object in its hand, and leaves again.
#[derive(Clone, Debug)]
pub(crate) struct PlaceOption {
    pub lower: Vec<Vec<f64>>,
    pub retreat: Vec<Vec<f64>>,
    /// The object's pose when the fingers open.
    pub released: Pose,
}

/// Object in the hand, and the grip.
#[derive(Clone, Copy, Debug)]
pub(crate) struct HeldObject {
    pub object: usize,
    pub tool_from_object: Pose,
    pub opening_m: f64,
    pub release_opening_m: f64,
    /// Of each pad.
    pub force_n: f64,
}

/// Reason why a motion was not found.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub(crate) enum MotionFailure {
    #[error(transparent)]
    Plan(#[from] PlanFailure),
    #[error(transparent)]
    Timing(#[from] TrajectoryError),
    #[error(transparent)]
    Arm(#[from] ArmError),
}

impl MotionFailure {
    /// Whether the arm touches something before it moves.
    pub fn is_at_start(&self) -> bool {
        matches!(self, Self::Plan(PlanFailure::StartInCollision { .. }))
    }
}

/// The objects but one in their poses: what the straight motions of a hand with that one must pass.
pub(crate) struct Neighbors {
    blocks: Vec<Obstacle>,
    exact: Surroundings,
}

impl<'a> Motions<'a> {
    /// # Errors
    /// If the planner cannot handle the robot.
    pub fn new(
        scene: &'a TaskScene,
        robot: &'a Robot,
        world_from_base: Isometry3<f64>,
        settings: &'a ExecutionSettings,
    ) -> Result<Self, ArmError> {
        let (reach, arms, hand) = (Reach::new(robot), PlannerArms::new(robot)?, HandShape::new(robot));
        let solids = scene.objects.iter().map(|object| polyhedra(&object.hulls)).collect();
        let table_solids = polyhedra(&scene.table.hulls);
        Ok(Self { scene, robot, reach, arms, hand, world_from_base, settings, table_solids, solids })
    }

    /// Grasps that the arm reaches with the objects in these poses, in the order in which they are given. Where there
    /// is none, those that it reaches with the fingers opened less.
    pub fn picks(&self, object: usize, poses: &[Pose], grasps: &[Grasp], near: &[f64]) -> Vec<PickOption> {
        let considered = &grasps[..grasps.len().min(self.settings.max_grasps)];
        let neighbors = self.neighbors(object, poses);
        let found = self.reached(object, poses, considered, &neighbors, near);
        if !found.is_empty() {
            return found;
        }
        let others: Vec<usize> = (0..poses.len()).filter(|&other| other != object).collect();
        let itself = Surroundings::new(&self.scene.table, &self.scene.objects, poses, &others);
        let narrow = considered.iter().filter_map(|grasp| self.opened_less(&poses[object], grasp, &itself));
        self.reached(object, poses, &narrow.collect::<Vec<_>>(), &neighbors, near)
    }

    /// Grasps that the arm reaches, each with its motions.
    fn reached(
        &self,
        object: usize,
        poses: &[Pose],
        grasps: &[Grasp],
        neighbors: &Neighbors,
        near: &[f64],
    ) -> Vec<PickOption> {
        let planner = self.straight_planner(&neighbors.blocks);
        let mut found = Vec::new();
        for grasp in grasps.iter().flat_map(|grasp| [*grasp, grasp.mirrored()]) {
            let world_from_tool = poses[object] * grasp.object_from_tool;
            if self.hand_reaches(&world_from_tool, &grasp, object, &neighbors.exact) {
                found.extend(self.pick(&world_from_tool, &grasp, &planner, near));
            }
            if found.len() >= self.settings.max_options {
                break;
            }
        }
        found
    }

    /// A grasp to which the hand comes with its fingers opened less, if it passes the object itself so.
    fn opened_less(&self, world_from_object: &Pose, grasp: &Grasp, itself: &Surroundings) -> Option<Grasp> {
        let pregrasp_opening_m = grasp.opening_m + 2.0 * NARROW_M;
        let world_from_tool = *world_from_object * grasp.object_from_tool;
        let back = self.back(&world_from_tool);
        let solids = self.hand.solids(pregrasp_opening_m, true);
        let is_narrower = pregrasp_opening_m < grasp.pregrasp_opening_m;
        (is_narrower && itself.are_passed(&solids, &world_from_tool, back, NARROW_GAP_M))
            .then_some(Grasp { pregrasp_opening_m, ..*grasp })
    }

    /// From a grasp to where the hand comes from, in the world.
    fn back(&self, world_from_tool: &Pose) -> DVec3 {
        -self.settings.approach_m * (world_from_tool.rotation * DVec3::Z)
    }

    /// Whether the hand passes everything on its way to a grasp, and the held object on its way up.
    fn hand_reaches(
        &self,
        world_from_tool: &Pose,
        grasp: &Grasp,
        object: usize,
        others: &Surroundings,
    ) -> bool {
        let (gap_m, back) = (self.settings.hand_gap_m, self.back(world_from_tool));
        let opened = self.hand.solids(grasp.pregrasp_opening_m, true);
        if !others.are_passed(&opened, world_from_tool, back, gap_m) {
            return false;
        }
        let held = HeldObject {
            object,
            tool_from_object: grasp.object_from_tool.inverse(),
            opening_m: grasp.opening_m,
            release_opening_m: grasp.pregrasp_opening_m,
            force_n: grasp.force_n,
        };
        self.rises(world_from_tool, &held, others)
    }

    /// Whether the closed hand and what it holds pass everything between a pose and where they are raised to.
    fn rises(&self, world_from_tool: &Pose, held: &HeldObject, others: &Surroundings) -> bool {
        let up = DVec3::new(0.0, 0.0, self.settings.lift_m);
        let raised = Pose { translation_m: world_from_tool.translation_m + up, ..*world_from_tool };
        let closed = self.hand.solids(held.opening_m, true);
        let object = self.held_solids(held);
        others.are_passed(&closed, &raised, -up, self.settings.hand_gap_m)
            && others.are_passed(&object, &raised, DVec3::new(0.0, 0.0, OFF_SUPPORT_M) - up, 0.0)
    }

    fn held_solids(&self, held: &HeldObject) -> Vec<Vec<DVec3>> {
        let hulls = &self.scene.objects[held.object].hulls;
        let place = |p: &DVec3| held.tool_from_object.transform_point(*p);
        hulls.iter().map(|hull| hull.points.iter().map(place).collect()).collect()
    }

    fn pick(
        &self,
        world_from_tool: &Pose,
        grasp: &Grasp,
        planner: &Planner,
        near: &[f64],
    ) -> Option<PickOption> {
        let base_from_tool = self.world_from_base.inverse() * to_isometry(world_from_tool);
        let back = base_from_tool.rotation * (Vector3::z() * -self.settings.approach_m);
        let up = self.up() * self.settings.lift_m;
        self.reach.best(&base_from_tool, near, CONFIGURATIONS).iter().find_map(|at| {
            let mut approach = self.straight(planner, at, back)?;
            approach.reverse();
            Some(PickOption { grasp: *grasp, approach, lift: self.straight(planner, at, up)? })
        })
    }

    /// Obstacles of the straight motions with an object.
    pub fn neighbors(&self, object: usize, poses: &[Pose]) -> Neighbors {
        let exact = Surroundings::new(&self.scene.table, &self.scene.objects, poses, &[object]);
        Neighbors { blocks: self.obstacles(poses, &[object]), exact }
    }

    /// Motions that put the held object to a pose. Where the hand does not get as low between its neighbors, the object
    /// is let fall by up to `max_fall_m`.
    pub fn place(
        &self,
        held: &HeldObject,
        world_from_object: &Pose,
        neighbors: &Neighbors,
        near: &[f64],
        max_fall_m: f64,
    ) -> Option<PlaceOption> {
        let gaps = [self.settings.release_gap_m, 0.015, 0.03, 0.05, 0.075, 0.1, 0.125];
        let mut allowed = gaps.iter().filter(|gap| **gap <= max_fall_m.max(self.settings.release_gap_m));
        allowed.find_map(|&gap_m| {
            let gap = DVec3::new(0.0, 0.0, gap_m);
            let end = Pose { translation_m: world_from_object.translation_m + gap, ..*world_from_object };
            self.place_at(&(end * held.tool_from_object.inverse()), held, neighbors, near)
        })
    }

    fn place_at(
        &self,
        world_from_tool: &Pose,
        held: &HeldObject,
        neighbors: &Neighbors,
        near: &[f64],
    ) -> Option<PlaceOption> {
        let base_from_tool = self.world_from_base.inverse() * to_isometry(world_from_tool);
        let configurations = self.reach.best(&base_from_tool, near, CONFIGURATIONS);
        if configurations.is_empty() {
            return None;
        }
        let back = self.back(world_from_tool);
        let opened = self.hand.solids(held.release_opening_m, true);
        let gap_m = 0.5 * self.settings.hand_gap_m;
        let passes = neighbors.exact.are_passed(&opened, world_from_tool, back, gap_m)
            && self.rises(world_from_tool, held, &neighbors.exact);
        if !passes {
            return None;
        }
        let planner = self.straight_planner(&neighbors.blocks);
        let back = base_from_tool.rotation * (Vector3::z() * -self.settings.approach_m);
        let up = self.up() * self.settings.lift_m;
        configurations.iter().find_map(|at| {
            let mut lower = self.straight(&planner, at, up)?;
            lower.reverse();
            let released = *world_from_tool * held.tool_from_object;
            Some(PlaceOption { lower, retreat: self.straight(&planner, at, back)?, released })
        })
    }

    /// A motion with an empty hand, among objects in these poses, to any of `goals`.
    ///
    /// # Errors
    /// Why there is none.
    pub fn move_free(
        &self,
        start: &[f64],
        goals: &[Vec<f64>],
        poses: &[Pose],
        rng: &mut impl Rng,
    ) -> Result<(Vec<Vec<f64>>, Trajectory), MotionFailure> {
        let blocks = self.obstacles(poses, &[]);
        self.transit(&self.arms.whole, start, goals, &blocks, self.settings.free_shares, rng)
    }

    /// A motion with an object in the hand to any of `goals`.
    ///
    /// # Errors
    /// Why there is none.
    pub fn carry(
        &self,
        held: &HeldObject,
        start: &[f64],
        goals: &[Vec<f64>],
        poses: &[Pose],
        rng: &mut impl Rng,
    ) -> Result<(Vec<Vec<f64>>, Trajectory), MotionFailure> {
        let hulls = &self.scene.objects[held.object].hulls;
        let arm = self.arms.holding(self.robot, hulls, &held.tool_from_object)?;
        let blocks = self.obstacles(poses, &[held.object]);
        let shares = self.settings.carrying_shares;
        let close = |failure: &MotionFailure| {
            let MotionFailure::Plan(failure) = failure else { return false };
            matches!(failure, PlanFailure::StartInCollision { .. } | PlanFailure::GoalInCollision { .. })
        };
        match self.transit(&arm, start, goals, &blocks, shares, rng) {
            // The spheres around a long object that hangs down a little meet the table before it does.
            Err(failure) if close(&failure) => {
                let arm = self.arms.holding_closely(self.robot, hulls, &held.tool_from_object)?;
                self.transit(&arm, start, goals, &blocks, shares, rng)
            }
            done => done,
        }
    }

    /// The time law of a straight motion.
    ///
    /// # Errors
    /// If the path is malformed.
    pub fn time_straight(&self, path: &[Vec<f64>]) -> Result<Trajectory, MotionFailure> {
        let options = timing(self.settings.straight_shares);
        Ok(Trajectory::along(path, self.robot.limits(), &options)?)
    }

    fn transit(
        &self,
        arm: &Arm,
        start: &[f64],
        goals: &[Vec<f64>],
        blocks: &[Obstacle],
        shares: [f64; 2],
        rng: &mut impl Rng,
    ) -> Result<(Vec<Vec<f64>>, Trajectory), MotionFailure> {
        let problem = Problem { arm, obstacles: blocks, start, goals };
        let found = plan_free(&problem, self.settings, rng)?;
        let timed = time_free(&problem, &found, self.robot.limits(), shares)?;
        Ok((found.path, timed))
    }

    fn straight(&self, planner: &Planner, start: &[f64], offset: Vector3<f64>) -> Option<Vec<Vec<f64>>> {
        straight_by(planner, &self.reach, start, offset, &StraightOptions::default()).ok()
    }

    /// A straight motion of the empty hand by an offset in the frame of the world, the arm clear of the objects in
    /// these poses. The hand itself is left to an exact check.
    pub fn straight_past(&self, poses: &[Pose], start: &[f64], way: Vector3<f64>) -> Option<Vec<Vec<f64>>> {
        let blocks = self.obstacles(poses, &[]);
        let planner = self.straight_planner(&blocks);
        self.straight(&planner, start, self.world_from_base.rotation.inverse() * way)
    }

    fn straight_planner<'b>(&'b self, blocks: &'b [Obstacle]) -> Planner<'b> {
        let options = PlanOptions { padding_m: self.settings.hand_gap_m, ..PlanOptions::default() };
        Planner::new(&self.arms.without_hand, blocks, options)
    }

    /// Up in the frame of the base.
    fn up(&self) -> Vector3<f64> {
        self.world_from_base.rotation.inverse() * Vector3::z()
    }

    /// The table, the objects without those that are skipped, and a stand, in the frame of the base.
    pub fn obstacles(&self, poses: &[Pose], skipped: &[usize]) -> Vec<Obstacle> {
        let base_from_world = self.world_from_base.inverse();
        let kept = self.solids.iter().enumerate().filter(|(index, _)| !skipped.contains(index));
        let table = (&self.table_solids, self.scene.table.world_from_object);
        let placed = std::iter::once(table).chain(kept.map(|(index, solids)| (solids, poses[index])));
        placed
            .flat_map(|(solids, pose)| {
                let base_from_object = base_from_world * to_isometry(&pose);
                solids.iter().filter_map(move |solid| Obstacle::hull(base_from_object, solid.clone()).ok())
            })
            .chain(stand(&self.world_from_base))
            .collect()
    }

    /// The wrench that carries a weight at a point of the tool's frame, as what the servos' targets are ahead: each by
    /// its torque over its stiffness.
    pub fn lead(&self, positions: &[f64], mass_kg: f64, tool_from_center: DVec3) -> Vec<f64> {
        let jacobian = robot::kinematics::jacobian(self.robot, positions);
        let tool = robot::kinematics::tool_pose(self.robot, positions);
        let force = self.up() * (mass_kg * physics::rolling::GRAVITY_M_S2);
        let arm = tool.rotation * from_vector(tool_from_center);
        let torque = arm.cross(&force);
        let joints = self.robot.arm_joints().enumerate();
        joints
            .map(|(k, joint)| {
                let column = jacobian.column(k);
                let effort = column.fixed_rows::<3>(0).dot(&force) + column.fixed_rows::<3>(3).dot(&torque);
                effort / joint.drive.stiffness
            })
            .collect()
    }
}
