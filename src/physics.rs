//! Rigid bodies on a table: let them settle, move them apart, measure how well they stand.
//!
//! The module knows geometry and nothing of scenes, files or clocks. Everything is deterministic: one
//! thread, fixed order, fixed time steps. World frame, SI units.

pub mod body;
pub mod settle;

pub use body::Body;
pub use settle::{SettleError, SettleSettings, Settled, settle};
