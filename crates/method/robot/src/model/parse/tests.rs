//! Tests of the robots that are built in, of a made-up one, and of refusals.

use super::*;

const GANTRY: &str = include_str!("../../../tests/robots/gantry.toml");

/// The refusal of the gantry's file with one passage replaced.
fn refusal(from: &str, to: &str) -> String {
    assert!(GANTRY.contains(from), "the file has no {from:?}");
    Robot::parse(&GANTRY.replacen(from, to, 1), "gantry.toml", None).expect_err(to).to_string()
}

#[test]
fn third_robot_is_a_data_file() {
    let robot = Robot::parse(GANTRY, "gantry.toml", None).expect("a robot");
    assert_eq!((robot.name(), robot.dof(), robot.links().len()), ("gantry", 2, 5));
    assert_eq!(robot.arm_links(), [1, 2]);
    assert_eq!(robot.gripper().max_opening_m, 0.06);
    assert_eq!(robot.gripper_position(0.03), 0.015);
}

#[test]
fn built_in_robots_have_the_limits_of_their_makers() {
    let panda = Robot::built_in("panda", None).expect("built in");
    assert_eq!(panda.dof(), 7);
    assert_eq!(panda.limits()[3].max_position, -0.0698);
    assert_eq!(panda.limits()[1].max_jerk, 3750.0);
    let wide = Robot::built_in("panda", Some("motion_bench_maker")).expect("a variant");
    assert_eq!((wide.variant(), wide.limits()[3].max_position), (Some("motion_bench_maker"), 0.0873));
    let piper = Robot::built_in("piper", None).expect("built in");
    assert_eq!((piper.dof(), piper.limits()[4].max_position), (6, 1.22));
    let mass_kg: f64 = piper.links().iter().filter_map(|link| link.inertia).map(|i| i.mass_kg).sum();
    assert!((mass_kg - 4.2).abs() < 0.01, "{mass_kg}");
}

#[test]
fn unknown_robot_and_variant_are_refused_with_those_that_exist() {
    let error = Robot::built_in("pander", None).expect_err("no such robot").to_string();
    assert_eq!(error, "robot \"pander\" is not built in; built in are panda, piper");
    let error = Robot::built_in("piper", Some("new")).expect_err("no such variant").to_string();
    assert_eq!(
        error,
        "robot file config/robots/piper.toml: variants: no variant \"new\"; there are [\"old_zero\"]"
    );
}

#[test]
fn refusals_name_the_file_and_the_key() {
    let cases = [
        ("mass_kg = 5", "mass = 5", "gantry.toml: links[0].inertia"),
        ("mass_kg = 5", "mass_kg = -5", "links[0].inertia.mass_kg: -5 must be above 0"),
        ("name = \"carriage\"", "name = \"frame\"", "links[1].name: two links are named \"frame\""),
        ("name = \"carriage\"", "name = \"the carriage\"", "links[1].name: \"the carriage\" must start with"),
        ("parent = \"carriage\"", "parent = \"boom\"", "links[2].joint.parent: no link is named \"boom\""),
        ("position = [-3, 3]", "position = [3, -3]", "links[2].joint.limits.position: the first bound"),
        ("axis = [1, 0, 0]", "axis = [0, 0, 0]", "links[2].joint.axis: a joint that moves needs an axis"),
        ("kind = \"revolute\"", "kind = \"fixed\"", "links[2].joint: a fixed joint has no axis"),
        ("material = \"gray\"", "material = \"grey\"", "links[0].shapes[0].material: no material is named"),
        ("{ sphere = ", "{ ball = ", "links[1].shapes[0]"),
        ("joint = \"grip\"\nopening", "joint = \"roll\"\nopening", "mimic.joint: only the gripper's joint"),
        ("max_force_n = 20", "max_force_n = 5", "gripper.max_force_n: must not be below grip_force_n"),
        ("positions = [0, 0]", "positions = [0, 4]", "home.positions[1]: outside of the limits"),
        ("positions = [0, 0]", "positions = [0]", "home.positions: 1 positions for the 2 joints"),
        ("opening_m = 0.06", "opening_m = 0.07", "home.opening_m: must be in 0..=0.06"),
        ("reason = \"The fingers close on each other\"", "reason = \" \"", "ignored_pairs[0].reason"),
        ("gray = [0.5, 0.5, 0.5]", "gray = [0.5, 0.5, 50]", "materials.gray: each channel"),
        ("sources = [\"Made up for tests\"]", "sources = []", "sources: state where"),
        ("link = \"boom\"", "link = \"bom\"", "tool.link: no link is named \"bom\""),
    ];
    for (from, to, expected) in cases {
        let message = refusal(from, to);
        assert!(message.contains(expected), "{to}: {message}");
    }
}

#[test]
fn impossible_inertia_is_refused() {
    let stated = "mass_kg = 5, center_m = [0, 0, 0], moments_kg_m2 = [1, 0, 0, 1, 0, 2.5]";
    let message = refusal("mass_kg = 5", stated);
    assert!(message.contains("links[0].inertia.moments_kg_m2: no rigid body"), "{message}");
}

#[test]
fn text_that_is_no_toml_is_refused() {
    let message = Robot::parse("name = ", "x.toml", None).expect_err("no value").to_string();
    assert!(message.starts_with("robot file x.toml: the whole file"), "{message}");
}
