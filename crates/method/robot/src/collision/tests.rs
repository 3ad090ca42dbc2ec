//! The fast check against exact distances, in random worlds.

use std::f64::consts::{FRAC_PI_2, PI};

use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::lane_arm::{Configuration, ROUNDING_MARGIN_M};
use super::lanes::Backend;
use super::*;
use crate::model::limits::JointLimits;

const LIMITS: JointLimits = JointLimits {
    min_position: -2.9,
    max_position: 2.9,
    max_velocity: 2.0,
    max_acceleration: 10.0,
    max_jerk: 5000.0,
    max_effort: 80.0,
};

/// An arm with seven joints, proportioned like a large cobot; each link is a row of spheres.
pub fn seven_joints() -> Arm {
    let placed = |offset: [f64; 3], about_x: f64| {
        Isometry3::from_parts(
            Translation3::from(offset),
            UnitQuaternion::from_axis_angle(&Vector3::x_axis(), about_x),
        )
    };
    let joint = |offset: [f64; 3], about_x: f64| ArmJoint {
        parent_from_joint: placed(offset, about_x),
        motion: JointMotion::Turn,
        limits: LIMITS,
    };
    let joints = vec![
        joint([0.0, 0.0, 0.333], 0.0),
        joint([0.0, 0.0, 0.0], -FRAC_PI_2),
        joint([0.0, -0.316, 0.0], FRAC_PI_2),
        joint([0.0825, 0.0, 0.0], FRAC_PI_2),
        joint([-0.0825, 0.384, 0.0], -FRAC_PI_2),
        joint([0.0, 0.0, 0.0], FRAC_PI_2),
        joint([0.088, 0.0, 0.0], FRAC_PI_2),
    ];
    let row = |frame: usize, from: [f64; 3], to: [f64; 3], radius_m: f64| ArmBody {
        frame,
        spheres: (0..4)
            .map(|k| {
                let share = f64::from(k) / 3.0;
                let center_m = Point3::from(from) + share * (Point3::from(to) - Point3::from(from));
                Sphere { center_m, radius_m }
            })
            .collect(),
    };
    let bodies = vec![
        row(0, [0.0, 0.0, 0.04], [0.0, 0.0, 0.1], 0.07),
        row(2, [0.0, 0.0, 0.0], [0.0, -0.2, 0.0], 0.06),
        row(3, [0.0, 0.0, -0.1], [0.08, 0.0, 0.0], 0.06),
        row(5, [0.0, 0.0, -0.22], [0.0, 0.06, 0.0], 0.05),
        row(7, [0.0, 0.0, 0.05], [0.0, 0.0, 0.12], 0.04),
        row(7, [0.0, -0.08, 0.16], [0.0, 0.08, 0.16], 0.03),
    ];
    Arm::new(joints, bodies, vec![(0, 3), (0, 4), (0, 5), (1, 4), (1, 5), (3, 5)]).expect("an arm")
}

fn random_pose(rng: &mut ChaCha8Rng) -> Isometry3<f64> {
    let mut part = || rng.random_range(-1.0..1.0);
    let axis = Vector3::new(part(), part(), part());
    let place = Translation3::new(0.8 * part(), 0.8 * part(), 0.5 + 0.5 * part());
    Isometry3::from_parts(place, UnitQuaternion::from_scaled_axis(axis * PI))
}

/// A tetrahedron with corners around the origin.
fn random_hull(rng: &mut ChaCha8Rng) -> ConvexPolyhedron {
    let mut near = |[x, y, z]: [f64; 3]| {
        let mut part = |value: f64| value * rng.random_range(0.03..0.25);
        Point3::new(part(x), part(y), part(z))
    };
    let points =
        [[1.0, 1.0, 1.0], [-1.0, -1.0, 1.0], [-1.0, 1.0, -1.0], [1.0, -1.0, -1.0]].map(&mut near).to_vec();
    ConvexPolyhedron::new(points, vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]).expect("a tetrahedron")
}

pub fn random_world(rng: &mut ChaCha8Rng, count: usize) -> Vec<Obstacle> {
    (0..count)
        .map(|index| {
            let pose = random_pose(rng);
            let mut length_m = || rng.random_range(0.01..0.2);
            match index % 5 {
                0 => Obstacle::sphere(Point3::from(pose.translation.vector), length_m()),
                1 => Obstacle::cuboid(pose, Vector3::new(length_m(), length_m(), length_m())),
                2 => Obstacle::cylinder(pose, length_m(), length_m()),
                3 => Obstacle::capsule(pose, length_m(), length_m()),
                _ => Obstacle::hull(pose, random_hull(rng)),
            }
            .expect("an obstacle")
        })
        .collect()
}

