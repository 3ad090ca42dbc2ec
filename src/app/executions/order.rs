//! Orders of executions: as a client states them, checked, and as they are stored.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use super::TaskSource;
use crate::app::submission::check_text;
use crate::app::tasks::robot_named;
use crate::problem::{FieldError, Problem};
use crate::schemas;
use crate::schemas::values::MAX_INTEGER;
use scene::request::MAX_SEED;
use tasks::Task;

/// Task of a robot, in words or as a document; one of `text` and `task`.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
#[schemars(rename = "ExecutionRequest", extend("oneOf" = [{ "required": ["text"] }, { "required": ["task"] }]))]
pub struct ExecutionDraft {
    /// An instruction in words.
    #[schemars(with = "schemas::episodes::Instruction")]
    pub text: Option<String>,
    /// A task as `GET /scenes/{scene_id}/tasks` gives it; it names its robot.
    #[schemars(with = "Task")]
    pub task: Option<Value>,
    /// The robot of an instruction in words; a task names its own.
    pub robot: String,
    #[schemars(range(min = 0, max = MAX_INTEGER))]
    pub seed: u64,
    /// Place of the base of the robot; chosen by the reach of the arm if absent.
    pub base: Option<BasePlace>,
    /// Whether the archive has a video of the motion, `video.mp4`; only with `format=zip`.
    pub video: bool,
}

impl Default for ExecutionDraft {
    fn default() -> Self {
        Self { text: None, task: None, robot: "panda".to_owned(), seed: 0, base: None, video: false }
    }
}

/// In the frame of the scene; z is above the top of the table. The base faces x, turned by `yaw_rad` about the
/// vertical. A place where the arm touches something is refused with `base_not_free`, one without a table near it with
/// `table_out_of_reach`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BasePlace {
    #[schemars(range(min = -10.0, max = 10.0))]
    pub x_m: f64,
    #[schemars(range(min = -10.0, max = 10.0))]
    pub y_m: f64,
    /// Above the top of the table.
    #[schemars(range(min = -10.0, max = 10.0))]
    pub z_m: f64,
    #[schemars(range(min = -10.0, max = 10.0))]
    pub yaw_rad: f64,
}

/// Number of a place that no base can have.
#[derive(Debug, thiserror::Error)]
#[error("is {value}; it must be from {} to {}", -BasePlace::MAX, BasePlace::MAX)]
pub struct OutOfRange {
    /// Name of the field.
    pub name: &'static str,
    value: f64,
}

impl BasePlace {
    /// No number is greater than this, in meters and radians.
    const MAX: f64 = 10.0;

    /// Checks that no number is out of range.
    ///
    /// # Errors
    ///
    /// [`OutOfRange`] for the first that is.
    pub fn check(&self) -> Result<(), OutOfRange> {
        let named = [("x_m", self.x_m), ("y_m", self.y_m), ("z_m", self.z_m), ("yaw_rad", self.yaw_rad)];
        match named.into_iter().find(|(_, value)| !(-Self::MAX..=Self::MAX).contains(value)) {
            Some((name, value)) => Err(OutOfRange { name, value }),
            None => Ok(()),
        }
    }
}

/// The form of the answer: verdict, task and motion as one document, or the files that `tabletopgen execute --out`
/// writes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
#[schemars(extend("default" = "json"))]
pub enum ExecutionFormat {
    #[default]
    Json,
    Zip,
}

/// Order of an execution, as it is stored.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ExecutionOrder {
    pub task: TaskSource,
    /// The robot of an instruction in words.
    pub robot: String,
    pub seed: u64,
    pub base: Option<BasePlace>,
    pub video: bool,
    pub format: ExecutionFormat,
}

impl ExecutionOrder {
    /// Version of the stored form.
    const VERSION: u32 = 2;

    /// The order as it is stored.
    pub fn stored(&self) -> Value {
        json!({ "version": Self::VERSION, "order": self })
    }

    /// Inverse of [`Self::stored`]. Reads version 1, too, in which an instruction has its robot within.
    ///
    /// # Errors
    ///
    /// Another version wrote the order.
    pub fn of_stored(stored: &Value) -> Result<Self, serde_json::Error> {
        let mut order = stored["order"].clone();
        if stored["version"] == 1 {
            let instruction = order["task"]["text"].clone();
            order["robot"] = instruction.get("robot").cloned().unwrap_or_default();
            if let Some(text) = instruction.get("text") {
                order["task"]["text"] = text.clone();
            }
            if order["robot"].is_null() {
                order["robot"] = order["task"]["task"]["robot"].clone();
            }
        }
        Self::deserialize(order)
    }
}

impl ExecutionDraft {
    /// Checks all that needs no scene.
    ///
    /// # Errors
    ///
    /// A [`Problem`] with every value that will not do, or that names an unknown robot.
    pub fn checked(self, format: ExecutionFormat, max_text_chars: usize) -> Result<ExecutionOrder, Problem> {
        let Self { text, task, robot, seed, base, video } = self;
        let mut errors = Vec::new();
        if seed > MAX_SEED {
            errors.push(FieldError::new("/seed", format!("must be at most {MAX_SEED}")));
        }
        if let Some(Err(error)) = base.map(|base| base.check()) {
            errors.push(FieldError::new(format!("/base/{}", error.name), error.to_string()));
        }
        if video && format == ExecutionFormat::Json {
            errors.push(FieldError::new("/video", "a video is in the archive alone; ask with format=zip"));
        }
        if let (true, Err(why)) = (video, super::video::check()) {
            errors.push(FieldError::new("/video", why.to_string()));
        }
        let source = source_of(text, task, max_text_chars).map_err(|error| errors.push(error));
        let Some(task) = source.ok().filter(|_| errors.is_empty()) else {
            return Err(Problem::invalid(errors));
        };
        robot_named(task.robot(&robot))?;
        Ok(ExecutionOrder { task, robot, seed, base, video, format })
    }
}

/// The task of an order: its own, or that of its instruction.
fn source_of(
    text: Option<String>,
    task: Option<Value>,
    max_text_chars: usize,
) -> Result<TaskSource, FieldError> {
    match (text, task) {
        (Some(text), None) => match check_text(&text, max_text_chars) {
            Ok(text) => Ok(TaskSource::Text(text)),
            Err(why) => Err(FieldError::new("/text", why.to_string())),
        },
        (None, Some(task)) => match Task::deserialize(task) {
            Ok(task) => Ok(TaskSource::Task(Box::new(task))),
            Err(error) => Err(FieldError::new("/task", format!("is no task: {error}"))),
        },
        (both, _) => {
            let which = if both.is_some() { "both are there" } else { "there is neither" };
            Err(FieldError::new("", format!("give `text` or `task`, one of them; {which}")))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn orders_of_both_versions_are_read() {
        let order = ExecutionDraft { text: Some("lift the mug".to_owned()), ..ExecutionDraft::default() };
        let order = order.checked(ExecutionFormat::Json, 100).expect("will do");
        assert_eq!(ExecutionOrder::of_stored(&order.stored()).expect("is read"), order);
        let mut first = order.stored();
        first["version"] = json!(1);
        first["order"]["task"] = json!({ "text": { "text": "lift the mug", "robot": "panda" } });
        first["order"].as_object_mut().expect("an object").remove("robot");
        assert_eq!(ExecutionOrder::of_stored(&first).expect("is read"), order);
    }
}
