//! Measures inverse kinematics: how many of 10,000 random reachable poses are recovered within 1e-6 (meters and
//! radians), how far off the worst solution is, how many solutions there are, and the time of a call.
//!
//! ```text
//! cargo run --release -p tabletopgen-robot --example time_inverse
//! ```

use std::error::Error;
use std::hint::black_box;
use std::time::Instant;

use nalgebra::{Isometry3, Translation3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use robot::inverse::{DampedLeastSquares, InverseKinematics};
use robot::kinematics::tool_pose;
use robot::model::Robot;

const POSES: usize = 10_000;
const RECOVERED: f64 = 1e-6;

#[expect(clippy::print_stdout, reason = "the table is what this program is for")]
fn main() -> Result<(), Box<dyn Error>> {
    for (name, variant) in [("panda", None), ("piper", None), ("piper", Some("old_zero"))] {
        let robot = Robot::built_in(name, variant)?;
        let arm = InverseKinematics::new(&robot).ok_or("no closed form")?;
        let goals = configurations(&robot, 1);
        let targets: Vec<Isometry3<f64>> = goals.iter().map(|goal| tool_pose(&robot, goal)).collect();

        let mut microseconds: Vec<f64> = Vec::with_capacity(POSES);
        let (mut recovered, mut worst, mut solutions) = (0, 0.0_f64, 0);
        for target in &targets {
            let start = Instant::now();
            let found = black_box(arm.solve(black_box(target)));
            microseconds.push(start.elapsed().as_secs_f64() * 1e6);
            let errors = found.iter().map(|solution| apart(&tool_pose(&robot, solution), target));
            let error = errors.fold(if found.is_empty() { f64::INFINITY } else { 0.0 }, f64::max);
            recovered += usize::from(error <= RECOVERED);
            worst = worst.max(error);
            solutions += found.len();
        }
        microseconds.sort_by(f64::total_cmp);
        println!(
            "{name} {}: {recovered} of {POSES} recovered, worst {worst:.1e}, {:.1} solutions a pose, {:.1} us median, \
             {:.1} us 99th percentile, {:.0} us slowest",
            variant.unwrap_or("as stated"),
            solutions as f64 / POSES as f64,
            microseconds[POSES / 2],
            microseconds[POSES * 99 / 100],
            microseconds[POSES - 1],
        );
        unreachable(&arm, &targets[..1000]);
        damped(&robot, &goals[..1000], &targets[..1000]);
    }
    Ok(())
}

/// The time until a pose is known to be out of reach: each target one meter further out.
#[expect(clippy::print_stdout, reason = "the table is what this program is for")]
fn unreachable(arm: &InverseKinematics, targets: &[Isometry3<f64>]) {
    let start = Instant::now();
    let further = targets.iter().map(|target| {
        let outward = target.translation.vector.normalize();
        Translation3::from(outward) * target
    });
    let found = further.filter(|target| !arm.solve(target).is_empty()).count();
    let microseconds = start.elapsed().as_secs_f64() * 1e6 / targets.len() as f64;
    println!("  one meter further out: {found} of {} solved, {microseconds:.0} us mean", targets.len());
}

/// Damped least squares from starts within 0.3 of a solution in each joint.
#[expect(clippy::print_stdout, reason = "the table is what this program is for")]
fn damped(robot: &Robot, goals: &[Vec<f64>], targets: &[Isometry3<f64>]) {
    let mut random = ChaCha8Rng::seed_from_u64(2);
    let starts: Vec<Vec<f64>> = goals
        .iter()
        .map(|goal| {
            let near = |(q, l): (&f64, &robot::model::JointLimits)| {
                (q + random.random_range(-0.3..0.3)).clamp(l.min_position, l.max_position)
            };
            goal.iter().zip(robot.limits()).map(near).collect()
        })
        .collect();
    let start = Instant::now();
    let solve = |(start, target): (&Vec<f64>, _)| {
        DampedLeastSquares::PRECISE.solve(robot, target, start, start).is_ok()
    };
    let reached = starts.iter().zip(targets).filter(|pair| solve(*pair)).count();
    let microseconds = start.elapsed().as_secs_f64() * 1e6 / targets.len() as f64;
    println!("  damped least squares: {reached} of {} reached, {microseconds:.0} us mean", targets.len());
}

fn configurations(robot: &Robot, seed: u64) -> Vec<Vec<f64>> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut within = |l: &robot::model::JointLimits| random.random_range(l.min_position..=l.max_position);
    (0..POSES).map(|_| robot.limits().iter().map(&mut within).collect()).collect()
}

/// Difference of two poses: the larger of the distance in meters and the angle in radians.
fn apart(a: &Isometry3<f64>, b: &Isometry3<f64>) -> f64 {
    (a.translation.vector - b.translation.vector).norm().max(a.rotation.angle_to(&b.rotation))
}
