//! Robot demonstration episodes as datasets: LeRobot v3.0 and v2.1, robomimic HDF5, and Parquet with PNG.
//!
//! A [`DatasetDescription`] states what is recorded. An [`EpisodeEncoder`] takes the frames of one episode and makes
//! an [`EpisodeUnit`], which a job can store. A [`DatasetAssembler`] takes units in ascending numbers and writes
//! every format at once, without encoding again. Equal episodes give equal bytes, and it leaves no trace which worker
//! made their units.
//!
//! `state[t]` precedes `action[t]`, and the action is the commanded target. Meters, radians, quaternions w first and
//! without jumps of their sign, images with row 0 at the top, cameras with OpenCV axes.
//!
//! The crate knows nothing about scenes, planning, clocks and random numbers. It writes files and reads none but its
//! own.

// What is recorded.
pub mod error;
pub mod unit_of_measure;
mod names;
pub mod vector_layout;
pub mod limit_shares;
pub mod description;
pub mod frame;
pub mod point_cloud;
pub mod episode;

// One episode.
pub mod format;
mod pixels;
mod strip;
mod preview;
pub mod statistics;
pub mod camera_track;
pub mod encoder;
pub mod unit;
mod unit_bytes;

// A dataset.
mod part_folder;
pub mod placement;
mod numeric_features;
mod dataset_statistics;
mod parquet_table;
mod json_lines;
pub mod lerobot;
mod robomimic;
mod parquet_and_png;
pub mod card;
pub mod assembler;
mod dataset_files;

#[cfg(all(test, target_os = "linux"))]
mod full_disk_tests;

pub use assembler::DatasetAssembler;
pub use dataset_files::is_of_dataset;
pub use description::DatasetDescription;
pub use encoder::EpisodeEncoder;
pub use error::EpisodeError;
pub use part_folder::sync_tree;
pub use unit::EpisodeUnit;
