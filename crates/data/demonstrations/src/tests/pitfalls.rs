//! Pitfalls that users of other datasets report, as far as they are decided where episodes are made; those of the files
//! are tests of the crate `episodes`.

use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion};
use robot::kinematics::tool_pose;

use super::*;

/// The initial state is missing, so that no other simulator can begin the replay.
#[test]
fn initial_state_is_complete() {
    let (setup, unit) = episode(Randomization::USUAL);
    let record: EpisodeRecord = serde_json::from_value(unit.header().record.clone()).expect("a record");
    let present: Vec<&str> = record
        .sample
        .objects
        .iter()
        .filter(|object| object.present)
        .map(|object| object.name.as_str())
        .collect();
    let posed: Vec<&str> = record.initial_poses.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(present, posed, "every object that is there has a pose, and no other");
    let drawn = |factor: f64| (0.8..=1.2).contains(&factor) && factor != 1.0;
    assert!(
        record.sample.objects.iter().all(|object| drawn(object.mass_factor) && drawn(object.friction_factor))
    );
    let (home, start) = (setup.robot.home().positions.clone(), &record.sample.joint_positions_rad);
    assert!(home.iter().zip(start).all(|(home, start)| (home - start).abs() <= 0.05));
    // The first state is that start, but for the idle frames that were left out.
    let measured = &unit.state()[..start.len()];
    let off =
        start.iter().zip(measured).map(|(start, now)| (start - f64::from(*now)).abs()).fold(0.0, f64::max);
    assert!(off < 0.02, "the first state is {off} rad from the start");
}

/// Another controller cannot repeat the episode: both forms of an action are the same command.
#[test]
fn joint_targets_and_tool_poses_are_the_same_command() {
    let (setup, unit) = episode(Randomization::NONE);
    let width = setup.description().action().dimension();
    for action in unit.action().chunks_exact(width) {
        let exact = |range: std::ops::Range<usize>| -> Vec<f64> {
            action[range].iter().copied().map(f64::from).collect()
        };
        let (joints, tool) = (exact(0..7), exact(7..14));
        let stated = Isometry3::from_parts(
            Translation3::new(tool[0], tool[1], tool[2]),
            UnitQuaternion::from_quaternion(Quaternion::new(tool[3], tool[4], tool[5], tool[6])),
        );
        let reached = tool_pose(&setup.robot, &joints);
        assert!((reached.translation.vector - stated.translation.vector).norm() < 1e-5);
        assert!(reached.rotation.angle_to(&stated.rotation) < 1e-5);
    }
}

/// Without this refusal, a goal out of reach would cost endless attempts.
#[test]
fn goals_out_of_reach_are_refused_before_any_attempt() {
    let mut parts = parts();
    // The robot stands at the edge of the table, which is far from the plate now.
    let far = [(-0.6, -0.4), (6.0, -0.4), (6.0, 0.4), (-0.6, 0.4)].map(DVec2::from);
    parts.scene.outline = Outline::new(far.to_vec()).expect("a rectangle");
    for object in &mut parts.scene.objects[1..3] {
        object.world_from_object.translation_m.x += 4.0;
    }
    let robot = Robot::built_in("piper", None).expect("built in");
    let (settings, grasps) = (test_settings::section("execution"), test_settings::section("grasps"));
    let task = Task { robot: "piper".to_owned(), ..task() };
    let mut known = KnownGrasps::new(&parts.scene, &robot, &grasps, 5);
    let refused = prepare(&robot, task, &mut known, &settings).err();
    assert!(matches!(refused, Some(SetupError::NotFeasible { .. })), "{:?}", refused.map(|e| e.to_string()));
}

/// A bad seed hangs: an attempt that cannot succeed ends, with a reason.
#[test]
fn attempts_without_a_grasp_end_with_their_reason() {
    let setup = setup_with(wanted(Vec::new(), Randomization::USUAL)).expect("a setup");
    for number in 0..3 {
        match attempt(&setup, number, false).expect("no fault") {
            Attempted::Failed { reason, unit, .. } => {
                assert_eq!(reason, "no_grasp");
                assert!(unit.is_none());
            }
            Attempted::Succeeded(_) => panic!("there is no grasp"),
        }
    }
}

/// Initial states depend on the order in which episodes are made: they are numbered instead.
#[test]
fn initial_states_follow_from_numbers_alone() {
    let setup = setup_with(wanted(Vec::new(), Randomization::USUAL)).expect("a setup");
    let draw = |number: u64| {
        let seed = runtime::seed::child_seed(setup.seed, &format!("episode {number}"));
        Sample::draw(&setup, setup.work_of(number), &setup.randomization, seed).expect("room for all")
    };
    let forward: Vec<Sample> = (0..6).map(draw).collect();
    let backward: Vec<Sample> = (0..6).rev().map(draw).collect();
    assert!(forward.iter().eq(backward.iter().rev()));
    for (a, b) in forward.iter().zip(&forward[1..]) {
        assert!(a.joint_positions_rad != b.joint_positions_rad && a.objects != b.objects);
    }
}
