//! Solves motion planning problems from a file and writes the paths, with the times that they took.
//!
//! `plan_problems PROBLEMS.json SOLUTIONS.json REPEATS [SEED]`; `tabletopgen_checks.robots.planning_bar` makes the
//! problems and compares the solutions with those of another planner. Each problem is solved `REPEATS` times with the
//! same random numbers, and the least times count.

mod problems;

use std::error::Error;
use std::path::Path;
use std::time::Instant;

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use robot::collision::Obstacle;
use robot::planning::{Plan, PlanFailure, PlanOptions, Planner};
use robot::trajectory::{Corners, Curve, TimeLaw, TrajectoryOptions, time_free_path};
use serde::Serialize;

use crate::problems::{ProblemEntry, ProblemFile};

/// Result of one problem.
#[derive(Serialize)]
struct Solution {
    name: String,
    set: String,
    /// `solved`, or the code of the failure.
    outcome: &'static str,
    plan_us: f64,
    /// Planning and simplification.
    total_us: f64,
    /// Timing of the path, which is not part of the total.
    trajectory_us: f64,
    /// 0 if the path could not be timed.
    duration_s: f64,
    /// Duration of the path within the limits of velocity and acceleration alone, with rounded corners.
    unfiltered_s: f64,
    found_length: f64,
    length: f64,
    samples: usize,
    nodes: usize,
    path: Vec<Vec<f64>>,
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let (input, output, repeats, seed) = match arguments.as_slice() {
        [input, output, repeats] => (input, output, repeats.parse()?, 0),
        [input, output, repeats, seed] => (input, output, repeats.parse()?, seed.parse()?),
        _ => return Err("usage: plan_problems PROBLEMS.json SOLUTIONS.json REPEATS [SEED]".into()),
    };
    let file = ProblemFile::read(Path::new(input))?;
    let arm = file.arm.build()?;
    let mut solutions = Vec::with_capacity(file.problems.len());
    for entry in &file.problems {
        let obstacles = entry.obstacles()?;
        let planner = Planner::new(&arm, &obstacles, PlanOptions::default());
        solutions.push(solve(&planner, entry, repeats, seed));
    }
    std::fs::write(output, serde_json::to_vec(&solutions)?)?;
    Ok(())
}

fn solve(planner: &Planner, entry: &ProblemEntry, repeats: usize, seed: u64) -> Solution {
    let (mut plan_us, mut total_us) = (f64::INFINITY, f64::INFINITY);
    let mut result = Err(PlanFailure::GoalUnreachable);
    for _ in 0..repeats.max(1) {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let begin = Instant::now();
        let found = planner.search(&entry.start, &entry.goals, &mut rng);
        let searched_us = begin.elapsed().as_secs_f64() * 1e6;
        result = found.map(|found| planner.finish(&found, &entry.start, &entry.goals, &mut rng));
        plan_us = plan_us.min(searched_us);
        total_us = total_us.min(begin.elapsed().as_secs_f64() * 1e6);
        if result.is_err() {
            break;
        }
    }
    let mut solution = Solution {
        name: entry.name.clone(),
        set: entry.set.clone(),
        outcome: result.as_ref().map_or_else(PlanFailure::code, |_| "solved"),
        plan_us,
        total_us,
        trajectory_us: 0.0,
        duration_s: 0.0,
        unfiltered_s: 0.0,
        found_length: 0.0,
        length: 0.0,
        samples: 0,
        nodes: 0,
        path: Vec::new(),
    };
    if let Ok(Plan { path, found_length, length, samples, nodes }) = result {
        let limits: Vec<_> = planner.arm().joints().iter().map(|joint| joint.limits).collect();
        let begin = Instant::now();
        let settings = TrajectoryOptions::default();
        let timed =
            time_free_path(&path, &limits, &settings, planner.checker(), planner.settings().checks_per_unit);
        solution.trajectory_us = begin.elapsed().as_secs_f64() * 1e6;
        solution.duration_s = timed.map_or(0.0, |trajectory| trajectory.duration_s());
        if let Ok(curve) = Curve::along(&path, settings.spacing, Corners::Rounded) {
            solution.unfiltered_s = TimeLaw::fastest(&curve, &limits).duration_s();
        }
        solution = Solution { found_length, length, samples, nodes, path, ..solution };
    }
    solution
}

impl ProblemEntry {
    fn obstacles(&self) -> Result<Vec<Obstacle>, Box<dyn Error>> {
        self.obstacles.iter().map(|obstacle| obstacle.build()).collect()
    }
}
