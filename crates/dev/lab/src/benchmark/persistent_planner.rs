//! Test whether a motion problem can be solved: every planner that there is, again and again, until one has a path.
//!
//! The straight way is certified first. Then RRT-Connect searches with other seeds, steps, rules for failing nodes and
//! distances between checks than an execution's, each time with more samples. Only a path that the exact check
//! certifies counts.

use manipulation::execution::MotionProblem;
use rand::Rng;
use robot::collision::PathContact;
use robot::planning::{DynamicDomain, PlanOptions, Problem, SampleOrder, plan};

/// Between the points of a path that is certified nothing reaches deeper into anything than this, meters.
const TOLERANCE_M: f64 = 1e-3;
/// Samples of the first searches; every round of searches has twice as many as the one before.
const FIRST_SAMPLES: usize = 4_000;
const MAX_SAMPLES: usize = 1_000_000;
/// A node that fails is tried for all samples all the same: RRT-Connect as it was published.
const PLAIN: DynamicDomain = DynamicDomain { radius: f32::INFINITY, change: 0.0, min_radius: f32::INFINITY };

/// Checks exactly that the arm of a problem touches nothing on a path.
///
/// # Errors
/// Where it does.
pub fn certify(problem: &MotionProblem, path: &[Vec<f64>]) -> Result<(), PathContact> {
    problem.arm.certify_path(path, &problem.obstacles, 0.0, TOLERANCE_M)
}

/// Finds a path by any means. `may_go_on` is asked before each attempt.
pub fn solve(
    problem: &MotionProblem,
    may_go_on: &mut impl FnMut() -> bool,
    rng: &mut impl Rng,
) -> Option<Vec<Vec<f64>>> {
    let straight = vec![problem.start.clone(), problem.goal.clone()];
    if certify(problem, &straight).is_ok() {
        return Some(straight);
    }
    let goals = [problem.goal.clone()];
    let asked =
        Problem { arm: &problem.arm, obstacles: &problem.obstacles, start: &problem.start, goals: &goals };
    let mut samples = FIRST_SAMPLES;
    loop {
        for (step, checks_per_unit, domain) in [
            (1.0, 64.0, PlanOptions::default().domain),
            (0.3, 64.0, PLAIN),
            (2.0, 64.0, PLAIN),
            (0.5, 200.0, DynamicDomain { radius: 2.0, change: 1e-3, min_radius: 0.3 }),
        ] {
            if !may_go_on() {
                return None;
            }
            let options = PlanOptions {
                step,
                checks_per_unit,
                domain,
                sample_order: SampleOrder::Shifted,
                max_samples: samples,
                max_nodes: samples,
                ..PlanOptions::default()
            };
            if let Ok(found) = plan(&asked, &options, rng)
                && certify(problem, &found.path).is_ok()
            {
                return Some(found.path);
            }
        }
        samples = (2 * samples).min(MAX_SAMPLES);
    }
}
