//! (in progress)
pub mod checkpoint;
pub mod error;
