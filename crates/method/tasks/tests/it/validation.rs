//! Tasks that are refused before anything is simulated, with their codes.

use crate::made_scene::made_scene;
use tasks::{Goal, RobotLimits, Task, validate};

fn robots() -> Vec<RobotLimits> {
    vec![
        RobotLimits::new("panda", 0.08, 0.005, 3.0),
        RobotLimits::new("feeble", 0.08, 0.005, 0.1),
        RobotLimits::new("wide", 0.5, 0.005, 3.0),
        RobotLimits::new("narrow", 0.03, 0.005, 3.0),
    ]
}

/// A goal as "in apple_1 box_1, lifted mug_1", the robot, and the code of the refusal ("" if there is none).
const CASES: &[(&str, &str, &str)] = &[
    ("in apple_1 box_1", "panda", ""),
    ("on apple_1 plate_1", "panda", ""),
    ("in apple_1 mug_2", "panda", ""),
    ("swapped apple_1 mug_2", "panda", ""),
    ("swapped mug_2 wine_glass_1", "panda", ""),
    ("left_of mug_2 laptop_1", "panda", ""),
    ("stacked_on book_1 book_3", "wide", ""),
    ("lifted banana_1", "panda", ""),
    ("out_of spoon_1 mug_1", "panda", ""),
    ("in apple_1 box_1, next_to banana_1 box_1", "panda", ""),
    ("in apple_1 box_1", "jaco", "unknown_robot"),
    ("in orange_1 box_1", "panda", "absent_object"),
    ("in apple_1 box_7", "panda", "absent_object"),
    ("in apple_1 plate_1", "panda", "not_a_container"),
    ("pressed lamp_1", "panda", "predicate_not_supported"),
    ("opened laptop_1", "panda", "predicate_not_supported"),
    ("used_on spoon_1 plate_1", "panda", "predicate_not_supported"),
    ("on apple_1 tray_1", "panda", "goal_already_true"),
    ("in car_1 box_1", "panda", "goal_already_true"),
    ("left_of mug_1 laptop_1", "panda", "goal_already_true"),
    ("on apple_1 tray_1, on banana_1 tray_1", "panda", "goal_already_true"),
    ("on book_1 book_2, on book_2 book_1", "panda", "goal_conflict"),
    ("on book_1 book_2, on book_2 book_3, on book_3 book_1", "panda", "goal_conflict"),
    ("in apple_1 box_1, on apple_1 plate_1", "panda", "goal_conflict"),
    ("left_of apple_1 mug_1, right_of apple_1 mug_1", "panda", "goal_conflict"),
    ("left_of mug_1 mug_2, left_of mug_2 mug_1", "panda", "goal_conflict"),
    ("lifted mug_1, lifted mug_2", "panda", "goal_conflict"),
    ("at_left mug_2, at_right mug_2", "panda", "goal_conflict"),
    ("in apple_1 mug_2, in banana_1 mug_2", "panda", "target_too_small"),
    ("on book_1 plate_2, on book_3 plate_2", "wide", "target_too_small"),
    ("on laptop_1 tray_1", "panda", "not_graspable"),
    ("in tray_1 mug_2", "wide", "no_free_place"),
    ("in apple_1 box_1", "feeble", "object_too_heavy"),
    ("in apple_1 box_1", "narrow", "object_too_wide"),
    ("on book_1 tray_1", "panda", "object_too_wide"),
];

fn goal(text: &str) -> Goal {
    let predicates: Vec<serde_json::Value> = text
        .split(", ")
        .map(|predicate| {
            let words: Vec<&str> = predicate.split(' ').collect();
            let mut value = serde_json::json!({ "predicate": words[0], "object": words[1] });
            for (key, word) in ["target", "second_target"].iter().zip(&words[2..]) {
                value[key] = serde_json::json!(word);
            }
            value
        })
        .collect();
    serde_json::from_value(predicates.into()).expect(text)
}

#[test]
fn tasks_are_refused_with_the_right_codes() {
    let (scene, robots) = (made_scene(), robots());
    let mut faults = Vec::new();
    for (text, robot, expected) in CASES {
        let task = Task::new("", goal(text), *robot);
        let refusal = validate(&task, &scene, &robots).err();
        let code = refusal.as_ref().map_or("", |refusal| refusal.code());
        if code != *expected {
            faults.push(format!("{text} by {robot}: {expected:?}, not {code:?} {refusal:?}"));
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

#[test]
fn refusals_state_the_correction() {
    let (scene, robots) = (made_scene(), robots());
    for (text, robot, part) in [
        ("in orange_1 box_1", "panda", "it has laptop_1"),
        ("in mug_3 box_1", "panda", "it has mug_1, mug_2"),
        ("in apple_1 box_1", "jaco", "use one of panda, feeble, wide, narrow"),
        ("in apple_1 mug_2, in banana_1 mug_2", "panda", "do not fit mug_2 together"),
    ] {
        let task = Task::new("", goal(text), robot);
        let message = validate(&task, &scene, &robots).expect_err(text).to_string();
        assert!(message.contains(part), "{message}");
    }
}
