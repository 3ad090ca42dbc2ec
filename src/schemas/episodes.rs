//! Parts of orders of episodes, and the progress of a recording: types of `demonstrations` and `store`.

use schemars::JsonSchema;

use super::tasks::Task;
use super::values::TEXT_PATTERN;
use super::words::UsualCamera;

/// A task in words, or as a document.
#[derive(JsonSchema)]
#[schemars(untagged)]
pub enum EpisodeTask {
    Instruction(Instruction),
    Task(Task),
}

/// A task in words.
#[derive(JsonSchema)]
pub struct Instruction(#[schemars(length(min = 1, max = 4000), regex(pattern = TEXT_PATTERN))] pub String);

/// Named sets of amplitudes.
#[derive(JsonSchema)]
#[schemars(rename_all = "snake_case")]
pub enum UsualRandomization {
    Usual,
    Wide,
    None,
}

/// Numbers are drawn evenly from -x to x, factors from 1 - x to 1 + x; what is absent does not vary.
#[derive(JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct RandomizationAmplitudes {
    /// Objects along x and y, m.
    #[schemars(default, range(min = 0.0, max = 0.3))]
    pub position_m: f64,
    /// Objects about the vertical.
    #[schemars(default, range(min = 0.0, max = 3.15))]
    pub yaw_rad: f64,
    /// Probability that an object is absent which no task names.
    #[schemars(default, range(min = 0.0, max = 1.0))]
    pub absent_distractors: f64,
    /// Most other objects of the catalog on the table.
    #[schemars(default, range(min = 0, max = 8))]
    pub added_distractors: u32,
    /// Factor.
    #[schemars(default, range(min = 0.0, max = 0.5))]
    pub object_color: f64,
    /// Factor.
    #[schemars(default, range(min = 0.0, max = 0.5))]
    pub table_color: f64,
    /// Probability of another material of an object, in the same color.
    #[schemars(default, range(min = 0.0, max = 1.0))]
    pub object_material: f64,
    /// Probability of another material of the table's top.
    #[schemars(default, range(min = 0.0, max = 1.0))]
    pub table_material: f64,
    /// Azimuth of the light; half of it for the elevation.
    #[schemars(default, range(min = 0.0, max = 3.15))]
    pub light_direction_rad: f64,
    /// Factor.
    #[schemars(default, range(min = 0.0, max = 0.5))]
    pub light_brightness: f64,
    /// Factor.
    #[schemars(default, range(min = 0.0, max = 0.5))]
    pub backdrop_color: f64,
    /// Joints of the arm at the start.
    #[schemars(default, range(min = 0.0, max = 0.3))]
    pub start_rad: f64,
    /// Cameras along each of their axes, m.
    #[schemars(default, range(min = 0.0, max = 0.2))]
    pub camera_position_m: f64,
    /// Cameras about each of their axes.
    #[schemars(default, range(min = 0.0, max = 0.2))]
    pub camera_angle_rad: f64,
    /// Factor.
    #[schemars(default, range(min = 0.0, max = 0.2))]
    pub focal_length: f64,
    /// Factor.
    #[schemars(default, range(min = 0.0, max = 0.5))]
    pub mass: f64,
    /// Factor.
    #[schemars(default, range(min = 0.0, max = 0.5))]
    pub friction: f64,
}

/// A camera of the client.
#[derive(JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct EpisodeCamera {
    #[schemars(regex(pattern = r"^[A-Za-z0-9_-]{1,24}$"))]
    pub name: String,
    pub mount: CameraMount,
    pub eye_m: CameraPoint,
    pub target_m: CameraPoint,
    /// Horizontal.
    #[schemars(range(min = 0.1, max = 2.8))]
    pub fov_x_rad: f64,
    #[schemars(range(min = 16, max = 4096), extend("multipleOf" = 2))]
    pub width_px: u32,
    #[schemars(range(min = 16, max = 4096), extend("multipleOf" = 2))]
    pub height_px: u32,
}

/// Frame that a camera is fixed to. The table's top is at z = 0 in the world; +z of the tool points out of the hand.
#[derive(JsonSchema)]
#[schemars(rename_all = "snake_case")]
pub enum CameraMount {
    World,
    Tool,
}

/// Meters.
#[derive(JsonSchema)]
pub struct CameraPoint(#[schemars(inner(range(min = -99.0, max = 99.0)), length(equal = 3))] pub Vec<f64>);

/// Number of attempts.
#[derive(JsonSchema)]
#[schemars(inline)]
pub struct AttemptCount(#[schemars(range(min = 0, max = 1_000_000))] pub u64);

/// Progress of a recording.
#[derive(JsonSchema)]
pub struct RecordingProgress {
    #[schemars(range(min = 0, max = 1_000_000))]
    pub attempts: u64,
    #[schemars(range(min = 1, max = 1_000_000))]
    pub max_attempts: u64,
    /// Also those beyond what is wanted, which are no part of the dataset.
    #[schemars(range(min = 0, max = 1_000_000))]
    pub successes: u64,
    #[schemars(range(min = 1, max = 100_000))]
    pub wanted: u64,
    #[schemars(range(min = 0.0, max = 1.0))]
    pub success_rate: Option<f64>,
    /// By the pace of the last attempts, without assembling; null before the first success.
    #[schemars(range(min = 0.0, max = 3_200_000_000.0))]
    pub seconds_left: Option<f64>,
}

/// A named set of amplitudes, or amplitudes.
#[derive(JsonSchema)]
#[schemars(inline, untagged)]
pub enum Randomness {
    Usual(UsualRandomization),
    Amplitudes(RandomizationAmplitudes),
}

/// A usual camera, or one of the client.
#[derive(JsonSchema)]
#[schemars(inline, untagged)]
pub enum RecordedCamera {
    Usual(UsualCamera),
    Own(EpisodeCamera),
}
