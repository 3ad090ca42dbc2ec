//! Whole tasks in small scenes.

use std::collections::BTreeMap;
use std::sync::Mutex;

use ::scene::InstanceId;
use geometry::shapes::{block, cylinder};
use geometry::{DVec2, DVec3, Outline};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use super::*;
use crate::grasp::{Grasp, GraspSettings, grasps};
use crate::test_scenes::{body, box_body};

fn scene(objects: Vec<physics::Body>) -> TaskScene {
    let corners = [(-0.6, -0.4), (0.6, -0.4), (0.6, 0.4), (-0.6, 0.4)].map(DVec2::from);
    let top = block(DVec3::new(1.2, 0.8, 0.03)).translated(DVec3::new(0.0, 0.0, -0.03));
    TaskScene {
        table: physics::Body { fixed: true, ..box_body("table", top, 10.0, Pose::IDENTITY) },
        outline: Outline::new(corners.to_vec()).expect("a rectangle"),
        objects,
    }
}

/// A plate with a raised rim of eight pieces, 20 cm wide.
fn plate(at: DVec2) -> physics::Body {
    let floor = cylinder(0.09, 0.008, 0.0, 32);
    body("plate_1", vec![floor], 0.4, Pose::upright(at.extend(0.0), 0.0))
}

fn cube(name: &str, at: DVec2, yaw_rad: f64) -> physics::Body {
    box_body(name, block(DVec3::splat(0.045)), 0.1, Pose::upright(at.extend(0.0), yaw_rad))
}

fn task(goal: &str) -> Task {
    Task::new("a test", serde_json::from_str(goal).expect("a goal"), "panda")
}

fn few() -> GraspSettings {
    GraspSettings {
        surface_points: 300,
        max_trials: 10,
        wanted_stable: 6,
        ..test_settings::section("grasps")
    }
}

/// Grasps of what a task moves. Those of a cube are found once for each robot: they take longer than most tasks.
fn book(scene: &TaskScene, robot: &Robot, task: &Task) -> GraspBook {
    static OF_CUBES: Mutex<BTreeMap<String, Vec<Grasp>>> = Mutex::new(BTreeMap::new());
    let cube = cube("cube", DVec2::ZERO, 0.0);
    let of_cube = OF_CUBES
        .lock()
        .expect("no test panics here")
        .entry(robot.name().to_owned())
        .or_insert_with(|| grasps(&cube, robot, &few(), &mut ChaCha8Rng::seed_from_u64(1)).expect("a cube"))
        .clone();
    let cubes = scene.objects.iter().filter(|object| object.hulls == cube.hulls && object.mass == cube.mass);
    let known = cubes.map(|object| (object.name.clone(), of_cube.clone())).collect();
    KnownGrasps::new(scene, robot, &few(), 1).with(known).book(&task.goal).expect("objects")
}

fn run(scene: &TaskScene, robot: &Robot, task: &Task, seed: u64) -> Result<Execution, Refusal> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    execute(
        scene,
        robot,
        task,
        &book(scene, robot, task),
        &RobotStart::default(),
        &test_settings::section::<ExecutionSettings>("execution"),
        &mut rng,
    )
}

fn standing(world_from_base: Isometry3<f64>) -> RobotStart {
    RobotStart { world_from_base: Some(world_from_base), joint_positions: None }
}

fn panda() -> Robot {
    Robot::built_in("panda", None).expect("built in")
}

fn explained(execution: &Execution) -> String {
    format!(
        "{} failure {:?} ({:?}), {:.1} s, base {:?}, picks {:?}, predicates {:?}, disturbed {:?}",
        execution.robot,
        execution.failure,
        execution.detail,
        execution.duration_s,
        execution.world_from_base,
        execution.picks,
        execution.predicates,
        execution.disturbed
    )
}

