//! Checks that refuse a task before anything is simulated.

use geometry::DVec3;
use physics::Body;
use robot::model::Robot;
use tasks::evaluation::is_decidable;
use tasks::{Goal, PosedObject, PredicateKind, Situation, evaluate};

use super::GraspBook;
use super::scene::{SceneError, Shapes, TaskScene};
use super::settings::ExecutionSettings;
use crate::world::WorldError;

/// Reason why a task is not attempted. The codes are stable.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Refusal {
    #[error("the goal names {name}, which is not in the scene; it has {}", .candidates.join(", "))]
    AbsentObject { name: String, candidates: Vec<String> },
    #[error(
        "{name} is at least {thinnest_m:.3} m thick everywhere and the gripper opens to {opening_m:.3} m; choose \
        another object or robot"
    )]
    ObjectTooWide { name: String, thinnest_m: f64, opening_m: f64 },
    #[error(
        "{name} weighs {mass_kg:.2} kg and the grip holds {max_kg:.2} kg; choose another object or robot"
    )]
    ObjectTooHeavy { name: String, mass_kg: f64, max_kg: f64 },
    #[error("{name} does not move; choose another object")]
    ObjectFixed { name: String },
    #[error("the goal holds already; state one that needs a motion")]
    GoalAlreadyTrue,
    #[error("{first} and {second} cannot both be where the goal wants them; state a goal for one of them")]
    GoalConflict { first: String, second: String },
    #[error(
        "the robot does not bring about {predicate}, or poses do not show it; it can {}",
        tasks::text::PERFORMED
    )]
    UnsupportedGoal { predicate: String },
    #[error(
        "no place for the base of the robot reaches all that the task needs; move the objects or the robot"
    )]
    TableOutOfReach,
    #[error(
        "with its base at {at}, {robot} is {distance_m:.2} m away from the edge of the table and reaches {reach_m:.2} m; \
        give a place beside or on the table, or none"
    )]
    BaseTooFar { at: BasePoint, robot: String, distance_m: f64, reach_m: f64 },
    #[error(
        "with its base at {at}, {robot} touches the table or an object where it waits; give another place, or none"
    )]
    BaseNotFree { at: BasePoint, robot: String },
    #[error(transparent)]
    Scene(#[from] SceneError),
    #[error(transparent)]
    World(#[from] WorldError),
    #[error("the planner cannot handle this robot: {0}")]
    Robot(#[from] robot::collision::ArmError),
}

/// Requested position of a base, in the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BasePoint {
    pub x_m: f64,
    pub y_m: f64,
    pub z_m: f64,
}

impl std::fmt::Display for BasePoint {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "x {:.2}, y {:.2}, z {:.2} m", self.x_m, self.y_m, self.z_m)
    }
}

impl Refusal {
    /// A short name for statistics and clients.
    pub fn code(&self) -> &'static str {
        match self {
            Self::AbsentObject { .. } => "absent_object",
            Self::ObjectTooWide { .. } => "object_too_wide",
            Self::ObjectTooHeavy { .. } => "object_too_heavy",
            Self::ObjectFixed { .. } => "object_fixed",
            Self::GoalAlreadyTrue => "goal_already_true",
            Self::GoalConflict { .. } => "goal_conflict",
            Self::UnsupportedGoal { .. } => "predicate_not_supported",
            Self::TableOutOfReach | Self::BaseTooFar { .. } => "table_out_of_reach",
            Self::BaseNotFree { .. } => "base_not_free",
            Self::Scene(_) => "broken_object",
            Self::World(_) => "broken_object",
            Self::Robot(_) => "unsupported_robot",
        }
    }
}

