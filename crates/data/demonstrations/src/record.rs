//! Record of an episode, from which it can be made again.

use geometry::Pose;
use manipulation::execution::PickReport;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use tasks::Task;

use crate::camera::CameraSpec;
use crate::randomization::Randomization;
use crate::sample::Sample;

/// The version of the form.
pub const FORMAT: &str = "tabletopgen-episode/4";

/// The record of an episode.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct EpisodeRecord {
    pub format: String,
    /// The version of the program that made it.
    pub version: String,
    /// Digest of the scene's bundle.
    pub scene: String,
    pub task: Task,
    /// The place of the task among the instructions of the dataset.
    pub task_index: usize,
    pub tasks: Vec<String>,
    /// The seed of the dataset, and the number of the attempt: with scene, task, cameras, rate and ranges these give
    /// the same bytes again.
    pub dataset_seed: u64,
    pub number: u64,
    pub fps: u32,
    pub depth: bool,
    pub instance_ids: bool,
    /// Points in the cloud of a frame.
    pub points: Option<u32>,
    pub cameras: Vec<CameraSpec>,
    pub randomization: Randomization,
    pub world_from_base: Pose,
    /// Values that the randomization drew.
    pub sample: Sample,
    /// Poses of the objects after they came to rest, before the robot moves: `world_from_object`, of those present.
    pub initial_poses: Vec<(String, Pose)>,
    /// Names by instance id.
    pub instances: Vec<String>,
    /// Seconds of the recording that were left out before the first frame.
    pub begins_s: f64,
    /// The grasps that were taken, and how far the objects slipped: [`PickReport`].
    pub picks: Value,
}

pub(crate) fn picks(reports: &[PickReport]) -> Value {
    serde_json::to_value(reports).unwrap_or_default()
}
