//! Lab tools: benchmarks of the pipeline, synthetic images with ground truth, and mock vendors.
//!
//! No product crate may depend on this crate: it stands above the server and has its own binary, `tabletopgen-lab`.
//!
//! ```
//! use lab::synthetic_images::{Split, synthesize};
//!
//! let sample = synthesize(Split::Test, 0, 64);
//! assert_eq!(sample.truth.width_px.max(sample.truth.height_px), 64);
//! ```

pub mod app;
pub mod cli;
pub mod mock_vendors;
pub mod benchmark;
pub mod synthetic_images;
