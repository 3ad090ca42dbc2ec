//! Parts of a description that hold for an image, and their effect on a recognition.

use serde_json::{Value, json};

use super::*;

fn object(id: &str, category: &str) -> Value {
    json!({
        "id": id, "label": format!("the {category}"), "category": category, "size_m": [0.1, 0.1, 0.12], "seed": 1,
        "requested": true, "relations": [],
    })
}

fn description(objects: &[Value], understood: &Value) -> SceneDescription {
    serde_json::from_value(json!({
        "theme": "kitchen", "family": "dining_kitchen", "table": {}, "objects": objects,
        "excluded_categories": ["fork"], "understood": understood, "prose": "",
    }))
    .expect("a valid description")
}

fn with(mut object: Value, changes: &Value) -> Value {
    for (key, value) in changes.as_object().expect("an object") {
        object[key] = value.clone();
    }
    object
}

#[test]
fn hints_keep_named_objects_with_their_properties() {
    let on = |kind: &str, target: &str| json!([{ "kind": kind, "target": target }]);
    let objects = [
        with(
            object("mug_1", "mug"),
            &json!({ "mass_kg": 0.3, "material": "steel", "color": [1.0, 0.0, 0.0] }),
        ),
        with(
            object("mango_1", "stand_in_produce"),
            &json!({ "stand_in": true, "relations": on("in", "bowl_1") }),
        ),
        object("bowl_1", "bowl"),
        with(object("spoon_1", "spoon"), &json!({ "requested": false })),
        with(object("egg_1", "egg"), &json!({ "relations": on("on", "spoon_1") })),
        with(object("plate_1", "plate"), &json!({ "relations": on("left_of", "bowl_1") })),
    ];
    let hints = RecognitionHints::of(&description(&objects, &json!([]))).expect("valid hints");
    let names: Vec<&str> = hints.named().iter().map(|named| named.id.as_str()).collect();
    assert_eq!(names, ["mug_1", "mango_1", "bowl_1", "egg_1", "plate_1"]);
    assert_eq!(hints.absent(), ["fork"]);
    let [mug, mango, _, egg, plate] = hints.named() else { panic!("five objects") };
    assert_eq!(
        (mug.mass_kg, mug.material.as_deref(), mug.color),
        (Some(0.3), Some("steel"), Some(Rgb([1.0, 0.0, 0.0])))
    );
    assert!(mango.stand_in.is_some() && mug.stand_in.is_none());
    let bowl = InstanceId::new("bowl_1").expect("a name");
    assert_eq!(mango.supporter, Some((SupportRelation::In, bowl)));
    // A theme's filling supports nothing, and "left of" is no support.
    assert_eq!((&egg.supporter, &plate.supporter), (&None, &None));
}

#[test]
fn only_lengths_state_a_size() {
    for (property, value, expected) in [
        ("size", "12 cm tall", true),
        ("size", "ten inches", true),
        ("size", "small", false),
        ("mass", "300 g", false),
        ("color", "red", false),
    ] {
        let span = json!({ "start": 0, "end": value.len(), "text": value });
        let part = json!({ "span": span, "kind": "property", "property": property, "value": value, "objects": ["mug_1"] });
        let of = |id: &str| {
            let described = description(&[object(id, "mug")], &json!([part.clone()]));
            RecognitionHints::of(&described).expect("valid hints").named()[0].size_is_stated
        };
        assert_eq!(of("mug_1"), expected, "{value}");
        assert!(!of("mug_2"), "{value}");
    }
}

#[test]
fn invalid_descriptions_give_no_hints() {
    let id = |name: &str| InstanceId::new(name).expect("a name");
    let many: Vec<Value> = (0..65).map(|k| object(&format!("mug_{k}"), "mug")).collect();
    for (objects, expected) in [
        (many, InvalidHints::TooMany { count: 65 }),
        (vec![object("mug_1", "mug"), object("mug_1", "mug")], InvalidHints::RepeatedId { id: id("mug_1") }),
        (
            vec![with(object("mug_1", "mug"), &json!({ "size_m": [0.1, 0.0, 0.1] }))],
            InvalidHints::Size { id: id("mug_1") },
        ),
        (
            vec![with(object("mug_1", "mug"), &json!({ "label": "" }))],
            InvalidHints::Label { id: id("mug_1") },
        ),
    ] {
        let found = RecognitionHints::of(&description(&objects, &json!([])));
        assert_eq!(found, Err(expected));
    }
}

#[test]
fn apply_gives_label_material_mass_and_stated_size() {
    let size = json!([{
        "span": { "start": 0, "end": 5, "text": "12 cm" }, "kind": "property", "property": "size", "value": "12 cm",
        "objects": ["mango_1"],
    }]);
    let objects = [
        with(object("mango_1", "stand_in_produce"), &json!({ "mass_kg": 0.3, "size_m": [0.12, 0.08, 0.08] })),
        with(object("mug_1", "mug"), &json!({ "material": "steel" })),
    ];
    let hints = RecognitionHints::of(&description(&objects, &size)).expect("valid hints");
    let recognized = |id: &str| {
        json!({
            "id": id, "label": "item", "category": "object", "size_m": [0.2, 0.2, 0.2], "color": null,
            "material": "wood", "seed": 1, "stands_on": { "kind": "table" },
        })
    };
    let camera = geometry::Camera::orbit(64, 48, 0.7, DVec3::ZERO, 0.0, 0.8, 1.6);
    let mut recognition: Recognition = serde_json::from_value(json!({
        "camera": camera, "camera_is": "judged",
        "table": {
            "label": "table", "shape": "round", "model": "round_table", "size_m": [1, 1, 0.7], "color": null,
            "material": null, "seed": 1,
        },
        "objects": [recognized("mango_1"), recognized("mug_1"), recognized("object_1")],
    }))
    .expect("a valid recognition");
    hints.apply(&mut recognition);
    let [mango, mug, other] = &recognition.objects[..] else { panic!("three objects") };
    assert_eq!((mango.label.as_str(), mango.category.as_str()), ("the stand_in_produce", "stand_in_produce"));
    assert_eq!((mango.mass_kg, mango.size_m), (Some(0.3), DVec3::new(0.12, 0.08, 0.08)));
    assert_eq!((mug.material.as_deref(), mug.mass_kg, mug.size_m), (Some("steel"), None, DVec3::splat(0.2)));
    assert_eq!((other.label.as_str(), other.material.as_deref()), ("item", Some("wood")));
}
