//! Rigid bodies on a table: settling under gravity, resolving overlaps, and the physical metrics of a layout.
//!
//! Everything is deterministic: fixed order, fixed time steps, the same bytes with any number of threads. World frame,
//! SI units. Of the domain types the crate takes the support tree. It must not depend on files, clocks or the pipeline.
//!
//! ```
//! use geometry::{DVec3, Pose};
//! use physics::settle::angle_between_rad;
//!
//! let upright = Pose::upright(DVec3::ZERO, 0.0);
//! let turned = Pose::upright(DVec3::ZERO, 0.5);
//! assert!((angle_between_rad(&upright, &turned) - 0.5).abs() < 1e-12);
//! ```

pub mod body;
pub mod hull_set;
pub mod contacts;
pub mod rolling;
pub mod rigid_world;
pub mod settle;
pub mod metrics;
pub mod support;
pub mod resolve;
pub mod clutter;
#[cfg(test)]
mod test_bodies;

pub use body::Body;
pub use clutter::{ClutterError, ClutterProblem, ClutterSettings, DropRole, DroppedLayout, drop_clutter};
pub use metrics::{CertifySettings, Collisions, Stability, collisions, stability};
pub use resolve::{ResolveError, ResolveProblem, ResolveSettings, ResolvedLayout, resolve};
pub use settle::{SettleError, SettleSettings, SettledPoses, settle};
pub use support::{SupportFinding, carriers, support, support_by_hulls};
