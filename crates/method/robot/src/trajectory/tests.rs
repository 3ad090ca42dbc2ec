//! Limits, ends and shape of finished trajectories.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::*;
use crate::collision::tests::seven_joints;
use crate::collision::{Arm, Checker, Obstacle};

/// Limits like those of the Panda's first joints, with a jerk that is felt.
fn limits(dof: usize) -> Vec<JointLimits> {
    let limit = |joint: usize| JointLimits {
        min_position: -2.9,
        max_position: 2.9,
        max_velocity: 2.0 + 0.1 * joint as f64,
        max_acceleration: 7.5 + joint as f64,
        max_jerk: 400.0,
        max_effort: 80.0,
    };
    (0..dof).map(limit).collect()
}

fn random_path(rng: &mut ChaCha8Rng, dof: usize) -> Vec<Vec<f64>> {
    let count = rng.random_range(2..7);
    (0..count).map(|_| (0..dof).map(|_| rng.random_range(-2.5..2.5)).collect()).collect()
}

#[test]
fn velocity_acceleration_and_jerk_stay_within_their_limits() {
    let mut rng = ChaCha8Rng::seed_from_u64(21);
    let limits = limits(7);
    let settings = TrajectoryOptions { acceleration_share: 1.0, ..TrajectoryOptions::default() };
    let mut peaks = [0.0_f64; 3];
    for round in 0..20 {
        let path = random_path(&mut rng, 7);
        let corners = if round % 4 == 3 { Corners::Stopped } else { Corners::Rounded };
        let settings = TrajectoryOptions { corners, ..settings };
        let trajectory = Trajectory::along(&path, &limits, &settings).expect("a trajectory");
        let step_s = 1e-4;
        let mut before = trajectory.at(0.0);
        for k in 1..=(trajectory.duration_s() / step_s) as usize + 1 {
            let point = trajectory.at(k as f64 * step_s);
            for (joint, limit) in limits.iter().enumerate() {
                let jerk = (point.acceleration[joint] - before.acceleration[joint]) / step_s;
                let share = [
                    point.velocity[joint].abs() / limit.max_velocity,
                    point.acceleration[joint].abs() / limit.max_acceleration,
                    jerk.abs() / limit.max_jerk,
                ];
                peaks = std::array::from_fn(|k| peaks[k].max(share[k]));
                assert!(limit.admits(point.position[joint]));
            }
            before = point;
        }
    }
    assert!(peaks.iter().all(|&peak| peak <= 1.0), "{peaks:?}");
    // Some joint is at its limit, or the motions would be slow.
    assert!(peaks[0] > 0.99 && peaks[1] > 0.95 && peaks[2] > 0.3, "{peaks:?}");
}

#[test]
fn derivatives_are_those_of_the_position() {
    let mut rng = ChaCha8Rng::seed_from_u64(22);
    let path = random_path(&mut rng, 3);
    let trajectory =
        Trajectory::along(&path, &limits(3), &TrajectoryOptions::default()).expect("a trajectory");
    let step_s = 1e-5;
    for k in 1..200 {
        let time_s = trajectory.duration_s() * f64::from(k) / 200.0;
        let [before, here, after] = [-step_s, 0.0, step_s].map(|d| trajectory.at(time_s + d));
        for joint in 0..3 {
            let velocity = (after.position[joint] - before.position[joint]) / (2.0 * step_s);
            let acceleration = (after.velocity[joint] - before.velocity[joint]) / (2.0 * step_s);
            assert!((velocity - here.velocity[joint]).abs() < 1e-6, "{velocity} {:?}", here.velocity);
            assert!(
                (acceleration - here.acceleration[joint]).abs() < 0.01,
                "{acceleration} {:?}",
                here.acceleration
            );
        }
    }
}

