//! Rigid bodies on a table: let them settle, move them apart, measure how well they stand.
//!
//! The module knows geometry and nothing of scenes, files or clocks. Everything is deterministic: fixed
//! order, fixed time steps, the same bytes with any number of threads. World frame, SI units.

pub mod body;
mod hull_set;
mod contacts;
pub mod settle;
pub mod metrics;
pub mod support;
pub mod resolve;
#[cfg(test)]
mod test_bodies;

pub use body::Body;
pub use metrics::{CertifySettings, Collisions, Stability, collisions, stability};
pub use resolve::{ResolveError, ResolveProblem, ResolveSettings, Resolved, SupportedBy, resolve};
pub use settle::{SettleError, SettleSettings, Settled, settle};
pub use support::{SupportFinding, support, support_by_hulls};
