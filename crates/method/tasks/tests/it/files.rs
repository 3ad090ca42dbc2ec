//! Tasks as files: the JSON schema and BDDL.

use std::collections::BTreeSet;

use crate::made_scene::made_scene;
use serde_json::Value;
use tasks::{Goal, Task, bddl};

fn schema() -> Value {
    serde_json::from_str(include_str!("../../../../../schemas/task.schema.json")).expect("the schema is JSON")
}

fn task() -> Task {
    let goal: Goal = serde_json::from_str(
        r#"[
            {"predicate": "out_of", "object": "spoon_1", "target": "mug_1"},
            {"predicate": "on", "object": "spoon_1"},
            {"predicate": "between", "object": "car_1", "target": "plate_1", "second_target": "plate_2"}
        ]"#,
    )
    .expect("a goal");
    Task::new("take the spoon\nout of the mug", goal, "panda")
}

fn strings(value: &Value) -> BTreeSet<String> {
    value.as_array().into_iter().flatten().filter_map(Value::as_str).map(str::to_owned).collect()
}

fn keys(value: &Value) -> BTreeSet<String> {
    value.as_object().into_iter().flat_map(|object| object.keys()).cloned().collect()
}

#[test]
fn schema_has_the_fields_that_are_written() {
    let (schema, task) = (schema(), serde_json::to_value(task()).expect("serializes"));
    assert_eq!(keys(&schema["properties"]), keys(&task));
    assert_eq!(strings(&schema["required"]), keys(&task));
    let limits = &schema["$defs"]["TaskLimits"];
    assert_eq!(keys(&limits["properties"]), keys(&task["limits"]));
    assert_eq!(strings(&limits["required"]), keys(&task["limits"]));
    let predicate = &schema["$defs"]["GoalPredicate"];
    assert_eq!(keys(&predicate["properties"]), keys(&task["goal"][2]));
    for object in [&schema, limits, predicate] {
        assert_eq!(object["additionalProperties"], Value::Bool(false));
    }
    assert_eq!(schema["properties"]["format"]["const"], task["format"]);
}

#[test]
fn schema_has_the_predicates_that_are_read_with_their_targets() {
    let schema = schema();
    let predicate = &schema["$defs"]["GoalPredicate"];
    let names = strings(&schema["$defs"]["PredicateKind"]["enum"]);
    let with_target = strings(&predicate["allOf"][1]["if"]["properties"]["predicate"]["enum"]);
    let without = strings(&predicate["allOf"][2]["if"]["properties"]["predicate"]["enum"]);
    assert_eq!(names.len(), 33);
    for name in &names {
        let read = |targets: &str| {
            let text = format!(r#"[{{"predicate": "{name}", "object": "a"{targets}}}]"#);
            serde_json::from_str::<Goal>(&text).is_ok()
        };
        let (one, two) = (r#", "target": "b""#, r#", "target": "b", "second_target": "c""#);
        let expected = match name.as_str() {
            "between" => [false, false, true],
            "on" => [true, true, false],
            name if with_target.contains(name) => [false, true, false],
            name => {
                assert!(without.contains(name), "{name}");
                [true, false, false]
            }
        };
        assert_eq!([read(""), read(one), read(two)], expected, "{name}");
    }
}

/// An expression of parentheses and words.
fn depth_is_balanced(text: &str) -> bool {
    let mut depth = 0;
    for c in text.chars() {
        depth += match c {
            '(' => 1,
            ')' => -1,
            _ => 0,
        };
        if depth < 0 {
            return false;
        }
    }
    depth == 0
}

#[test]
fn problem_has_objects_supports_and_goal() {
    let problem = bddl::problem("spoon out/1", &task(), &made_scene());
    let flat = problem.split_whitespace().collect::<Vec<_>>().join(" ");
    for part in [
        "; take the spoon out of the mug (define (problem spoon_out_1) (:domain tabletopgen)",
        "mug_1 mug_2 - mug",
        "table - table",
        "(inside spoon_1 mug_1)",
        "(ontop apple_1 tray_1)",
        "(ontop tray_1 table)",
        "(:goal (and (not (inside spoon_1 mug_1)) (ontop spoon_1 table) (between car_1 plate_1 plate_2) ) )",
    ] {
        assert!(flat.contains(part), "{part} in\n{problem}");
    }
    assert!(depth_is_balanced(&problem) && depth_is_balanced(&bddl::domain()));
}

#[test]
fn domain_declares_every_predicate_that_problems_have() {
    let domain = bddl::domain();
    let scene = made_scene();
    for kind in strings(&schema()["$defs"]["PredicateKind"]["enum"]) {
        for targets in ["", r#", "target": "mug_1""#, r#", "target": "mug_1", "second_target": "mug_2""#] {
            let text = format!(r#"[{{"predicate": "{kind}", "object": "apple_1"{targets}}}]"#);
            let Ok(goal) = serde_json::from_str::<Goal>(&text) else { continue };
            let problem = bddl::problem("p", &Task::new("", goal, "panda"), &scene);
            let (_, goal) = problem.split_once("(:goal").expect("a goal");
            let atom = goal.split('(').find(|atom| atom.contains("apple_1")).expect("an atom");
            let name = atom.split(' ').next().expect("a name");
            let arity = atom.trim_end_matches([')', '\n', ' ']).split(' ').count() - 1;
            let declared = domain
                .lines()
                .map(str::trim)
                .any(|line| line.starts_with(&format!("({name} ")) && line.matches('?').count() == arity);
            assert!(declared, "{name} of {arity}");
        }
    }
}
