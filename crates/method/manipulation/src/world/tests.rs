//! The arm holds and follows, the gripper opens and closes, and what it pinches stays.

use geometry::DQuat;
use robot::kinematics::tool_pose;

use super::*;
use crate::frames::{to_isometry, to_pose};
use crate::test_scenes::{block, body, box_body, table};

fn panda() -> Robot {
    Robot::built_in("panda", None).expect("built in")
}

#[test]
fn the_arm_holds_its_pose() {
    for name in ["panda", "piper"] {
        let robot = Robot::built_in(name, None).expect("built in");
        let start = robot.home().positions.clone();
        let opening_m = robot.home().opening_m;
        let base = Isometry3::translation(-0.3, 0.1, 0.0);
        let mut world =
            ManipulationWorld::new(&[table()], &robot, &base, &start, opening_m, &WorldOptions::default())
                .expect("a world");
        let expected = to_pose(&(base * tool_pose(&robot, &start)));
        assert!((world.tool_pose().translation_m - expected.translation_m).length() < 1e-9);
        world.simulate(1.0);
        for (is, was) in world.joint_positions().iter().zip(&start) {
            assert!((is - was).abs() < 1e-6, "{name}: {is} is not {was}");
        }
        assert!((world.opening_m() - opening_m).abs() < 1e-5, "{name}: {}", world.opening_m());
    }
}

#[test]
fn the_arm_follows_a_slow_motion() {
    for (name, bound_rad) in [("panda", 2e-3), ("piper", 2e-2)] {
        let robot = Robot::built_in(name, None).expect("built in");
        let start = robot.home().positions.clone();
        let base = Isometry3::identity();
        let mut world = ManipulationWorld::new(&[], &robot, &base, &start, 0.04, &WorldOptions::default())
            .expect("a world");
        let mut worst = 0.0_f64;
        for step in 0..1500 {
            let (time_s, rate) = (f64::from(step + 1) / 500.0, 1.5);
            let offset = 0.2 * (1.0 - (rate * time_s).cos());
            let targets: Vec<f64> = start.iter().map(|q| q - offset).collect();
            world.set_joint_targets(&targets, &vec![-0.2 * rate * (rate * time_s).sin(); start.len()]);
            world.step();
            for (is, target) in world.joint_positions().iter().zip(&targets) {
                worst = worst.max((is - target).abs());
            }
        }
        assert!(worst < bound_rad && worst > 0.0, "{name}: {worst}");
    }
}

#[test]
fn the_gripper_reaches_its_openings() {
    let robot = panda();
    let base = Isometry3::identity();
    let mut world =
        ManipulationWorld::new(&[], &robot, &base, &robot.home().positions, 0.08, &WorldOptions::default())
            .expect("a world");
    for opening_m in [0.02, 0.0, 0.075, 0.03] {
        world.set_gripper(opening_m, 0.1, 40.0);
        world.simulate(1.0);
        assert!((world.opening_m() - opening_m).abs() < 2e-4, "{} is not {opening_m}", world.opening_m());
    }
}

/// A hand above the center of a box of 40 mm and 100 g that stands on the table, its pads around it.
fn pinched(object: Body, height_m: f64) -> ManipulationWorld {
    let robot = panda();
    let down = Pose {
        translation_m: DVec3::new(0.0, 0.0, height_m),
        rotation: DQuat::from_rotation_x(std::f64::consts::PI),
    };
    let mut world = ManipulationWorld::with_hand(
        &[table(), object],
        &robot,
        &to_isometry(&down),
        0.07,
        &WorldOptions::default(),
    )
    .expect("a world");
    world.set_gripper(0.0, 0.05, robot.gripper().grip_force_n);
    world.simulate(0.8);
    world
}

#[test]
fn a_pinched_box_stays() {
    for mass_kg in [0.1, 0.5] {
        let object = box_body("box", block(DVec3::splat(0.04)), mass_kg, Pose::IDENTITY);
        let mut world = pinched(object, 0.02);
        let forces = world.finger_forces(1);
        for force in &forces.normal_n {
            assert!((force - 40.0).abs() < 3.0, "{forces:?}");
        }
        for step in 0..500 {
            let speed = 0.1;
            world.set_joint_targets(&[0.0, 0.0, speed * f64::from(step + 1) / 500.0], &[0.0, 0.0, speed]);
            world.step();
        }
        world.set_joint_targets(&[0.0, 0.0, 0.1], &[0.0; 3]);
        world.simulate(0.2);
        let held = world.tool_pose().inverse() * world.object_pose(1);
        // Shaken by 5 cm along each axis of the world, among them the one on which the fingers close.
        let place = |time_s: f64| {
            let ramp = (2.0 * time_s).min(4.0 - 2.0 * time_s).clamp(0.0, 1.0);
            0.05 * ramp * ramp * (3.0 - 2.0 * ramp) * (std::f64::consts::TAU * time_s).sin()
        };
        for step in 0..1000 {
            let time_s = f64::from(step + 1) / 500.0;
            let (at, rate) = (place(time_s), (place(time_s + 1e-4) - place(time_s - 1e-4)) / 2e-4);
            world.set_joint_targets(&[at, at, 0.1 + at], &[rate; 3]);
            world.step();
        }
        let now = world.tool_pose().inverse() * world.object_pose(1);
        let slip_m = (now.translation_m - held.translation_m).length();
        assert!(world.object_pose(1).translation_m.z > 0.09, "{:?}", world.object_pose(1));
        assert!(slip_m < 2e-4, "{mass_kg} kg slips by {slip_m} m");
    }
}

