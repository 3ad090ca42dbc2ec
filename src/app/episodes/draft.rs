//! An order of episodes as a client states it.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use crate::app::submission::check_text;
use crate::problem::{FieldError, Problem};
use crate::schemas::episodes::{EpisodeTask, Randomness, RecordedCamera};
use crate::schemas::values::MAX_INTEGER;
use crate::schemas::words::EpisodeFormat;

/// Order of a recording; one of `task` and `tasks`.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
#[schemars(rename = "EpisodesSubmission", extend("required" = ["count"]))]
pub struct EpisodesDraft {
    /// Of the dataset's cards; the instructions when absent.
    #[schemars(regex(pattern = r"^\S([^\x00-\x1F\x7F-\x9F]{0,98}\S)?$"))]
    pub title: Option<String>,
    pub robot: String,
    /// An instruction in words, or a task as `GET /scenes/{scene_id}/tasks` gives it.
    #[schemars(with = "Option<EpisodeTask>")]
    pub task: Option<Value>,
    /// Tasks that take turns.
    #[schemars(with = "Option<Vec<EpisodeTask>>", length(min = 1, max = 20))]
    pub tasks: Option<Vec<Value>>,
    /// Episodes that succeed.
    #[schemars(range(min = 1, max = 100_000))]
    pub count: u64,
    #[schemars(range(min = 0, max = MAX_INTEGER))]
    pub seed: u64,
    /// Differences between episodes.
    #[schemars(with = "Randomness")]
    pub randomize: Value,
    pub record: RecordDraft,
    /// `lerobot-v3.0` when absent.
    #[schemars(with = "Vec<EpisodeFormat>", length(min = 1, max = 20))]
    pub formats: Vec<String>,
    /// Whether attempts that fail become episodes, too; they do not count.
    pub keep_failures: bool,
    /// Attempts until the recording fails, at least `count`; 4 for each episode, and 20, when absent.
    #[schemars(range(min = 1, max = 1_000_000))]
    pub max_attempts: Option<u64>,
}

/// Recorded data of each episode.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
#[schemars(rename = "EpisodeRecording")]
pub struct RecordDraft {
    /// Usual cameras or own ones, which have at most 4,194,304 pixels together; the three usual ones when absent.
    #[schemars(with = "Vec<RecordedCamera>", length(max = 8))]
    pub cameras: Vec<Value>,
    /// Side of the images of usual cameras.
    #[schemars(range(min = 16, max = 2048), extend("multipleOf" = 2))]
    pub size_px: u32,
    /// Frames per second.
    #[schemars(range(min = 1, max = 100))]
    pub fps: u32,
    /// Needs a camera; one of the formats must be robomimic or parquet-png.
    pub depth: bool,
    /// Needs a camera; one of the formats must be robomimic or parquet-png.
    pub instance_ids: bool,
    /// Points in a cloud of what all cameras see. Needs a camera; one of the formats must be robomimic or parquet-png.
    #[schemars(range(min = 1, max = 8192))]
    pub point_cloud: Option<u32>,
}

impl Default for EpisodesDraft {
    fn default() -> Self {
        Self {
            title: None,
            robot: "panda".to_owned(),
            task: None,
            tasks: None,
            count: 0,
            seed: 0,
            randomize: json!("usual"),
            record: RecordDraft::default(),
            formats: vec!["lerobot-v3.0".to_owned()],
            keep_failures: false,
            max_attempts: None,
        }
    }
}

impl Default for RecordDraft {
    fn default() -> Self {
        let cameras = ["side", "front", "wrist"].map(|name| json!(name)).to_vec();
        Self { cameras, size_px: 224, fps: 15, depth: false, instance_ids: false, point_cloud: None }
    }
}

impl EpisodesDraft {
    /// The tasks with their pointers.
    pub fn tasks(&self) -> Vec<(String, &Value)> {
        let one = self.task.iter().map(|task| ("/task".to_owned(), task));
        let several = self.tasks.iter().flatten().enumerate();
        one.chain(several.map(|(index, task)| (format!("/tasks/{index}"), task))).collect()
    }

    /// Checks the length of texts.
    ///
    /// # Errors
    ///
    /// A [`Problem`] with every text that will not do.
    pub fn check_texts(&self, max_chars: usize) -> Result<(), Problem> {
        let texts = self.tasks().into_iter().filter_map(|(pointer, task)| Some((pointer, task.as_str()?)));
        let wrong = |(pointer, text)| {
            let error = check_text(text, max_chars).err()?;
            Some(FieldError::new(pointer, error.to_string()))
        };
        let errors: Vec<FieldError> = texts.filter_map(wrong).collect();
        if errors.is_empty() { Ok(()) } else { Err(Problem::invalid(errors)) }
    }
}
