//! A robot in a scene of two cubes.

use std::f64::consts::FRAC_PI_2;

use glam::DQuat;
use serde::de::DeserializeOwned;

use super::*;
use crate::pipeline::certify::tests::{Planted, sound};
use manipulation::grasp::grasps;
use scene::{RequestedPose, TippedPose};

/// A section of the built-in settings.
fn section<T: DeserializeOwned>(name: &str) -> T {
    let defaults: toml::Table = include_str!("../../../config/default.toml").parse().expect("our own file");
    defaults[name].clone().try_into().expect("our own section")
}

fn few() -> GraspSettings {
    GraspSettings { max_trials: 10, wanted_stable: 6, surface_points: 300, ..section("grasps") }
}

/// The grasps of a cube alone.
fn cube_grasps(planted: &Planted) -> Vec<Grasp> {
    let hulls = planted.loaded.iter().map(|body| &body.hulls);
    let scene = simulated(planted.inputs.composition(), hulls).expect("a table");
    let robot = robot_named("panda").expect("built in");
    let mut found = grasps(&scene.objects[0], &robot, &few(), &mut child_rng(1, "test")).expect("a cube");
    found.retain(|grasp| grasp.verdict == manipulation::grasp::Verdict::Stable);
    found
}

fn inputs(planted: &Planted, robot: &str, grasps: Vec<Option<Vec<Grasp>>>) -> Inputs {
    Inputs {
        robot: robot.to_owned(),
        seed: 7,
        composition: planted.inputs.composition().clone(),
        grasps,
        grasp_settings: few(),
        execution: section("execution"),
    }
}

#[test]
fn cubes_that_can_be_taken_are_counted_and_moved() {
    let planted = sound();
    let cube = cube_grasps(&planted);
    assert!(!cube.is_empty());
    let run = |grasps| {
        let inputs = inputs(&planted, "panda", grasps);
        rehearsed(&inputs, planted.loaded.clone(), &CancelFlag::default()).expect("a scene")
    };
    let Output { finding, objects } = run(vec![Some(cube.clone()), Some(cube.clone())]);
    assert_eq!((finding.name.as_str(), finding.objects, finding.pickable), ("panda", 2, 2), "{finding:?}");
    assert_eq!((finding.tasks_proposed, finding.tasks.len()), (3, 3), "{finding:?}");
    assert!(finding.tasks_done > 0, "{finding:?}");
    let done = finding.tasks.iter().filter(|task| task.outcome == "done").count();
    assert_eq!(finding.tasks_done, done);
    let first = objects[0].as_ref().expect("is for grippers");
    assert!(first.yaml.starts_with("format: isaac_grasp\n") && first.yaml.contains("object_frame: cube_1\n"));
    assert_eq!(first.file.grasps.len(), cube.len());
    let [a, b] = first.best().expect("a grasp").contacts_m;
    assert!((a.distance(b) - first.file.grasps[0].opening_m).abs() < 1e-12);

    // One is for no gripper, and the other has no grasp: no task moves them.
    let Output { finding, objects } = run(vec![None, Some(Vec::new())]);
    assert_eq!((finding.objects, finding.pickable, finding.tasks_proposed), (1, 0, 0), "{finding:?}");
    assert!(objects[0].is_none() && objects[1].as_ref().is_some_and(|of| of.best().is_none()));
}

#[test]
fn an_unknown_robot_is_an_error() {
    let planted = sound();
    let inputs = inputs(&planted, "hal", vec![None, None]);
    let error = rehearsed(&inputs, planted.loaded, &CancelFlag::default()).err().expect("an error");
    assert_eq!(error.code, "unknown_robot");
}

#[test]
fn grasps_of_a_tipped_object_stay_where_they_are_in_the_world() {
    let mut planted = sound();
    let mut composition = planted.inputs.composition().clone();
    let mut recognition = (*composition.recognition).clone();
    recognition.objects[1].tipped = Some(TippedPose {
        pose: RequestedPose::LyingOnSide,
        upright_size_m: DVec3::splat(0.06),
        tipped_from_upright: DQuat::from_rotation_y(FRAC_PI_2),
    });
    composition.recognition = Arc::new(recognition);
    let cube = Some(cube_grasps(&planted));
    let before = composition.bodies[2].resolved.settled;
    let turned = turned_upright(&mut composition, &mut planted.loaded).expect("a solid");
    assert!(turned[0].is_none() && turned[1].is_none());
    let after = in_frame(&cube, turned[2]).expect("grasps");
    for (grasp, turned) in cube.iter().flatten().zip(&after) {
        let [a, b] = [
            before * grasp.object_from_tool,
            composition.bodies[2].resolved.settled * turned.object_from_tool,
        ];
        assert!(a.translation_m.distance(b.translation_m) < 1e-7, "{a:?} {b:?}");
        assert!(a.rotation.angle_between(b.rotation) < 1e-6, "{a:?} {b:?}");
    }
}
