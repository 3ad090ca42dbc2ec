//! Datasets: frozen, named, verifiable sets of finished scenes.
//!
//! [`freeze::freeze`] reads bundles ([`bundle`]), selects scenes ([`filter`]), assigns them to splits ([`splits`]) and
//! writes `NAME/vVERSION/` with tar shards, statistics, licenses and `dataset.json` ([`dataset_manifest`]), which is
//! written last. [`verify::verify`] reads everything again. [`leakage`] checks splits and shares no code with the
//! assignment.
//!
//! Equal inputs give equal bytes; a resumed freeze gives the bytes of a fresh one. Memory holds one scene and a few
//! kilobytes of facts per scene. The crate reads and writes files; it must not depend on the pipeline, the store,
//! servers, clients or clocks.
//!
//! ```
//! use datasets::splits::{Group, SplitPlan, assign};
//!
//! let plan: SplitPlan = "train=0.5,test=0.5".parse()?;
//! let groups = [Group::of(["a", "b"]), Group::of(["c", "d"])];
//! let splits = assign(&groups, &plan, &Default::default());
//! assert_ne!(splits[0], splits[1]);
//! # Ok::<(), datasets::splits::SplitPlanError>(())
//! ```

// What is read.
pub mod error;
pub mod bundle;
pub mod sources;
pub mod batch_output;
pub mod facts;
pub mod coverage;
pub mod filter;

// How scenes are divided.
pub mod sharing;
pub mod splits;
pub mod leakage;

// What is written.
pub mod canonical;
pub mod dataset_manifest;
pub mod tar;
pub mod members;
pub mod files;
pub mod progress;
pub mod containers;
pub mod licences;
pub mod statistics;
pub mod selection;
pub mod candidates;
pub mod versions;
pub mod freeze;

// What is checked.
pub mod verify;

#[cfg(test)]
mod tests;

pub use error::DatasetError;