#[test]
fn a_block_is_put_on_a_plate() {
    let robot = panda();
    let task = task(r#"[{"predicate": "on", "object": "block_1", "target": "plate_1"}]"#);
    for seed in 0..6 {
        let angle = 1.0 * seed as f64;
        let scene = scene(vec![
            cube("block_1", DVec2::new(-0.15, 0.05) + 0.04 * DVec2::from_angle(angle), angle),
            plate(DVec2::new(0.15, -0.05)),
            cube("other_1", DVec2::new(0.0, 0.2), 0.3),
        ]);
        let execution = run(&scene, &robot, &task, seed).expect("attempted");
        assert!(execution.succeeded, "seed {seed}: {}", explained(&execution));
        let frames = &execution.recording.frames;
        assert!(frames.len() as f64 > 45.0 * execution.duration_s, "{}", frames.len());
        assert!(execution.picks[0].slip_m < 2e-3, "{}", explained(&execution));
    }
}

#[test]
fn the_small_arm_puts_a_block_on_a_plate() {
    let robot = Robot::built_in("piper", None).expect("built in");
    let task = task(r#"[{"predicate": "on", "object": "block_1", "target": "plate_1"}]"#);
    let scene = scene(vec![cube("block_1", DVec2::new(-0.1, 0.05), 0.4), plate(DVec2::new(0.12, -0.05))]);
    let execution = run(&scene, &robot, &task, 1).expect("attempted");
    assert!(execution.succeeded, "{}", explained(&execution));
}

/// Regression: the second step was planned as if the first had not been made, so that the base stood where the arm
/// could not put the second block that high. The wrist of this arm does not point down at what is as high as its
/// shoulder: it needs a stand.
#[test]
fn the_small_arm_stands_where_it_can_make_the_last_step() {
    let robot = Robot::built_in("piper", None).expect("built in");
    let goal = r#"[{"predicate": "on", "object": "red_1", "target": "plate_1"},
        {"predicate": "stacked_on", "object": "blue_1", "target": "red_1"}]"#;
    let high = body("plate_1", vec![cylinder(0.09, 0.06, 0.0, 32)], 0.4, Pose::upright(DVec3::ZERO, 0.0));
    let scene = scene(vec![
        cube("red_1", DVec2::new(-0.2, 0.1), 0.4),
        cube("blue_1", DVec2::new(-0.2, -0.1), 0.0),
        high,
    ]);
    let execution = run(&scene, &robot, &task(goal), 1).expect("attempted");
    assert!(execution.succeeded, "{}", explained(&execution));
    let settings: ExecutionSettings = test_settings::section("execution");
    assert!(execution.world_from_base.translation_m.z > settings.mounts_m[0], "{}", explained(&execution));
}

/// Regression: fingers that open by a centimeter more than the object is wide had no room beside its neighbors.
#[test]
fn fingers_open_less_between_close_neighbors() {
    let robot = panda();
    let goal = task(r#"[{"predicate": "lifted", "object": "block_1"}]"#);
    let side_m = 0.045;
    let beside = |name: &str, at: DVec2| cube(name, at, 0.0);
    // The gap, and how far the fingers are open beside each side of the block.
    for (gap_m, clearance_m) in [(0.035, Some(0.010)), (0.025, Some(0.003)), (0.005, None)] {
        let way = |x: f64, y: f64| (side_m + gap_m) * DVec2::new(x, y);
        let scene = scene(vec![
            cube("block_1", DVec2::ZERO, 0.0),
            beside("left_1", way(-1.0, 0.0)),
            beside("right_1", way(1.0, 0.0)),
            beside("near_1", way(0.0, -1.0)),
            beside("far_1", way(0.0, 1.0)),
        ]);
        let execution = run(&scene, &robot, &goal, 1).expect("attempted");
        let found = execution.picks.first().filter(|_| execution.succeeded);
        let found_m = found.map(|pick| 0.5 * (pick.grasp.pregrasp_opening_m - side_m));
        let is_expected = match (found_m, clearance_m) {
            (Some(found_m), Some(clearance_m)) => (found_m - clearance_m).abs() < 1e-3,
            (found, expected) => found.is_none() && expected.is_none(),
        };
        assert!(is_expected, "gap {gap_m} m, {found_m:?}: {}", explained(&execution));
    }
}

#[test]
fn blocks_are_stacked_swapped_and_lifted() {
    let robot = panda();
    let scene = scene(vec![
        cube("red_1", DVec2::new(-0.15, 0.1), 0.4),
        cube("blue_1", DVec2::new(0.1, 0.12), 0.0),
        plate(DVec2::new(0.1, -0.15)),
    ]);
    for goal in [
        r#"[{"predicate": "stacked_on", "object": "red_1", "target": "blue_1"},
            {"predicate": "on", "object": "blue_1", "target": "plate_1"}]"#,
        r#"[{"predicate": "swapped", "object": "red_1", "target": "blue_1"}]"#,
        r#"[{"predicate": "lifted", "object": "red_1"}]"#,
        r#"[{"predicate": "left_of", "object": "blue_1", "target": "red_1"}]"#,
        r#"[{"predicate": "next_to", "object": "blue_1", "target": "plate_1"},
            {"predicate": "at_left", "object": "red_1"}]"#,
    ] {
        let execution = run(&scene, &robot, &task(goal), 3).expect("attempted");
        assert!(execution.succeeded, "{goal}: {}", explained(&execution));
    }
}

