//! Paths between configurations that touch nothing.
//!
//! - [`planner`]: from a problem to a path, or to the reason why there is none
//! - [`rrt_connect`], [`tree`], [`sampler`]: the search; [`simplify`]: shorter and smoother paths
//! - [`straight`]: straight motions of the tool, such as approach, lift and retreat

pub mod failure;
mod metric;
pub mod planner;
pub mod rrt_connect;
pub mod sampler;
pub mod settings;
pub mod simplify;
pub mod straight;
#[cfg(test)]
mod tests;
mod tree;

pub use failure::{PlanFailure, StraightMotionObstacle};
pub use planner::{Plan, Planner, Problem, plan};
pub use sampler::SampleOrder;
pub use settings::{DynamicDomain, PlanOptions, SimplifySettings};
