//! Tasks of a robot: types of the crate `tasks`.

use schemars::JsonSchema;

use super::texts::GoalPredicate;
use super::words::ProposalKind;

/// An instruction with a goal that poses, contacts and shapes decide; `schemas/task.schema.json`.
#[derive(JsonSchema)]
pub struct Task {
    #[schemars(extend("const" = "tabletopgen-task/1"))]
    pub format: String,
    pub instruction: String,
    /// Predicates that must all hold at the end.
    #[schemars(length(min = 1))]
    pub goal: Vec<GoalPredicate>,
    pub robot: String,
    pub limits: TaskLimits,
}

/// Limits of an execution, beside the goal.
#[derive(JsonSchema)]
pub struct TaskLimits {
    #[schemars(range(min = 0.0, max = 3600.0))]
    pub max_duration_s: f64,
    #[schemars(range(min = 0.0, max = 10.0))]
    pub max_displacement_of_others_m: f64,
    #[schemars(range(min = 0.0, max = 3.2))]
    pub max_rotation_of_others_rad: f64,
    #[schemars(range(min = 0.0, max = 10.0))]
    pub min_gripper_distance_m: f64,
    #[schemars(range(min = 0.0, max = 3600.0))]
    pub min_rest_s: f64,
}

/// A feasible task by rules over shapes and affordances.
#[derive(JsonSchema)]
pub struct ProposedTask {
    pub kind: ProposalKind,
    pub task: Task,
    /// The task as three people would say it.
    pub wordings: Wordings,
    pub difficulty: Difficulty,
}

/// Wordings of a task.
#[derive(JsonSchema)]
pub struct Wordings {
    pub vague: String,
    pub default: String,
    pub specific: String,
}

/// Difficulty of a task.
#[derive(JsonSchema)]
pub struct Difficulty {
    /// Objects that the goal names.
    #[schemars(range(min = 1, max = 1000))]
    pub objects: u32,
    /// Other objects within 6 cm of one of these.
    #[schemars(range(min = 0, max = 1000))]
    pub clutter: u32,
    /// Share of these that is hidden from the front.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub occlusion: f64,
    /// Tolerance of placements.
    #[schemars(range(min = 0.0, max = 10.0))]
    pub precision_m: f64,
    /// Objects picked up and put down.
    #[schemars(range(min = 1, max = 1000))]
    pub steps: u32,
    #[schemars(range(min = 0.0, max = 1.0))]
    pub overall: f64,
}
