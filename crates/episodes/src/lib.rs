//! Robot demonstration episodes as datasets: LeRobot v3.0 and v2.1, robomimic HDF5, and Parquet with PNG.

// What is recorded.
pub mod error;
pub mod unit_of_measure;
mod names;
pub mod vector_layout;
pub mod description;
pub mod frame;
pub mod episode;

// One episode.
pub mod format;
mod pixels;
pub mod statistics;
pub mod camera_track;
pub mod encoder;
pub mod unit;
mod unit_bytes;

pub use encoder::EpisodeEncoder;
pub use error::EpisodeError;
pub use unit::EpisodeUnit;
