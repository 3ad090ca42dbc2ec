//! Tests of inverse kinematics by forward kinematics of random configurations.

use nalgebra::{Translation3, UnitQuaternion, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::*;
use crate::kinematics::tool_pose;

fn robots() -> [Robot; 4] {
    [("panda", None), ("panda", Some("motion_bench_maker")), ("piper", None), ("piper", Some("old_zero"))]
        .map(|(name, variant)| Robot::built_in(name, variant).expect("built in"))
}

fn random_positions(robot: &Robot, random: &mut ChaCha8Rng) -> Vec<f64> {
    robot
        .limits()
        .iter()
        .map(|limits| random.random_range(limits.min_position..limits.max_position))
        .collect()
}

/// Difference of two poses: the larger of the distance in meters and the angle in radians.
fn apart(a: &Isometry3<f64>, b: &Isometry3<f64>) -> f64 {
    (a.translation.vector - b.translation.vector).norm().max(a.rotation.angle_to(&b.rotation))
}

#[test]
fn every_reachable_pose_is_reached_by_every_solution() {
    for robot in robots() {
        let arm = InverseKinematics::new(&robot).expect("a closed form");
        let mut random = ChaCha8Rng::seed_from_u64(11);
        for _ in 0..if robot.variant().is_none() { 10_000 } else { 1_000 } {
            let target = tool_pose(&robot, &random_positions(&robot, &mut random));
            let solutions = arm.solve(&target);
            assert!(
                !solutions.is_empty(),
                "{} {:?}: nothing reaches {target}",
                robot.name(),
                robot.variant()
            );
            for solution in solutions {
                assert!(robot.admits(&solution), "{} {solution:?} is beyond the limits", robot.name());
                let error = apart(&tool_pose(&robot, &solution), &target);
                assert!(error < 1e-6, "{} {solution:?} misses by {error}", robot.name());
            }
        }
    }
}

#[test]
fn six_joints_return_the_configuration_that_made_the_pose() {
    for robot in &robots()[2..] {
        let arm = OrthoParallel::recognize(robot).expect("an ortho-parallel arm");
        let mut random = ChaCha8Rng::seed_from_u64(12);
        for _ in 0..10_000 {
            let positions = random_positions(robot, &mut random);
            let solutions = arm.solve(&tool_pose(robot, &positions));
            let far = |q: &[f64; 6]| q.iter().zip(&positions).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            let nearest = solutions.iter().map(far).fold(f64::INFINITY, f64::min);
            assert!(nearest < 1e-6, "{positions:?} is missed by {nearest}: {solutions:?}");
        }
    }
}

#[test]
fn seven_joints_return_the_configuration_that_made_the_pose_at_its_last_position() {
    let robot = &robots()[0];
    let arm = OffsetElbow::recognize(robot).expect("a Franka arm");
    let mut random = ChaCha8Rng::seed_from_u64(13);
    for _ in 0..10_000 {
        let positions = random_positions(robot, &mut random);
        let solutions = arm.solve_at(&tool_pose(robot, &positions), positions[6]);
        let far = |q: &[f64; 7]| q.iter().zip(&positions).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        let nearest = solutions.iter().map(far).fold(f64::INFINITY, f64::min);
        assert!(nearest < 1e-6, "{positions:?} is missed by {nearest}: {solutions:?}");
    }
}

#[test]
fn pose_out_of_reach_has_no_solution() {
    for robot in robots() {
        let arm = InverseKinematics::new(&robot).expect("a closed form");
        let far = Isometry3::from_parts(Translation3::new(2.0, 0.0, 0.5), UnitQuaternion::identity());
        assert_eq!(arm.solve(&far), Vec::<Vec<f64>>::new());
        assert_eq!(arm.nearest(&far, &robot.home().positions), None);
    }
}

#[test]
fn nearest_solution_of_home_is_home() {
    let robot = Robot::built_in("piper", None).expect("built in");
    let arm = InverseKinematics::new(&robot).expect("a closed form");
    let home = &robot.home().positions;
    let nearest = arm.nearest(&tool_pose(&robot, home), home).expect("home is reachable");
    assert!(nearest.iter().zip(home).all(|(a, b)| (a - b).abs() < 1e-9), "{nearest:?}");
}

#[test]
fn arm_of_another_geometry_has_no_closed_form() {
    let gantry = include_str!("../../tests/robots/gantry.toml");
    let robot = Robot::parse(gantry, "gantry.toml", None).expect("a robot");
    assert!(InverseKinematics::new(&robot).is_none());
}

#[test]
fn damped_least_squares_reaches_poses_near_its_start() {
    for robot in robots() {
        let mut random = ChaCha8Rng::seed_from_u64(14);
        let mut reached = 0;
        for _ in 0..200 {
            let goal = random_positions(&robot, &mut random);
            let start: Vec<f64> = goal
                .iter()
                .zip(robot.limits())
                .map(|(q, l)| (q + random.random_range(-0.1..0.1)).clamp(l.min_position, l.max_position))
                .collect();
            let target = tool_pose(&robot, &goal);
            if let Ok(solution) = DampedLeastSquares::PRECISE.solve(&robot, &target, &start, &start) {
                assert!(robot.admits(&solution));
                assert!(apart(&tool_pose(&robot, &solution), &target) < 1e-8);
                reached += 1;
            }
        }
        assert!(reached >= 190, "{}: {reached} of 200", robot.name());
    }
}

#[test]
fn unreachable_target_is_an_error_with_the_remaining_distance() {
    let robot = Robot::built_in("panda", None).expect("built in");
    let far = Isometry3::from_parts(Translation3::new(2.0, 0.0, 0.5), UnitQuaternion::identity());
    let home = &robot.home().positions;
    let error = DampedLeastSquares::PRECISE.solve(&robot, &far, home, home).expect_err("two meters away");
    assert!(error.position_m > 0.5, "{error}");
}

#[test]
fn straight_motion_keeps_the_tool_on_a_vertical_line() {
    for (name, height_m) in [("panda", 0.1), ("piper", -0.05)] {
        let robot = Robot::built_in(name, None).expect("built in");
        let home = &robot.home().positions;
        let from = tool_pose(&robot, home);
        let to = Translation3::new(0.0, 0.0, height_m) * from;
        let path = follow_line(&robot, home, &to, &LineAccuracy::FINE).expect("a free line");
        let tools: Vec<_> = path.iter().map(|positions| tool_pose(&robot, positions)).collect();
        for tool in &tools {
            let beside = (tool.translation.vector - from.translation.vector).cross(&Vector3::z()).norm();
            assert!(beside < 1e-5 && tool.rotation.angle_to(&from.rotation) < 1e-5, "{name}: {beside}");
        }
        for pair in tools.windows(2) {
            assert!(apart(&pair[0], &pair[1]) < 0.005 + 1e-5, "{name}: a step is too long");
        }
        assert!(apart(&tools[tools.len() - 1], &to) < 1e-5);
    }
}

#[test]
fn line_that_a_joint_limit_ends_is_an_error_with_the_share_that_is_free() {
    // With the gripper pointing down, joint 5 of the PiPER meets its limit 2 cm above home.
    let robot = Robot::built_in("piper", None).expect("built in");
    let home = &robot.home().positions;
    let to = Translation3::new(0.0, 0.0, 0.1) * tool_pose(&robot, home);
    let error = follow_line(&robot, home, &to, &LineAccuracy::FINE).expect_err("a limit");
    let LineError::NotReached { percent, .. } = error else { panic!("{error}") };
    assert!((15.0..30.0).contains(&percent), "{percent}");
}
