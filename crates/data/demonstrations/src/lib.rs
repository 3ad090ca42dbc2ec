//! Demonstrations: a task in a scene, done again and again with other places, colors, light, cameras and starts.
//!
//! A [`Setup`] is what all demonstrations of a dataset share: scene, robot, tasks with their grasps, cameras, rate. An
//! attempt has a number, from which with the seed of the dataset everything follows: the [`Sample`] of the
//! randomization, the motion, and the images. [`attempt`] gives an [`episodes::EpisodeUnit`], or why there is none.
//! Attempts know nothing of each other, so any number of workers may make them in any order.
//!
//! World frame, SI units. Equal setups and numbers give equal bytes. The crate knows neither files nor clocks.

// What varies.
pub mod randomization;
mod spread;
pub mod sample;
mod arrangement;
mod distractors;
mod finish;

// What is recorded.
pub mod camera;
mod motion_window;
pub mod vectors;
mod stage;
mod point_cloud;

// Attempts.
pub mod setup;
pub mod record;
mod attempt;

#[cfg(test)]
mod tests;

pub use attempt::{Attempted, attempt};
pub use camera::{CameraSpec, Mount};
pub use distractors::Distractor;
pub use finish::FinishSample;
pub use randomization::Randomization;
pub use record::EpisodeRecord;
pub use sample::Sample;
pub use setup::{Setup, SetupError, TaskPlace, Work};