/// Checks a goal against a scene and a robot.
pub(crate) fn check(
    scene: &TaskScene,
    shapes: &Shapes,
    robot: &Robot,
    goal: &Goal,
    grasps: &GraspBook,
    settings: &ExecutionSettings,
) -> Result<(), Refusal> {
    for name in goal.named_objects() {
        if scene.index(name.as_str()).is_none() {
            let candidates = scene.objects.iter().map(|object| object.name.clone()).collect();
            return Err(Refusal::AbsentObject { name: name.to_string(), candidates });
        }
    }
    for predicate in goal.predicates() {
        let kind = predicate.predicate;
        use PredicateKind as P;
        if !is_decidable(kind) || matches!(kind, P::LyingOnSide | P::UpsideDown | P::Opened | P::Closed) {
            let predicate = tasks::goal::name_of(kind).to_owned();
            return Err(Refusal::UnsupportedGoal { predicate });
        }
    }
    let start = shapes.posed(&scene.poses());
    let situation = Situation { table: &scene.outline, start: &start, now: &start, contacts: &[] };
    if evaluate(goal, &situation).iter().all(|outcome| outcome.holds) {
        return Err(Refusal::GoalAlreadyTrue);
    }
    for name in goal.moved_objects() {
        if let Some(object) = scene.objects.iter().find(|object| object.name == name.as_str()) {
            can_be_taken(object, robot, grasps, settings)?;
        }
    }
    can_be_shared(goal, &start)
}

fn can_be_taken(
    object: &Body,
    robot: &Robot,
    grasps: &GraspBook,
    settings: &ExecutionSettings,
) -> Result<(), Refusal> {
    let (name, gripper) = (object.name.clone(), robot.gripper());
    if object.fixed {
        return Err(Refusal::ObjectFixed { name });
    }
    let max_kg = settings.max_payload_kg(gripper);
    if object.mass.mass_kg > max_kg {
        return Err(Refusal::ObjectTooHeavy { name, mass_kg: object.mass.mass_kg, max_kg });
    }
    let thinnest_m = object.hulls.iter().map(thinnest_m).fold(f64::INFINITY, f64::min);
    let has_grasp = grasps.get(&object.name).is_some_and(|grasps| !grasps.is_empty());
    if !has_grasp && thinnest_m > gripper.max_opening_m {
        return Err(Refusal::ObjectTooWide { name, thinnest_m, opening_m: gripper.max_opening_m });
    }
    Ok(())
}

/// The least extent of a hull along the normals of its faces.
fn thinnest_m(hull: &geometry::ConvexHull) -> f64 {
    let extent = |normal: DVec3| {
        let along = hull.points.iter().map(|p| p.dot(normal));
        let start = (f64::INFINITY, f64::NEG_INFINITY);
        let (low, high) = along.fold(start, |(low, high), a| (low.min(a), high.max(a)));
        high - low
    };
    let planes = geometry::convex_hull::planes(hull);
    planes.iter().map(|(normal, _)| extent(*normal)).fold(f64::INFINITY, f64::min)
}

/// Checks that no two objects of a goal take each other's place: both stacked on one, or more in an opening than fits.
fn can_be_shared(goal: &Goal, start: &[PosedObject]) -> Result<(), Refusal> {
    let predicates = goal.predicates();
    for (index, first) in predicates.iter().enumerate() {
        for second in &predicates[index + 1..] {
            let same =
                first.target.is_some() && first.target == second.target && first.object != second.object;
            let kinds = [first.predicate, second.predicate];
            let is_conflict = match kinds {
                [PredicateKind::StackedOn, PredicateKind::StackedOn] => same,
                [PredicateKind::In, PredicateKind::In] => same && !both_fit(first, second, start),
                _ => false,
            };
            if is_conflict {
                let (first, second) = (first.object.to_string(), second.object.to_string());
                return Err(Refusal::GoalConflict { first, second });
            }
        }
    }
    Ok(())
}

/// Whether two objects have less volume together than the opening that both shall be in.
fn both_fit(first: &tasks::GoalPredicate, second: &tasks::GoalPredicate, start: &[PosedObject]) -> bool {
    use tasks::posed_object::find;
    let volume_m3 = |name| {
        let object = find(start, name);
        object.map_or(0.0, |o| o.shape.hulls().iter().map(geometry::ConvexHull::volume_m3).sum::<f64>())
    };
    let opening = first.target.as_ref().and_then(|name| find(start, name)?.shape.opening().cloned());
    opening.is_none_or(|opening| volume_m3(&first.object) + volume_m3(&second.object) < opening.volume_m3)
}
