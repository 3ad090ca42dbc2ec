//! The laboratory: benchmarks of the pipeline, synthetic images with ground truth, and mock vendors.
//!
//! Nothing that makes scenes may depend on this crate; it stands above the server and is a binary of its own.

pub mod app;
pub mod cli;
pub mod dev_providers;
pub mod evaluate;
pub mod synthetic;
