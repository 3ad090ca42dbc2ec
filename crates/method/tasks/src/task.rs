//! A task: instruction, goal, robot and limits.

use std::f64::consts::PI;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use crate::goal::{Arity, Goal, arity, name_of};
use scene::json_schema::{FileSchema, file_schema};
use scene::text_account::{GoalPredicate, PredicateKind};

/// A task for a robot in a scene, as `schemas/task.schema.json` describes it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Task {
    /// `tabletopgen-task/1`.
    #[schemars(with = "String", extend("const" = "tabletopgen-task/1"))]
    pub format: TaskFormat,
    /// The instruction to the robot, in natural language.
    pub instruction: String,
    /// Predicates that must all hold at the end.
    #[schemars(with = "Vec<GoalPredicate>", length(min = 1))]
    pub goal: Goal,
    /// Name of the robot (`panda`).
    pub robot: String,
    pub limits: Limits,
}

/// The schema of files that hold a task, which `schemas/task.schema.json` is.
///
/// # Errors
///
/// If a part of the schema has no JSON form.
pub fn schema() -> Result<String, serde_json::Error> {
    file_schema::<Task>(&FileSchema {
        id: "https://tabletopgen.invalid/schemas/task-1.schema.json",
        title: "Robot task",
        description: "An instruction for a robot in a tabletop scene, with the goal that decides whether it was \
                      carried out. Meters, radians, seconds; directions as seen from the front edge of the table.",
        adjust: Some(require_targets),
    })
}

/// Requires of each predicate as many targets as [`arity`] says.
fn require_targets(document: &mut Value) {
    let named = |wanted: &[Arity]| -> Vec<&'static str> {
        PredicateKind::ALL.into_iter().filter(|kind| wanted.contains(&arity(*kind))).map(name_of).collect()
    };
    let condition = |wanted: &[Arity], then: Value| json!({ "if": { "properties": { "predicate": { "enum": named(wanted) } } }, "then": then });
    let conditions = [
        condition(&[Arity::TwoTargets], json!({ "required": ["target", "second_target"] })),
        condition(&[Arity::Target], json!({ "required": ["target"] })),
        condition(&[Arity::Unary], json!({ "properties": { "target": false } })),
        condition(
            &[Arity::Unary, Arity::OptionalTarget, Arity::Target],
            json!({ "properties": { "second_target": false } }),
        ),
    ];
    document["$defs"]["GoalPredicate"]["allOf"] = conditions.into_iter().collect();
}

/// The version of the file format.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum TaskFormat {
    #[default]
    #[serde(rename = "tabletopgen-task/1")]
    V1,
}

impl Task {
    /// A task with the usual limits.
    pub fn new(instruction: impl Into<String>, goal: Goal, robot: impl Into<String>) -> Self {
        Self {
            format: TaskFormat::V1,
            instruction: instruction.into(),
            goal,
            robot: robot.into(),
            limits: Limits::USUAL,
        }
    }
}

/// Limits that a successful execution keeps, beside the goal.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "TaskLimits")]
pub struct Limits {
    /// Longest execution, seconds.
    #[schemars(range(min = 0.0, max = 3600.0))]
    pub max_duration_s: f64,
    /// Farthest that objects outside the goal may move, meters.
    #[schemars(range(min = 0.0, max = 10.0))]
    pub max_displacement_of_others_m: f64,
    /// Farthest that objects outside the goal may turn, radians.
    #[schemars(range(min = 0.0, max = 3.2))]
    pub max_rotation_of_others_rad: f64,
    /// Least distance of the opened gripper from every object at the end, meters; not for goals that end in the hand.
    #[schemars(range(min = 0.0, max = 10.0))]
    pub min_gripper_distance_m: f64,
    /// Time that the objects must be at rest at the end, seconds.
    #[schemars(range(min = 0.0, max = 3600.0))]
    pub min_rest_s: f64,
}

impl Limits {
    /// A minute; 3 cm and 30 degrees for other objects, the bounds within which the paper calls a scene stable; the
    /// opened gripper 2 cm away, and one second of rest.
    pub const USUAL: Self = Self {
        max_duration_s: 60.0,
        max_displacement_of_others_m: 0.03,
        max_rotation_of_others_rad: PI / 6.0,
        min_gripper_distance_m: 0.02,
        min_rest_s: 1.0,
    };
}

#[cfg(test)]
mod tests {
    use super::*;

    const JSON: &str = r#"{
        "format": "tabletopgen-task/1",
        "instruction": "put the apple in the bowl",
        "goal": [{"predicate": "in", "object": "apple_1", "target": "bowl_1"}],
        "robot": "panda",
        "limits": {
            "max_duration_s": 60.0,
            "max_displacement_of_others_m": 0.03,
            "max_rotation_of_others_rad": 0.5235987755982988,
            "min_gripper_distance_m": 0.02,
            "min_rest_s": 1.0
        }
    }"#;

    #[test]
    fn task_is_read_and_written_alike() {
        let task: Task = serde_json::from_str(JSON).expect("a task");
        assert_eq!(task.limits, Limits::USUAL);
        let written = serde_json::to_value(&task).expect("serializes");
        let given: serde_json::Value = serde_json::from_str(JSON).expect("JSON");
        assert_eq!(written, given);
    }

    #[test]
    fn unknown_fields_and_versions_are_refused() {
        for (from, to) in [
            ("\"robot\"", "\"arm\": \"left\", \"robot\""),
            ("\"min_rest_s\"", "\"rest\": 1, \"min_rest_s\""),
            ("\"target\"", "\"goal\": 1, \"target\""),
            ("task/1", "task/2"),
        ] {
            assert!(serde_json::from_str::<Task>(&JSON.replacen(from, to, 1)).is_err(), "{to}");
        }
    }
}
