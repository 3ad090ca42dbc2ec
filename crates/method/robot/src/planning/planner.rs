//! From a problem to a path.

use rand::Rng;

use super::failure::PlanFailure;
use super::rrt_connect::{Search, connect, length};
use super::sampler::{SampleOrder, Sampler};
use super::settings::PlanOptions;
use super::simplify::simplify;
use crate::collision::arm::MAX_JOINTS;
use crate::collision::lane_arm::Configuration;
use crate::collision::lanes::LANE_COUNT;
use crate::collision::{Arm, Checker, Obstacle};

/// Planning problem: an arm, its obstacles, start and goals.
#[derive(Clone, Copy, Debug)]
pub struct Problem<'a> {
    pub arm: &'a Arm,
    pub obstacles: &'a [Obstacle],
    pub start: &'a [f64],
    /// Any one of them will do.
    pub goals: &'a [Vec<f64>],
}

/// A path that touches nothing.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// Configurations from the start to one of the goals; the arm moves straight in joint space between them.
    pub path: Vec<Vec<f64>>,
    /// The length of the path in joint space, before and after it was simplified.
    pub found_length: f64,
    pub length: f64,
    /// Numbers of samples and nodes that the search used.
    pub samples: usize,
    pub nodes: usize,
}

/// An arm among obstacles, ready to plan.
#[derive(Clone, Debug)]
pub struct Planner<'a> {
    arm: &'a Arm,
    obstacles: &'a [Obstacle],
    checker: Checker,
    settings: PlanOptions,
}

/// Plans a path. Equal problems, settings and random numbers give equal paths, on every processor.
///
/// # Errors
/// Why there is no path; see [`PlanFailure`].
pub fn plan(problem: &Problem, settings: &PlanOptions, rng: &mut impl Rng) -> Result<Plan, PlanFailure> {
    let planner = Planner::new(problem.arm, problem.obstacles, settings.clone());
    let search = planner.search(problem.start, problem.goals, rng)?;
    Ok(planner.finish(&search, problem.start, problem.goals, rng))
}

/// A path as it was found, before it is simplified.
#[derive(Clone, Debug)]
pub struct FoundPath {
    points: Vec<Configuration>,
    samples: usize,
    nodes: usize,
}

impl<'a> Planner<'a> {
    pub fn new(arm: &'a Arm, obstacles: &'a [Obstacle], settings: PlanOptions) -> Self {
        let checker = Checker::new(arm, obstacles, settings.padding_m);
        Self { arm, obstacles, checker, settings }
    }

    /// The check that the planner uses.
    pub fn checker(&self) -> &Checker {
        &self.checker
    }

    pub fn settings(&self) -> &PlanOptions {
        &self.settings
    }

    pub fn arm(&self) -> &Arm {
        self.arm
    }

    /// Finds a path from the start to a goal that can be reached.
    ///
    /// # Errors
    /// Why there is no path; see [`PlanFailure`].
    pub fn search(
        &self,
        start: &[f64],
        goals: &[Vec<f64>],
        rng: &mut impl Rng,
    ) -> Result<FoundPath, PlanFailure> {
        let from = self.check_start(start)?;
        let goals = self.goals(goals)?;
        let limits = self.arm.joints().iter().map(|joint| joint.limits);
        let Search { path, samples, nodes } =
            connect(&self.checker, limits, from, &goals, &self.settings, rng);
        path.map(|points| FoundPath { points, samples, nodes }).ok_or(PlanFailure::NoPath { samples, nodes })
    }

    /// Simplifies a path that was found between `start` and one of `goals`.
    pub fn finish(&self, found: &FoundPath, start: &[f64], goals: &[Vec<f64>], rng: &mut impl Rng) -> Plan {
        let mut sampler =
            Sampler::new(self.arm.joints().iter().map(|joint| joint.limits), SampleOrder::Shifted, rng);
        let points = simplify(&self.checker, &found.points, &self.settings, &mut sampler, rng);
        let mut path: Vec<Vec<f64>> = points
            .iter()
            .map(|point| point[..self.arm.dof()].iter().map(|&p| f64::from(p)).collect())
            .collect();
        // The ends as they were given, not as rounded to `f32`.
        if let Some(first) = path.first_mut() {
            *first = start.to_vec();
        }
        let end = points.last().and_then(|last| goals.iter().find(|goal| padded(goal) == *last));
        if let (Some(last), Some(end)) = (path.last_mut(), end) {
            *last = end.clone();
        }
        Plan {
            path,
            found_length: f64::from(length(&found.points)),
            length: f64::from(length(&points)),
            samples: found.samples,
            nodes: found.nodes,
        }
    }

    /// The start as the checks hold it, if the arm can stand there.
    ///
    /// # Errors
    /// If it has the wrong length, is outside of the limits, or in collision.
    pub fn check_start(&self, start: &[f64]) -> Result<Configuration, PlanFailure> {
        self.has_all_joints(start)?;
        if let Some((joint, position)) = self.outside_limits(start) {
            return Err(PlanFailure::StartOutsideLimits { joint, position });
        }
        let from = padded(start);
        if !self.checker.is_free(&from) {
            let clearance = self.arm.clearance(start, self.obstacles);
            return Err(PlanFailure::StartInCollision { clearance });
        }
        Ok(from)
    }

    /// The goals that are within the limits and free.
    fn goals(&self, goals: &[Vec<f64>]) -> Result<Vec<Configuration>, PlanFailure> {
        goals.iter().try_for_each(|goal| self.has_all_joints(goal))?;
        let first = goals.first().ok_or(PlanFailure::GoalUnreachable)?;
        let within: Vec<&Vec<f64>> =
            goals.iter().filter(|goal| self.outside_limits(goal).is_none()).collect();
        let Some(&first_within) = within.first() else {
            let (joint, position) = self.outside_limits(first).unwrap_or_default();
            return Err(PlanFailure::GoalOutsideLimits { joint, position });
        };
        let mut free = Vec::with_capacity(within.len());
        for group in within.chunks(LANE_COUNT) {
            let lanes: [Configuration; LANE_COUNT] =
                std::array::from_fn(|k| padded(group[k.min(group.len() - 1)]));
            let colliding = self.checker.colliding(&lanes);
            free.extend((0..group.len()).filter(|k| colliding & (1 << k) == 0).map(|k| lanes[k]));
        }
        if free.is_empty() {
            let clearance = self.arm.clearance(first_within, self.obstacles);
            return Err(PlanFailure::GoalInCollision { clearance });
        }
        Ok(free)
    }

    fn has_all_joints(&self, configuration: &[f64]) -> Result<(), PlanFailure> {
        let (found, expected) = (configuration.len(), self.arm.dof());
        if found == expected { Ok(()) } else { Err(PlanFailure::WrongLength { found, expected }) }
    }

    /// The first joint that is outside of its limits, and its position.
    pub(super) fn outside_limits(&self, configuration: &[f64]) -> Option<(usize, f64)> {
        let joints = self.arm.joints().iter().zip(configuration).enumerate();
        let mut outside = joints.filter(|(_, (joint, position))| !joint.limits.admits(**position));
        outside.next().map(|(index, (_, &position))| (index, position))
    }
}

/// A configuration as the checks hold it.
pub(super) fn padded(configuration: &[f64]) -> Configuration {
    let mut lanes = [0.0; MAX_JOINTS];
    lanes.iter_mut().zip(configuration).for_each(|(lane, &position)| *lane = position as f32);
    lanes
}
