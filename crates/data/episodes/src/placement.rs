//! Place of an episode in a dataset.

use crate::description::DatasetDescription;
use crate::unit::EpisodeUnit;

/// The place of an episode in a dataset.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Placement {
    /// From 0, without gaps.
    pub episode_index: u64,
    /// The place of its first frame among all frames.
    pub first_frame: u64,
    pub frames: u64,
    pub task_index: usize,
    pub fps: u32,
}

impl Placement {
    pub(crate) fn new(
        unit: &EpisodeUnit,
        description: &DatasetDescription,
        episode_index: u64,
        first_frame: u64,
    ) -> Self {
        let (frames, task_index) = (unit.frames() as u64, unit.header().task);
        Self { episode_index, first_frame, frames, task_index, fps: description.fps() }
    }

    /// The time of a frame of the episode, seconds from its start: an exact quotient, never a sum of durations.
    pub fn time_s(&self, frame: u64) -> f64 {
        frame as f64 / f64::from(self.fps)
    }

    pub(crate) fn times_s(&self) -> Vec<f32> {
        (0..self.frames).map(|frame| self.time_s(frame) as f32).collect()
    }
}