#[test]
fn samples_begin_and_end_at_rest_at_the_ends_of_the_path() {
    let mut rng = ChaCha8Rng::seed_from_u64(23);
    let path = random_path(&mut rng, 6);
    let trajectory =
        Trajectory::along(&path, &limits(6), &TrajectoryOptions::default()).expect("a trajectory");
    let samples = trajectory.sample(250.0);
    assert_eq!(samples.len(), (trajectory.duration_s() * 250.0).ceil() as usize + 1);
    for (sample, expected) in [(&samples[0], &path[0]), (&samples[samples.len() - 1], &path[path.len() - 1])]
    {
        assert!(sample.position.iter().zip(expected).all(|(p, e)| (p - e).abs() < 1e-9));
        assert!(sample.velocity.iter().all(|v| v.abs() < 1e-9));
    }
}

#[test]
fn the_motion_stays_near_its_path() {
    let path = vec![vec![0.0, 0.0], vec![1.0, 0.0], vec![1.0, 1.0]];
    let settings = TrajectoryOptions { spacing: 0.06, ..TrajectoryOptions::default() };
    let trajectory = Trajectory::along(&path, &limits(2), &settings).expect("a trajectory");
    let window_s = 2.0 * 0.5 * 8.5 / 400.0;
    let allowed = 0.06 / 3.0 + 8.5 * window_s * window_s / 24.0;
    for sample in trajectory.sample(1000.0) {
        let off = sample.position[1].abs().min((sample.position[0] - 1.0).abs());
        assert!(off < allowed, "{off} at {} s", sample.time_s);
    }
}

#[test]
fn a_corner_that_would_be_cut_through_something_is_made_tighter() {
    let whole = seven_joints();
    let arm = Arm::new(whole.joints().to_vec(), whole.bodies().to_vec(), Vec::new()).expect("an arm");
    let rest = [0.0, 0.3, 0.0, -1.5, 0.0, 1.8, 0.0];
    let with = |first: f64, second: f64| {
        let mut positions = rest.to_vec();
        (positions[0], positions[1]) = (first, second);
        positions
    };
    let path = [with(-1.0, 0.6), with(1.0, 0.6), with(1.0, 1.8)];
    let limits: Vec<JointLimits> = arm.joints().iter().map(|joint| joint.limits).collect();
    let wide = TrajectoryOptions { spacing: 2.4, ..TrajectoryOptions::default() };
    let cut = Trajectory::along(&path, &limits, &wide).expect("a trajectory");
    // An obstacle in the tool, at a moment of the wide motion, that the arm would not touch on the path itself.
    let obstacle_at = |k: i32| {
        let position = cut.at(cut.duration_s() * f64::from(k) / 100.0).position;
        let spot = arm.frames(&position)[7] * nalgebra::Point3::new(0.0, 0.0, 0.16);
        [Obstacle::sphere(spot, 0.005).expect("a sphere")]
    };
    let passes = |obstacles: &[Obstacle; 1]| arm.certify_path(&path, obstacles, 0.001, 1e-3).is_ok();
    let obstacles =
        (0..=100).map(obstacle_at).find(passes).expect("a place that only the wide motion touches");
    let checker = Checker::new(&arm, &obstacles, 0.0);
    let tight = time_free_path(&path, &limits, &wide, &checker, 64.0).expect("a tighter corner");
    assert!(tight.curve().span_count() > cut.curve().span_count());
    for sample in tight.sample(500.0) {
        assert!(arm.clearance(&sample.position, &obstacles).distance_m > -1e-4);
    }
}

#[test]
fn limits_and_shares_that_allow_no_motion_are_refused() {
    let path = [vec![0.0, 0.0], vec![1.0, 1.0]];
    let settings = TrajectoryOptions::default();
    let mut still = limits(2);
    still[1].max_jerk = 0.0;
    assert_eq!(Trajectory::along(&path, &still, &settings), Err(TrajectoryError::Limits { joint: 1 }));
    let few = Trajectory::along(&path, &limits(1), &settings);
    assert_eq!(few, Err(TrajectoryError::LimitCount { path: 2, limits: 1 }));
    let fast = TrajectoryOptions { velocity_share: 1.5, ..settings };
    assert!(matches!(Trajectory::along(&path, &limits(2), &fast), Err(TrajectoryError::Shares { .. })));
}
