//! Two trees that grow towards each other: RRT-Connect.

use rand::Rng;

use super::metric::{distance, toward};
use super::sampler::Sampler;
use super::settings::PlanOptions;
use super::tree::Tree;
use crate::collision::Checker;
use crate::collision::lane_arm::Configuration;
use crate::model::limits::JointLimits;

/// Result of a search.
pub struct Search {
    /// From the start to a goal; `None` if the limits of the settings were met before.
    pub path: Option<Vec<Configuration>>,
    pub samples: usize,
    pub nodes: usize,
}

/// Finds a path from `start` to the nearest of `goals` that is connected. All of them must be free.
///
/// RRT-Connect (Kuffner and LaValle, 2000): each sample extends one tree by one step, and from there straight on to
/// the other tree as far as it is free. The smaller tree grows, and nodes that fail are tried from nearby only.
pub fn connect(
    checker: &Checker,
    limits: impl Iterator<Item = JointLimits>,
    start: Configuration,
    goals: &[Configuration],
    settings: &PlanOptions,
    rng: &mut impl Rng,
) -> Search {
    let free =
        |from: &Configuration, to: &Configuration| checker.edge_is_free(from, to, settings.checks_per_unit);
    if let Some(&goal) = goals.iter().find(|goal| free(&start, goal)) {
        return Search { path: Some(vec![start, goal]), samples: 0, nodes: 2 };
    }
    let tree = || Tree::new(checker.dof(), checker.backend());
    let (mut grown, mut other) = (tree(), tree());
    grown.add(start, None);
    for &goal in goals {
        other.add(goal, None);
    }
    let mut grown_is_start = true;
    let mut sampler = Sampler::new(limits, settings.sample_order, rng);
    let domain = settings.domain;
    for samples in 1..=settings.max_samples {
        if grown.len() + other.len() >= settings.max_nodes {
            break;
        }
        if samples > 1 && grown.len().abs_diff(other.len()) < grown.len() {
            std::mem::swap(&mut grown, &mut other);
            grown_is_start = !grown_is_start;
        }
        let sample = sampler.sample();
        let (near, near_distance) = grown.nearest(&sample);
        let node = *grown.node(near);
        if node.radius < near_distance {
            continue;
        }
        let reached = if near_distance < settings.step {
            sample
        } else {
            toward(&node.configuration, &sample, settings.step / near_distance)
        };
        if !free(&node.configuration, &reached) {
            let radius = if node.radius.is_finite() {
                (node.radius * (1.0 - domain.change)).max(domain.min_radius)
            } else {
                domain.radius
            };
            grown.set_radius(near, radius);
            continue;
        }
        if node.radius.is_finite() {
            grown.set_radius(near, node.radius * (1.0 + domain.change));
        }
        let mut last = grown.add(reached, Some(near));
        let (partner, gap) = other.nearest(&reached);
        let goal = other.node(partner).configuration;
        let steps = (gap / settings.step).ceil().max(1.0) as usize;
        let mut from = reached;
        let connected = (1..=steps).all(|step| {
            let next = if step == steps { goal } else { toward(&reached, &goal, step as f32 / steps as f32) };
            let is_free = free(&from, &next);
            if is_free && step < steps {
                last = grown.add(next, Some(last));
                from = next;
            }
            is_free
        });
        if connected {
            let mut path: Vec<Configuration> = grown.branch(last).collect();
            path.reverse();
            path.extend(other.branch(partner));
            if !grown_is_start {
                path.reverse();
            }
            return Search { path: Some(path), samples, nodes: grown.len() + other.len() };
        }
    }
    Search { path: None, samples: settings.max_samples, nodes: grown.len() + other.len() }
}

/// The length of a path.
pub fn length(path: &[Configuration]) -> f32 {
    path.windows(2).map(|ends| distance(&ends[0], &ends[1])).sum()
}