pub fn random_positions(rng: &mut ChaCha8Rng, arm: &Arm) -> Vec<f64> {
    let limits = arm.joints().iter().map(|joint| joint.limits);
    // Rounded to `f32`, so that both checks see the same configuration.
    limits.map(|l| f64::from(rng.random_range(l.min_position..l.max_position) as f32)).collect()
}

fn lanes_of(positions: &[f64]) -> Configuration {
    std::array::from_fn(|joint| positions.get(joint).map_or(0.0, |&position| position as f32))
}

#[test]
fn the_fast_check_agrees_with_exact_distances() {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let arm = seven_joints();
    let (mut free_count, mut hit_count) = (0, 0);
    for _ in 0..400 {
        let obstacles = random_world(&mut rng, 5);
        let fast = Checker::new(&arm, &obstacles, 0.0);
        let baseline = Checker::with_backend(&arm, &obstacles, 0.0, Backend::Baseline);
        for _ in 0..50 {
            let positions = random_positions(&mut rng, &arm);
            let clearance = arm.clearance(&positions, &obstacles);
            let free = fast.is_free(&lanes_of(&positions));
            assert_eq!(free, baseline.is_free(&lanes_of(&positions)));
            if free {
                free_count += 1;
                assert!(clearance.distance_m > 0.0, "{positions:?} is not free: {clearance:?}");
            } else {
                hit_count += 1;
                // Two spheres that each have the margin, and the rounding errors themselves.
                assert!(
                    clearance.distance_m < 2.5 * ROUNDING_MARGIN_M,
                    "{positions:?} is free: {clearance:?}"
                );
            }
        }
    }
    assert!(free_count > 2000 && hit_count > 2000, "{free_count} free, {hit_count} not");
}

/// Far obstacles are left out by their boxes; each obstacle measured alone is the slow reference.
#[test]
fn the_nearest_of_many_obstacles_is_found() {
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    let arm = seven_joints();
    let mut found = std::collections::HashSet::new();
    for _ in 0..60 {
        let obstacles = random_world(&mut rng, 30);
        for _ in 0..20 {
            let positions = random_positions(&mut rng, &arm);
            let alone = |solid| arm.clearance(&positions, std::slice::from_ref(solid)).distance_m;
            let expected_m = obstacles.iter().map(alone).fold(f64::INFINITY, f64::min);
            let clearance = arm.clearance(&positions, &obstacles);
            assert_eq!(clearance.distance_m, expected_m, "{positions:?}: {clearance:?}");
            if let Contact::Obstacle { obstacle, .. } = clearance.between {
                assert_eq!(alone(&obstacles[obstacle]), expected_m);
                found.insert(obstacle);
            }
        }
    }
    assert_eq!(found.len(), 30, "each place in the list is the nearest once");
}

/// Worlds in which one obstacle touches the arm within micrometers show what the margin is worth.
#[test]
fn what_almost_touches_is_judged_within_the_margin() {
    let mut rng = ChaCha8Rng::seed_from_u64(2);
    let arm = seven_joints();
    let mut judged = 0;
    while judged < 3000 {
        let positions = random_positions(&mut rng, &arm);
        let world = random_world(&mut rng, 5);
        let obstacle = &world[judged % 5];
        let clearance = arm.clearance(&positions, std::slice::from_ref(obstacle));
        if !(0.0..0.5).contains(&clearance.distance_m) || matches!(clearance.between, Contact::Bodies(..)) {
            continue;
        }
        judged += 1;
        // Padding as wide as the clearance closes the gap; a little less leaves it open.
        let (closed_m, open_m) = (clearance.distance_m, clearance.distance_m - 2.5 * ROUNDING_MARGIN_M);
        let free_with = |padding_m: f64| {
            let obstacle_only =
                Arm::new(arm.joints().to_vec(), arm.bodies().to_vec(), vec![]).expect("an arm");
            Checker::new(&obstacle_only, std::slice::from_ref(obstacle), padding_m)
                .is_free(&lanes_of(&positions))
        };
        assert!(!free_with(closed_m), "{positions:?}: {obstacle:?} at {closed_m} m");
        assert!(open_m <= 0.0 || free_with(open_m), "{positions:?}: {obstacle:?} at {closed_m} m");
    }
}

