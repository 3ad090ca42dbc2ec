//! Limits of a planner's effort, and the resolution of its checks.

use super::sampler::SampleOrder;

/// Settings of [`plan`](super::plan). The defaults suit arms of six and seven turning joints.
///
/// Lengths in joint space are Euclidean: radians, and meters for a joint that slides.
#[derive(Clone, Debug, PartialEq)]
pub struct PlanOptions {
    /// Length by which a tree grows at once.
    pub step: f32,
    /// Number of configurations that are checked for each unit of length, at least eight on each edge.
    pub checks_per_unit: f32,
    /// Distance that is kept from obstacles, and half of it between bodies of the arm.
    pub padding_m: f64,
    pub sample_order: SampleOrder,
    /// The most configurations that are tried.
    pub max_samples: usize,
    /// The most configurations that both trees hold together.
    pub max_nodes: usize,
    pub domain: DynamicDomain,
    pub simplify: SimplifySettings,
}

/// A node near which growth failed is only tried for samples that are near it.
///
/// After Yershova, Jaillet, Siméon and LaValle, "Dynamic-domain RRTs" (2005), with a radius that adapts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DynamicDomain {
    /// The radius after the first failure; before, it is infinite.
    pub radius: f32,
    /// The share by which the radius shrinks with a failure and grows with a success.
    pub change: f32,
    /// The least radius.
    pub min_radius: f32,
}

/// Settings of making a path shorter and smoother.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SimplifySettings {
    /// The most rounds of shortcuts and corner cutting; a round without a change is the last.
    pub max_rounds: usize,
    /// A corner is cut only if that moves it by more than this.
    pub min_corner: f32,
    /// The most random attempts, in each round, to leave out configurations; 0 leaves it to the other operations.
    pub reduce_attempts: usize,
    /// The most random attempts, in each round, to move a configuration; 0 leaves it to the other operations.
    pub perturb_attempts: usize,
    /// The share of the way towards a random configuration by which one is moved.
    pub perturb_share: f32,
}

impl Default for PlanOptions {
    fn default() -> Self {
        Self {
            step: 1.0,
            checks_per_unit: 32.0,
            padding_m: 0.0,
            sample_order: SampleOrder::Fixed,
            max_samples: 100_000,
            max_nodes: 100_000,
            domain: DynamicDomain { radius: 4.0, change: 1e-4, min_radius: 1.0 },
            simplify: SimplifySettings {
                max_rounds: 5,
                min_corner: 0.1,
                reduce_attempts: 0,
                perturb_attempts: 0,
                perturb_share: 0.1,
            },
        }
    }
}
