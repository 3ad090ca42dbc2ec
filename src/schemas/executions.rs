//! A task done by a simulated robot, as `app::executions` composes it.

use schemars::JsonSchema;

use super::values::MAX_INTEGER;
use demonstrations::vectors::SharesOfLimits;
use geometry::Pose;
use manipulation::execution::{Failure, PickReport, Recording};
use tasks::{Disturbance, PredicateOutcome, Task};

/// A task, what became of it, and the motion.
#[derive(JsonSchema)]
pub struct ExecutedTask {
    pub task: Task,
    #[schemars(range(min = 0, max = MAX_INTEGER))]
    pub seed: u64,
    pub execution: Execution,
    pub trajectory: Recording,
}

/// Result of a task.
#[derive(JsonSchema)]
pub struct Execution {
    pub robot: String,
    /// The variant of the robot's model.
    pub variant: Option<String>,
    pub world_from_base: Pose,
    pub succeeded: bool,
    /// Reason of the failure.
    pub failure: Option<Failure>,
    /// Details of the failure, in words.
    pub detail: Option<String>,
    /// The verdicts about the goal's predicates at the end, with what was measured.
    pub predicates: Vec<PredicateOutcome>,
    /// Objects beside the goal that were moved too far.
    pub disturbed: Vec<Disturbance>,
    /// Objects that were picked up.
    pub picks: Vec<PickReport>,
    #[schemars(range(min = 0.0, max = 36000.0))]
    pub duration_s: f64,
    pub limit_shares: SharesOfLimits,
}