#[test]
fn an_edge_is_free_only_if_its_points_are() {
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let arm = seven_joints();
    let (mut free, mut blocked) = (0, 0);
    for _ in 0..2000 {
        let obstacles = random_world(&mut rng, 3);
        let checker = Checker::new(&arm, &obstacles, 0.0);
        let from = random_positions(&mut rng, &arm);
        let to: Vec<f64> = from.iter().map(|p| p + rng.random_range(-0.3..0.3)).collect();
        let points = (1..=64).map(|k| {
            let share = f64::from(k) / 64.0;
            from.iter().zip(&to).map(|(a, b)| a + share * (b - a)).collect::<Vec<_>>()
        });
        let min_m = points.map(|p| arm.clearance(&p, &obstacles).distance_m).fold(f64::INFINITY, f64::min);
        // 64 points on each edge, the same that the exact check measures.
        let length = from.iter().zip(&to).map(|(a, b)| (b - a).powi(2)).sum::<f64>().sqrt();
        let is_free = checker.edge_is_free(&lanes_of(&from), &lanes_of(&to), (63.9 / length) as f32);
        if is_free {
            free += 1;
            assert!(min_m > 0.0, "{min_m}");
        } else {
            blocked += 1;
            assert!(min_m < 2.5 * ROUNDING_MARGIN_M, "{min_m}");
        }
    }
    assert!(free > 200 && blocked > 200, "{free} free, {blocked} blocked");
}

#[test]
fn what_the_gripper_holds_collides_too() {
    let arm = seven_joints();
    let positions = [0.0, 0.3, 0.0, -1.5, 0.0, 1.8, 0.0];
    let tip = arm.frames(&positions)[7] * Point3::new(0.0, 0.0, 0.3);
    let obstacles = [Obstacle::sphere(tip, 0.02).expect("a sphere")];
    assert!(Checker::new(&arm, &obstacles, 0.0).is_free(&lanes_of(&positions)));
    let bar =
        ArmBody { frame: 7, spheres: vec![Sphere { center_m: Point3::new(0.0, 0.0, 0.27), radius_m: 0.02 }] };
    let holding = arm.holding(bar, &[5]).expect("an arm");
    assert!(!Checker::new(&holding, &obstacles, 0.0).is_free(&lanes_of(&positions)));
    let clearance = holding.clearance(&positions, &obstacles);
    assert!((clearance.distance_m + 0.01).abs() < 1e-9, "{clearance:?}");
}

#[test]
fn a_certified_path_is_free_between_its_points() {
    let arm = seven_joints();
    let mut from = vec![0.0, 0.6, 0.0, -1.5, 0.0, 1.8, 0.0];
    let mut to = from.clone();
    (from[0], to[0]) = (-1.0, 1.0);
    let path = [from, to];
    // A pole halfway along the sweep, thinner than the step between the ends.
    let pole = |x_m: f64| {
        let pose = Isometry3::translation(x_m, 0.0, 0.5);
        [Obstacle::cylinder(pose, 0.005, 0.5).expect("a pole")]
    };
    assert_eq!(arm.certify_path(&path, &pole(1.2), 0.0, 1e-4), Ok(()));
    let contact =
        arm.certify_path(&path, &pole(0.5), 0.0, 1e-4).expect_err("the arm passes through the pole");
    assert!(contact.segment == 0 && contact.clearance.distance_m < 0.0, "{contact:?}");
}

proptest::proptest! {
    #[test]
    fn frames_move_no_farther_than_the_bound(seed in 0_u64..10_000) {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let arm = seven_joints();
        let (from, to) = (random_positions(&mut rng, &arm), random_positions(&mut rng, &arm));
        for (index, body) in arm.bodies().iter().enumerate() {
            let bound_m = arm.motion_bound_m(index, &from, &to);
            for sphere in &body.spheres {
                let place = |positions: &[f64]| arm.frames(positions)[body.frame] * sphere.center_m;
                let moved_m = place(&to) - place(&from);
                proptest::prop_assert!(moved_m.norm() <= bound_m + 1e-12);
            }
        }
    }
}
