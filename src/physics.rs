//! Rigid bodies on a table: let them settle, move them apart, measure how well they stand.
//!
//! The module knows geometry and nothing of scenes, files or clocks. Everything is deterministic: one
//! thread, fixed order, fixed time steps. World frame, SI units.

pub mod body;
pub mod settle;
pub mod metrics;
pub mod resolve;
#[cfg(test)]
mod test_bodies;

pub use body::Body;
pub use metrics::{CertifySettings, Collisions, Stability, SupportFinding, collisions, stability, support};
pub use resolve::{ResolveError, ResolveProblem, ResolveSettings, Resolved, SupportedBy, resolve};
pub use settle::{SettleError, SettleSettings, Settled, settle};
