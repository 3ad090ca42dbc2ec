//! Tests of forward kinematics against published poses, and of the Jacobian against differences.

use nalgebra::{Vector3, Vector6};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, FRAC_PI_8, PI};

use super::*;

fn tool_position(name: &str, positions: &[f64]) -> Vector3<f64> {
    tool_pose(&Robot::built_in(name, None).expect("built in"), positions).translation.vector
}

#[test]
fn panda_tool_is_where_published_poses_put_it() {
    // Poses that simulators start from, with positions computed independently.
    let cases = [
        ([0.0, -FRAC_PI_4, 0.0, -3.0 * FRAC_PI_4, 0.0, FRAC_PI_2, FRAC_PI_4], [0.30689, 0.0, 0.48688]),
        ([0.0, FRAC_PI_8, 0.0, -5.0 * FRAC_PI_8, 0.0, 3.0 * FRAC_PI_4, FRAC_PI_4], [0.61501, 0.0, 0.16978]),
        ([0.0, PI / 16.0, 0.0, -5.0 * PI / 6.0, 0.0, PI - 0.2, FRAC_PI_4], [0.45811, 0.0, 0.0922]),
        ([0.0, 0.0, 0.0, -FRAC_PI_2, 0.0, FRAC_PI_2, -FRAC_PI_4], [0.5545, 0.0, 0.5211]),
    ];
    for (positions, expected) in cases {
        let apart = tool_position("panda", &positions) - Vector3::from(expected);
        assert!(apart.norm() < 1e-4, "{positions:?}: {apart:?}");
    }
}

#[test]
fn tool_points_down_at_home() {
    for name in ["panda", "piper"] {
        let robot = Robot::built_in(name, None).expect("built in");
        let forward = tool_pose(&robot, &robot.home().positions).rotation * Vector3::z();
        assert!((forward + Vector3::z()).norm() < 1e-3, "{name}: {forward}");
    }
}

#[test]
fn piper_flange_is_where_the_vendor_puts_it_in_both_zero_conventions() {
    for (variant, expected) in [(None, [0.05613, 0.0, 0.21327]), (Some("old_zero"), [0.05495, 0.0, 0.20339])]
    {
        let robot = Robot::built_in("piper", variant).expect("built in");
        let flange = robot.link_index("link6").expect("the flange");
        let pose = link_poses(&robot, &[0.0; 6], 0.0)[flange];
        assert!((pose.translation.vector - Vector3::from(expected)).norm() < 1e-5, "{variant:?}: {pose}");
        let pitch = (pose.rotation * Vector3::z()).z.acos().to_degrees();
        assert!((pitch - 85.0).abs() < 1e-6, "{pitch}");
    }
}

#[test]
fn fingers_are_as_far_apart_as_the_opening() {
    let robot = Robot::built_in("panda", None).expect("built in");
    let poses = link_poses(&robot, &robot.home().positions, 0.03);
    let [left, right] = ["leftfinger", "rightfinger"].map(|n| poses[robot.link_index(n).expect("a finger")]);
    assert!(((left.translation.vector - right.translation.vector).norm() - 0.03).abs() < 1e-12);
}

#[test]
fn jacobian_equals_central_differences() {
    let gantry =
        Robot::parse(include_str!("../../tests/robots/gantry.toml"), "gantry.toml", None).expect("a robot");
    let built_in = ["panda", "piper"].map(|name| Robot::built_in(name, None).expect("built in"));
    let mut random = ChaCha8Rng::seed_from_u64(3);
    for robot in built_in.iter().chain([&gantry]) {
        for _ in 0..20 {
            let positions: Vec<f64> =
                robot.limits().iter().map(|l| random.random_range(l.min_position..l.max_position)).collect();
            let analytic = jacobian(robot, &positions);
            for joint in 0..robot.dof() {
                let moved = |step: f64| {
                    let mut positions = positions.clone();
                    positions[joint] += step;
                    tool_pose(robot, &positions)
                };
                let step = 1e-5;
                let (before, after) = (moved(-step), moved(step));
                let linear = (after.translation.vector - before.translation.vector) / (2.0 * step);
                let angular = (after.rotation * before.rotation.inverse()).scaled_axis() / (2.0 * step);
                let expected = Vector6::from_iterator(linear.iter().chain(angular.iter()).copied());
                let apart = (analytic.column(joint) - expected).norm();
                assert!(apart < 1e-8, "{} joint {joint}: {apart}", robot.name());
            }
        }
    }
}

#[test]
fn manipulability_vanishes_where_two_axes_of_the_wrist_align() {
    let robot = Robot::built_in("piper", None).expect("built in");
    let bent = [0.2, 1.5, -1.2, 0.3, 0.8, 0.1];
    let straight = [0.2, 1.5, -1.2, 0.3, 0.0, 0.1];
    assert!(manipulability(&jacobian(&robot, &bent)) > 1e-3);
    assert!(manipulability(&jacobian(&robot, &straight)) < 1e-9);
}
