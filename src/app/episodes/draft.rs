//! An order of episodes as a client states it.

use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use crate::app::submission::check_text;
use crate::problem::{FieldError, Problem};

/// An order of episodes as a client states it: its tasks, cameras, axes and formats are not read yet.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct EpisodesDraft {
    /// Of the dataset's cards; the instructions if absent.
    pub title: Option<String>,
    pub robot: String,
    /// An instruction in words, or a task as `GET /scenes/{scene_id}/tasks` gives it.
    pub task: Option<Value>,
    /// Several, which take turns.
    pub tasks: Option<Vec<Value>>,
    /// Episodes that succeed.
    pub count: u64,
    pub seed: u64,
    /// `usual`, `wide`, `none`, or amplitudes by axis.
    pub randomize: Value,
    pub record: RecordDraft,
    pub formats: Vec<String>,
    pub keep_failures: bool,
    pub max_attempts: Option<u64>,
}

/// Recorded data.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct RecordDraft {
    /// Names of usual cameras, or own ones; none at all is possible.
    pub cameras: Vec<Value>,
    /// Side of the images of usual cameras.
    pub size_px: u32,
    pub fps: u32,
    pub depth: bool,
    pub instance_ids: bool,
    /// Points in the cloud of each frame.
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
        let errors: Vec<FieldError> = texts
            .filter_map(|(pointer, text)| Some(FieldError::new(pointer, check_text(text, max_chars).err()?)))
            .collect();
        if errors.is_empty() { Ok(()) } else { Err(Problem::invalid(errors)) }
    }
}
