//! A table of parts of a text, and what becomes of them.

use serde_json::{Value, json};

use super::*;

/// A mug and a plate are named and shown, a spoon is named and not shown; the mug stands on the plate.
fn account_of(understood: &[Value], goal: &Value) -> TextAccount {
    let object = |id: &str, category: &str| {
        json!({
            "id": id, "label": category, "category": category, "size_m": [0.1, 0.1, 0.1], "seed": 1,
            "requested": true, "relations": [],
        })
    };
    let objects = [
        object("mug_1", "mug"),
        object("mug_2", "mug"),
        object("plate_1", "plate"),
        object("spoon_1", "spoon"),
    ];
    let description: SceneDescription = serde_json::from_value(json!({
        "theme": "kitchen", "family": "dining_kitchen", "table": {}, "prose": "", "understood": understood,
        "goal": goal, "objects": objects,
    }))
    .expect("a valid description");
    let recognized = |id: &str, stands_on: Value| {
        json!({
            "id": id, "label": id, "category": "mug", "size_m": [0.1, 0.1, 0.1], "color": null,
            "material": null, "seed": 1, "stands_on": stands_on,
        })
    };
    let camera = geometry::Camera::orbit(64, 48, 0.7, glam::DVec3::ZERO, 0.0, 0.8, 1.6);
    let recognition: Recognition = serde_json::from_value(json!({
        "camera": camera, "camera_is": "measured",
        "table": {
            "label": "table", "shape": "round", "model": "round_table", "size_m": [1, 1, 0.7], "color": null,
            "material": null, "seed": 1,
        },
        "objects": [
            recognized("mug_1", json!({ "kind": "on", "object": "plate_1" })),
            recognized("plate_1", json!({ "kind": "table" })),
            recognized("object_1", json!({ "kind": "table" })),
        ],
    }))
    .expect("a valid recognition");
    let hints = RecognitionHints::of(&description).expect("valid hints");
    account(&description, &hints, &recognition)
}

fn part(meaning: &Value) -> Value {
    let mut part = json!({ "span": { "start": 0, "end": 3, "text": "abc" } });
    for (key, value) in meaning.as_object().expect("an object") {
        part[key] = value.clone();
    }
    part
}

#[test]
fn parts_of_the_text_have_an_effect_as_far_as_the_image_shows_it() {
    use UnrecognizedReason::{NotInImage, ShownByImage};
    let objects = |ids: &[&str]| json!({ "kind": "object", "category": "mug", "objects": ids });
    let relation = |kind: &str, from: &str, to: &[&str]| json!({ "kind": "relation", "relation": kind, "objects": [from], "targets": to });
    let property = |name: &str, ids: &[&str]| json!({ "kind": "property", "property": name, "value": "red", "objects": ids });
    for (meaning, kept, reason) in [
        (objects(&["mug_1"]), Some(objects(&["mug_1"])), None),
        (objects(&["mug_1", "mug_2"]), Some(objects(&["mug_1"])), Some(NotInImage)),
        (objects(&["spoon_1"]), None, Some(NotInImage)),
        (property("color", &["mug_1", "mug_2"]), Some(property("color", &["mug_1"])), None),
        (property("mass", &["spoon_1"]), None, Some(NotInImage)),
        (property("state", &["mug_1"]), None, Some(ShownByImage)),
        (relation("on", "mug_1", &["plate_1"]), Some(relation("on", "mug_1", &["plate_1"])), None),
        (relation("in", "mug_1", &["plate_1"]), None, Some(ShownByImage)),
        (relation("on", "plate_1", &[]), Some(relation("on", "plate_1", &[])), None),
        (relation("left_of", "mug_1", &["plate_1"]), None, Some(ShownByImage)),
        (json!({ "kind": "table" }), None, Some(ShownByImage)),
        (
            json!({ "kind": "exclusion", "categories": ["fork"] }),
            Some(json!({ "kind": "exclusion", "categories": ["fork"] })),
            None,
        ),
    ] {
        let account = account_of(&[part(&meaning)], &Value::Null);
        let understood: Vec<Value> = account.understood.iter().map(|part| json!(part.meaning)).collect();
        assert_eq!(understood, Vec::from_iter(kept), "{meaning}");
        let reasons: Vec<UnrecognizedReason> = account.unrecognized.iter().map(|part| part.reason).collect();
        assert_eq!(reasons, Vec::from_iter(reason), "{meaning}");
    }
}

#[test]
fn a_goal_needs_all_its_objects() {
    let goal = |object: &str| {
        let predicate = json!({ "predicate": "on", "object": object, "target": "plate_1" });
        json!({ "instruction": "move", "predicates": [predicate] })
    };
    let meaning = part(&json!({ "kind": "goal", "index": 0 }));
    let shown = account_of(std::slice::from_ref(&meaning), &goal("mug_1"));
    assert!(shown.goal.is_some() && shown.understood.len() == 1 && shown.unrecognized.is_empty());
    let hidden = account_of(&[meaning], &goal("spoon_1"));
    assert!(hidden.goal.is_none() && hidden.understood.is_empty());
    assert_eq!(hidden.unrecognized[0].reason, UnrecognizedReason::NotInImage);
}