/// Regression: pads did not resist turning about the line between them, and what was gripped by small spots swung.
#[test]
fn what_is_gripped_beside_its_center_of_mass_does_not_swing() {
    let arm = block(DVec3::new(0.16, 0.01, 0.02)).translated(DVec3::new(0.06, 0.0, 0.0));
    let axle = block(DVec3::new(0.002, 0.04, 0.002)).translated(DVec3::new(0.0, 0.0, 0.009));
    let mut world = pinched(body("arm", vec![arm, axle], 0.4, Pose::IDENTITY), 0.01);
    let held = world.tool_pose().inverse() * world.object_pose(1);
    let speed = 0.1;
    for step in 0..500 {
        world.set_joint_targets(&[0.0, 0.0, speed * f64::from(step + 1) / 500.0], &[0.0, 0.0, speed]);
        world.step();
    }
    let now = world.tool_pose().inverse() * world.object_pose(1);
    let turn_rad = now.rotation.angle_between(held.rotation);
    assert!(turn_rad < 0.06, "turns by {turn_rad} rad");
}

/// Regression: the engine kept the directions of contacts whose bodies turned together, and a box turned in the hand.
#[test]
fn what_a_turning_arm_holds_stays_in_the_hand() {
    let robot = panda();
    let base = Isometry3::identity();
    let start = robot.home().positions.clone();
    let tool = to_pose(&tool_pose(&robot, &start));
    let at =
        Pose { translation_m: tool.translation_m - DVec3::new(0.0, 0.0, 0.02), rotation: DQuat::IDENTITY };
    let object = box_body("box", block(DVec3::splat(0.04)), 0.1, at);
    let shelf = block(DVec3::new(0.1, 0.1, 0.02)).translated(at.translation_m - DVec3::new(0.0, 0.0, 0.02));
    let shelf = Body { fixed: true, ..box_body("shelf", shelf, 1.0, Pose::IDENTITY) };
    let mut world =
        ManipulationWorld::new(&[shelf, object], &robot, &base, &start, 0.06, &WorldOptions::default())
            .expect("a world");
    world.set_gripper(0.0, 0.05, 40.0);
    world.simulate(0.5);
    let held = world.tool_pose().inverse() * world.object_pose(1);
    for step in 0..750 {
        let time_s = f64::from(step + 1) / 500.0;
        let (at, rate) = (0.6 * (1.0 - (2.0 * time_s).cos()), 1.2 * (2.0 * time_s).sin());
        let (mut targets, mut rates) = (start.clone(), vec![0.0; 7]);
        (targets[0], rates[0]) = (start[0] + at, rate);
        (targets[3], rates[3]) = (start[3] + 0.3 * at, 0.3 * rate);
        (targets[6], rates[6]) = (start[6] - at, -rate);
        world.set_joint_targets(&targets, &rates);
        world.step();
    }
    let now = world.tool_pose().inverse() * world.object_pose(1);
    let slip_m = now.translation_m.distance(held.translation_m);
    let turn_rad = now.rotation.angle_between(held.rotation);
    assert!(slip_m < 2e-4 && turn_rad < 5e-3, "{slip_m} m, {turn_rad} rad");
}

#[test]
fn equal_worlds_give_equal_bytes() {
    let run = || {
        let object =
            box_body("box", block(DVec3::new(0.04, 0.05, 0.06)), 0.2, Pose::upright(DVec3::ZERO, 0.2));
        let world = pinched(object, 0.03);
        let pose = world.object_pose(1);
        (pose.translation_m.to_array().map(f64::to_bits), pose.rotation.to_array().map(f64::to_bits))
    };
    assert_eq!(run(), run());
}

#[test]
fn broken_objects_are_named() {
    let mut object = box_body("box", block(DVec3::splat(0.04)), 0.1, Pose::IDENTITY);
    object.mass.mass_kg = 0.0;
    let robot = panda();
    let base = Isometry3::identity();
    let world = ManipulationWorld::new(
        &[object],
        &robot,
        &base,
        &robot.home().positions,
        0.0,
        &WorldOptions::default(),
    );
    assert_eq!(world.err(), Some(WorldError::Unfit(UnfitBody::BadMass { name: "box".to_owned() })));
    let world = ManipulationWorld::new(&[], &robot, &base, &[0.0], 0.0, &WorldOptions::default());
    assert_eq!(world.err(), Some(WorldError::WrongLength { found: 1, expected: 7 }));
}
