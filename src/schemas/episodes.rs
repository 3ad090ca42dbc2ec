//! Parts of orders of episodes that are one of several types.

use schemars::JsonSchema;

use super::values::TEXT_PATTERN;
use super::words::UsualCamera;
use demonstrations::Randomization;
use demonstrations::camera::CameraSpec;
use tasks::Task;

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

/// Number of attempts.
#[derive(JsonSchema)]
#[schemars(inline)]
pub struct AttemptCount(#[schemars(range(min = 0, max = 1_000_000))] pub u64);

/// A named set of amplitudes, or amplitudes.
#[derive(JsonSchema)]
#[schemars(inline, untagged)]
pub enum Randomness {
    Usual(UsualRandomization),
    Amplitudes(Randomization),
}

/// A usual camera, or one of the client.
#[derive(JsonSchema)]
#[schemars(inline, untagged)]
pub enum RecordedCamera {
    Usual(UsualCamera),
    Own(CameraSpec),
}
