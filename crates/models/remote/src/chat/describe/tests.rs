//! Answers that are taken, and answers that are complained about.

use super::*;

fn answer() -> Value {
    json!({
        "theme": "breakfast_table", "family": "dining_kitchen",
        "table": {
            "model": "dining_table", "material": "oak", "color": null, "width_m": 1.4, "depth_m": 0.8, "height_m": 0.74,
        },
        "objects": [
            {
                "name": "plate_1", "label": "white plate", "category": "plate", "width_m": 0.26, "depth_m": 0.26,
                "height_m": 0.025, "color": "#ffffff", "material": "ceramic", "requested": true,
                "relations": [{ "kind": "at_front", "target": null }],
            },
            {
                "name": "apple_1", "label": "apple", "category": "apple", "width_m": 0.08, "depth_m": 0.08,
                "height_m": 0.08, "color": null, "material": null, "requested": true,
                "relations": [{ "kind": "on", "target": "plate_1" }],
            },
        ],
        "unrecognized_terms": ["flux capacitor"], "prose": "An apple on a plate.",
    })
}

fn read(answer: &Value, wanted: &TableSpec) -> Result<SceneDescription, String> {
    let answer: Answer = serde_json::from_value(answer.clone()).map_err(|error| error.to_string())?;
    accepted(answer, "A plate with an apple and a Flux Capacitor", 7, 4, wanted)
        .map_err(|complaints| complaints.join("; "))
}

fn spoiled(pointer: &str, value: Value) -> String {
    let mut answer = answer();
    *answer.pointer_mut(pointer).expect(pointer) = value;
    read(&answer, &TableSpec::default()).expect_err(pointer)
}

#[test]
fn accepted_converts_a_valid_answer() {
    let description = read(&answer(), &TableSpec::default()).expect("holds");
    assert_eq!(description.table.shape, Some(TableShape::Rectangular));
    assert_eq!(description.table.size_m, Some(DVec3::new(1.4, 0.8, 0.74)));
    let [plate, apple] = &description.objects[..] else { panic!("two objects") };
    assert_eq!((plate.id.as_str(), apple.id.as_str()), ("plate_1", "apple_1"));
    assert_eq!(apple.supporter(), Some(&plate.id));
    assert!(plate.supporter().is_none() && plate.seed != apple.seed);
    let [term] = &description.unrecognized[..] else { panic!("one term") };
    assert_eq!((term.span.start, term.span.end, term.span.text.as_str()), (28, 42, "Flux Capacitor"));
}

#[test]
fn accepted_names_each_violation() {
    for (pointer, value, message) in [
        ("/family", json!("laboratory"), "family"),
        ("/table/model", json!("throne"), "table.model"),
        ("/table/width_m", json!(0.01), "table.width_m is 0.01"),
        ("/objects/0/height_m", json!(-1.0), "objects[0].height_m"),
        ("/objects/0/height_m", json!(1e300), "objects[0].height_m"),
        ("/objects/0/category", json!("happiness"), "objects[0].category"),
        ("/objects/0/material", json!("unobtainium"), "objects[0].material"),
        ("/objects/0/color", json!("white"), "objects[0].color"),
        ("/objects/0/label", json!("a\u{0}b"), "objects[0].label"),
        ("/objects/0/label", json!("x".repeat(1000)), "objects[0].label"),
        ("/objects/1/name", json!("plate_1"), "two objects"),
        ("/objects/1/name", json!("../../etc/passwd"), "no name"),
        ("/objects/1/relations/0/target", json!("cup_9"), "no object's name"),
        ("/objects/1/relations/0/target", json!("apple_1"), "itself"),
        ("/objects/0/relations", json!([{ "kind": "in", "target": "apple_1" }]), "in the end, on itself"),
        ("/objects/0/relations", json!([{ "kind": "at_left", "target": "apple_1" }]), "wrong target"),
        ("/objects/0/relations", json!([{ "kind": "next_to", "target": null }]), "wrong target"),
        ("/objects/0/relations", json!([{ "kind": "hovers", "target": null }]), "unknown variant"),
        ("/objects/0/width_m", json!("wide"), "invalid type"),
    ] {
        let complaint = spoiled(pointer, value.clone());
        assert!(complaint.contains(message), "{pointer} = {value}: {complaint}");
    }
}

#[test]
fn accepted_rejects_too_many_objects() {
    let mut answer = answer();
    let object = answer["objects"][0].clone();
    for number in 2..6 {
        let mut another = object.clone();
        another["name"] = json!(format!("plate_{number}"));
        answer["objects"].as_array_mut().expect("a list").push(another);
    }
    let complaint = read(&answer, &TableSpec::default()).expect_err("too many");
    assert!(complaint.contains("there are 6 objects; at most 4"), "{complaint}");
}

#[test]
fn table_values_of_the_request_override_the_answer() {
    let wanted = TableSpec {
        size_m: Some(DVec3::new(1.0, 1.0, 0.7)),
        model: Some("round_table".into()),
        material: Some("glass".into()),
        ..TableSpec::default()
    };
    let table = read(&answer(), &wanted).expect("holds").table;
    assert_eq!((table.model.as_deref(), table.shape), (Some("round_table"), Some(TableShape::Round)));
    assert_eq!((table.size_m, table.material.as_deref()), (wanted.size_m, Some("glass")));
    let round = TableSpec { shape: Some(TableShape::Round), ..TableSpec::default() };
    assert!(read(&answer(), &round).expect_err("is rectangular").contains("table.model must be a"));
}

#[test]
fn numbered_derives_ids_from_kinds() {
    let ids = numbered(["mug", "plate", "mug", "Mug!", "<b>"].into_iter());
    let names: Vec<&str> = ids.iter().map(InstanceId::as_str).collect();
    assert_eq!(names, ["mug_1", "plate_1", "mug_2", "mug_3", "b_1"]);
}
