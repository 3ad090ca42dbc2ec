//! Grasps of simple objects, in shape and in simulation.

use geometry::DQuat;
use geometry::shapes::{cylinder, sphere};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use scene::grasps::GraspFile;

use super::*;
use crate::test_scenes::{block, body, box_body};

fn panda() -> Robot {
    Robot::built_in("panda", None).expect("built in")
}

fn few() -> GraspSettings {
    GraspSettings { max_trials: 6, wanted_stable: 3, surface_points: 300, ..test_settings::section("grasps") }
}

fn found(object: &Body, robot: &Robot) -> Vec<Grasp> {
    grasps(object, robot, &few(), &mut ChaCha8Rng::seed_from_u64(5)).expect("an object")
}

fn stable(grasps: &[Grasp]) -> usize {
    grasps.iter().filter(|grasp| grasp.verdict == Verdict::Stable).count()
}

/// Eight walls around a floor, as wide as a cereal bowl.
fn bowl() -> Body {
    let walls = (0..12).map(|k| {
        let turn = DQuat::from_rotation_z(std::f64::consts::TAU * f64::from(k) / 12.0);
        let wall = block(DVec3::new(0.005, 0.041, 0.05)).translated(DVec3::new(0.07, 0.0, 0.005));
        let positions = wall.positions.iter().map(|p| turn * *p).collect();
        geometry::Solid { positions, ..wall }
    });
    let solids = walls.chain([cylinder(0.068, 0.005, 0.0, 32)]).collect();
    body("bowl", solids, 0.25, Pose::IDENTITY)
}

#[test]
fn simple_objects_have_stable_grasps() {
    let lying = Pose {
        translation_m: DVec3::new(0.3, 0.2, 0.02),
        rotation: DQuat::from_rotation_x(std::f64::consts::FRAC_PI_2),
    };
    let objects = [
        box_body("box", block(DVec3::new(0.04, 0.06, 0.05)), 0.2, Pose::IDENTITY),
        box_body("can", cylinder(0.03, 0.1, 0.001, 40), 0.3, Pose::upright(DVec3::new(0.1, 0.0, 0.0), 0.3)),
        box_body("stick", cylinder(0.02, 0.12, 0.001, 40), 0.1, lying),
        box_body("ball", sphere(0.03, 32), 0.1, Pose::IDENTITY),
        box_body("card", block(DVec3::new(0.06, 0.09, 0.004)), 0.02, Pose::IDENTITY),
        bowl(),
    ];
    for robot in [panda(), Robot::built_in("piper", None).expect("built in")] {
        for object in &objects {
            let grasps = found(object, &robot);
            assert!(stable(&grasps) > 0, "{} {}: {grasps:#?}", robot.name(), object.name);
            for grasp in grasps.iter().filter(|grasp| grasp.verdict == Verdict::Stable) {
                assert!(grasp.slip_m < 1e-3 && grasp.confidence > 0.5, "{grasp:?}");
                assert!(grasp.opening_m <= robot.gripper().max_opening_m - 0.0049, "{grasp:?}");
            }
        }
    }
}

#[test]
fn bowls_are_taken_by_the_wall() {
    for grasp in found(&bowl(), &panda()) {
        let at = grasp.object_from_tool.translation_m;
        assert!(grasp.opening_m < 0.03 && at.truncate().length() > 0.05, "{grasp:?}");
    }
}

#[test]
fn what_is_too_wide_has_no_grasp() {
    let wide = box_body("wide", block(DVec3::new(0.2, 0.2, 0.1)), 1.0, Pose::IDENTITY);
    assert!(found(&wide, &panda()).is_empty());
}

#[test]
fn a_heavy_slippery_object_is_dropped() {
    let object = box_body("weight", block(DVec3::new(0.04, 0.06, 0.05)), 9.0, Pose::IDENTITY);
    let grasps = found(&object, &panda());
    assert!(!grasps.is_empty() && stable(&grasps) == 0, "{grasps:#?}");
}

#[test]
fn hands_of_candidates_touch_nothing() {
    // A box with a lid that reaches over its sides: hands from above must not go through it.
    let lid = block(DVec3::new(0.16, 0.16, 0.01)).translated(DVec3::new(0.0, 0.0, 0.08));
    let object = body("lid", vec![block(DVec3::new(0.05, 0.05, 0.08)), lid], 0.4, Pose::IDENTITY);
    let robot = panda();
    let hand = HandShape::new(&robot);
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    for candidate in candidates(&object, &hand, &few(), &mut rng) {
        let pose = candidate.object_from_tool;
        for solid in hand.solids(candidate.pregrasp_opening_m, true) {
            for corner in solid {
                let p = pose.transform_point(corner);
                let in_lid = p.x.abs() < 0.0799 && p.y.abs() < 0.0799 && (0.0801..0.0899).contains(&p.z);
                let in_box = p.x.abs() < 0.0249 && p.y.abs() < 0.0249 && (0.0..0.08).contains(&p.z);
                assert!(!in_lid && !in_box && p.z > 0.0, "{candidate:?}: {p}");
            }
        }
    }
}

#[test]
fn equal_seeds_give_equal_grasps() {
    let object = box_body("box", block(DVec3::new(0.03, 0.05, 0.05)), 0.2, Pose::upright(DVec3::ZERO, 0.4));
    assert_eq!(found(&object, &panda()), found(&object, &panda()));
}

#[test]
fn files_state_the_grasps() {
    let robot = panda();
    let object = box_body("box", block(DVec3::new(0.03, 0.05, 0.05)), 0.2, Pose::IDENTITY);
    let grasps = found(&object, &robot);
    let text = isaac_grasp_yaml(&robot, "box", &grasps);
    let yaml: serde_norway::Value = serde_norway::from_str(&text).expect("YAML");
    assert_eq!(yaml["format"].as_str(), Some("isaac_grasp"));
    assert_eq!(yaml["format_version"].as_f64(), Some(1.0));
    let first = &yaml["grasps"]["grasp_0"];
    assert_eq!(first["position"][2].as_f64(), Some(grasps[0].object_from_tool.translation_m.z));
    assert_eq!(first["orientation"]["w"].as_f64(), Some(grasps[0].object_from_tool.rotation.w));
    let closed = first["cspace_position"]["finger_joint1"].as_f64().expect("a position");
    assert!((closed - 0.5 * grasps[0].opening_m).abs() < 1e-12);
    let file = grasp_file(&robot, &grasps);
    let back: GraspFile = serde_json::from_str(&serde_json::to_string(&file).expect("JSON")).expect("a file");
    assert_eq!(back, file);
}