#[test]
fn equal_seeds_give_equal_bytes() {
    let robot = panda();
    let task = task(r#"[{"predicate": "on", "object": "block_1", "target": "plate_1"}]"#);
    let scene = scene(vec![cube("block_1", DVec2::new(-0.1, 0.05), 0.4), plate(DVec2::new(0.15, -0.05))]);
    let json = || serde_json::to_string(&run(&scene, &robot, &task, 2).expect("attempted")).expect("JSON");
    assert_eq!(json(), json());
}

#[test]
fn what_cannot_be_done_is_refused_with_a_code() {
    let robot = panda();
    let heavy = physics::Body {
        name: "heavy_1".to_owned(),
        ..box_body("heavy_1", block(DVec3::splat(0.05)), 8.0, Pose::upright(DVec3::new(-0.3, 0.2, 0.0), 0.0))
    };
    let wide =
        box_body("wide_1", block(DVec3::splat(0.2)), 0.5, Pose::upright(DVec3::new(0.3, 0.2, 0.0), 0.0));
    let scene = scene(vec![
        cube("block_1", DVec2::new(-0.1, 0.05), 0.4),
        cube("block_2", DVec2::new(-0.2, -0.2), 0.4),
        plate(DVec2::new(0.15, -0.05)),
        heavy,
        wide,
    ]);
    let code = |goal: &str| {
        let task = task(goal);
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let settings: ExecutionSettings = test_settings::section("execution");
        let result =
            execute(&scene, &robot, &task, &GraspBook::new(), &RobotStart::default(), &settings, &mut rng);
        result.err().map(|refusal| refusal.code())
    };
    let on = |object: &str, target: &str| {
        format!(r#"[{{"predicate": "on", "object": "{object}", "target": "{target}"}}]"#)
    };
    assert_eq!(code(&on("block_9", "plate_1")), Some("absent_object"));
    assert_eq!(code(&on("block_1", "bowl_1")), Some("absent_object"));
    assert_eq!(code(&on("heavy_1", "plate_1")), Some("object_too_heavy"));
    assert_eq!(code(&on("wide_1", "plate_1")), Some("object_too_wide"));
    assert_eq!(code(r#"[{"predicate": "on", "object": "block_1"}]"#), Some("goal_already_true"));
    assert_eq!(
        code(r#"[{"predicate": "upside_down", "object": "block_1"}]"#),
        Some("predicate_not_supported")
    );
    let both = r#"[{"predicate": "stacked_on", "object": "block_1", "target": "plate_1"},
        {"predicate": "stacked_on", "object": "block_2", "target": "plate_1"}]"#;
    assert_eq!(code(both), Some("goal_conflict"));
    let far = Isometry3::translation(5.0, 0.0, 0.0);
    let task = task(&on("block_1", "plate_1"));
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let result = execute(
        &scene,
        &robot,
        &task,
        &GraspBook::new(),
        &standing(far),
        &test_settings::section::<ExecutionSettings>("execution"),
        &mut rng,
    );
    assert_eq!(result.err().map(|refusal| refusal.code()), Some("table_out_of_reach"));
}

#[test]
fn an_object_without_a_stable_grasp_is_a_failure() {
    let scene = scene(vec![cube("block_1", DVec2::new(-0.1, 0.05), 0.4), plate(DVec2::new(0.15, -0.05))]);
    let task = task(r#"[{"predicate": "on", "object": "block_1", "target": "plate_1"}]"#);
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let base = Isometry3::translation(-0.5, 0.0, 0.02);
    let settings: ExecutionSettings = test_settings::section("execution");
    let execution = execute(&scene, &panda(), &task, &GraspBook::new(), &standing(base), &settings, &mut rng);
    assert_eq!(execution.expect("attempted").failure, Some(Failure::NoGrasp));
    for failure in [
        Failure::Unreachable,
        Failure::NoGrasp,
        Failure::NoPath,
        Failure::Slipped,
        Failure::Dropped,
        Failure::GoalNotMet,
        Failure::DisturbedOthers,
    ] {
        assert_eq!(serde_json::to_value(failure).expect("JSON"), failure.code());
    }
}

/// Regression: a place on the upper one of two thin objects was refused, because the lower one is within the distance
/// that fingers need.
#[test]
fn what_lies_below_the_support_is_in_nobodys_way() {
    let robot = panda();
    let task = task(r#"[{"predicate": "on", "object": "block_1", "target": "book_2"}]"#);
    let thin = |name: &str, z_m: f64| {
        let at = Pose::upright(DVec3::new(0.15, 0.0, z_m), 0.0);
        box_body(name, block(DVec3::new(0.15, 0.2, 0.012)), 0.4, at)
    };
    let block_1 = cube("block_1", DVec2::new(-0.15, 0.05), 0.2);
    let scene = scene(vec![block_1, thin("book_1", 0.0), thin("book_2", 0.012)]);
    let execution = run(&scene, &robot, &task, 1).expect("attempted");
    assert!(execution.succeeded, "{}", explained(&execution));
}

#[test]
fn an_object_between_others_cannot_be_picked() {
    let robot = panda();
    let settings: ExecutionSettings = test_settings::section("execution");
    let goal = task(r#"[{"predicate": "lifted", "object": "block_1"}]"#);
    let block_1 = cube("block_1", DVec2::new(-0.1, 0.05), 0.0);
    // Four walls, 3 mm away and taller than fingers are long.
    let wall = |name: &str, x_m: f64, y_m: f64| {
        let solid = block(DVec3::new(0.051, 0.051, 0.25));
        let at = Pose::upright(DVec3::new(-0.1 + x_m, 0.05 + y_m, 0.0), 0.0);
        box_body(name, solid, 0.5, at)
    };
    let walls =
        [("wall_1", 0.051, 0.0), ("wall_2", -0.051, 0.0), ("wall_3", 0.0, 0.051), ("wall_4", 0.0, -0.051)];
    let alone = scene(vec![block_1.clone()]);
    let walled_in =
        scene(std::iter::once(block_1).chain(walls.map(|(name, x, y)| wall(name, x, y))).collect());
    let book = book(&alone, &robot, &goal);
    let name = InstanceId::new("block_1").expect("a name");
    let can_be_picked = |scene: &TaskScene, grasps: &[Grasp]| {
        let rehearsal = Rehearsal::new(scene, &robot, &settings).expect("a scene");
        rehearsal.can_be_picked(&name, grasps)
    };
    let grasps = &book["block_1"];
    assert!(grasps.iter().any(|grasp| grasp.verdict == crate::grasp::Verdict::Stable), "{grasps:#?}");
    assert!(can_be_picked(&alone, grasps));
    assert!(!can_be_picked(&alone, &[]));
    assert!(!can_be_picked(&walled_in, grasps));
}

/// Regression: what a bundle knew was tried again with other random numbers, and could have another answer.
#[test]
fn known_grasps_are_not_tried_again() {
    let robot = Robot::built_in("panda", None).expect("built in");
    let scene = scene(vec![cube("block_1", DVec2::new(-0.1, 0.05), 0.0)]);
    let (settings, goal) = (few(), task(r#"[{"predicate": "lifted", "object": "block_1"}]"#).goal);
    let found = KnownGrasps::new(&scene, &robot, &settings, 1).book(&goal).expect("an object");
    let best = GraspBook::from([("block_1".to_owned(), found["block_1"][..1].to_vec())]);
    let mut known = KnownGrasps::new(&scene, &robot, &settings, 2).with(best.clone());
    assert_eq!((known.one_held("block_1"), known.book(&goal)), (Ok(true), Ok(best)));
    let mut none = KnownGrasps::new(&scene, &robot, &settings, 2)
        .with(GraspBook::from([("block_1".to_owned(), Vec::new())]));
    assert_eq!((none.one_held("block_1"), none.one_held("spoon_1")), (Ok(false), Ok(false)));
}
