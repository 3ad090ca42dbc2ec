//! Types with alternatives, which the contract describes as one object: the description has every field and every word
//! of the type, and values of the type fit it. The same for documents that are composed of parts.

use std::collections::{BTreeMap, BTreeSet};

use batches::{BatchRequest, OutputError, OutputLine, RequestBody, RequestState};
use certificate::{Fidelity, Relaxation};
use datasets::sharing::LeakageRules;
use demonstrations::Randomization;
use scene::predicates::Unmet;
use scene::{EditOperation, Input, Understood};
use schemars::JsonSchema;
use schemars::generate::SchemaSettings;
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::{Value, json};

use crate::harness::contract;

/// Fields of a schema and of all its alternatives, with the words of those that are tags.
type Fields = BTreeMap<String, BTreeSet<String>>;

/// The part of a document that a schema refers to, if it does.
fn resolved<'a>(root: &'a Value, schema: &'a Value) -> &'a Value {
    match schema["$ref"].as_str() {
        Some(target) => resolved(root, root.pointer(target.trim_start_matches('#')).expect(target)),
        None => schema,
    }
}

fn collect(root: &Value, schema: &Value, fields: &mut Fields) {
    let schema = resolved(root, schema);
    for (name, field) in schema["properties"].as_object().into_iter().flatten() {
        let field = resolved(root, field);
        let words = field.get("const").into_iter().chain(field["enum"].as_array().into_iter().flatten());
        let words = words.filter_map(Value::as_str).map(str::to_owned);
        fields.entry(name.clone()).or_default().extend(words);
    }
    for alternatives in ["oneOf", "anyOf", "allOf"] {
        schema[alternatives].as_array().into_iter().flatten().for_each(|part| collect(root, part, fields));
    }
}

/// Fields of a type itself.
fn fields_of_type<T: JsonSchema>() -> Fields {
    let generator = SchemaSettings::draft2020_12().for_serialize().into_generator();
    let schema = serde_json::to_value(generator.into_root_schema_for::<T>()).expect("a schema is JSON");
    let mut fields = Fields::new();
    collect(&schema, &schema, &mut fields);
    fields
}

/// Compares a type with the schema of its name, whose tags are these fields, and then values with it.
fn compare<T: JsonSchema + DeserializeOwned + Serialize>(tags: &[&str], values: &[Value]) {
    let name = T::schema_name();
    let mut described = Fields::new();
    collect(contract::document(), contract::schema(&name), &mut described);
    let of_type = fields_of_type::<T>();
    let names = |fields: &Fields| fields.keys().cloned().collect::<BTreeSet<_>>();
    assert_eq!(names(&described), names(&of_type), "fields of {name}");
    for tag in tags {
        assert_eq!(described[*tag], of_type[*tag], "words of {tag} of {name}");
    }
    let mut met = BTreeSet::new();
    for value in values {
        let read: T = serde_json::from_value(value.clone()).unwrap_or_else(|why| panic!("{value}: {why}"));
        let written = serde_json::to_value(read).expect("JSON");
        contract::hold_schema(&name, &written);
        met.extend(tags.first().and_then(|tag| written[*tag].as_str().map(str::to_owned)));
    }
    if let Some(tag) = tags.first() {
        assert_eq!(met, of_type[*tag], "a value of each alternative of {name}");
    }
}

#[test]
fn operations_of_edits_are_those_of_the_type() {
    let place = json!({
        "relation": "between", "target": "a", "second_target": "b", "distance_m": 0.1, "yaw_rad": 0.5,
    });
    let operations = [
        json!({ "op": "add", "object": "a mug", "count": 2, "where": { "position_m": [0.1, -0.2] } }),
        json!({ "op": "remove", "target": "mug_1", "with_contents": true }),
        json!({ "op": "replace", "target": "mug_1", "object": "a bowl" }),
        json!({ "op": "move", "target": "mug_1", "where": place }),
        json!({ "op": "move", "target": "mug_1", "where": { "offset_m": [0.1, 0.0] } }),
        json!({ "op": "rotate", "target": "mug_1", "by_rad": 0.5 }),
        json!({ "op": "rotate", "target": "mug_1", "to_rad": 0.5 }),
        json!({ "op": "rotate", "target": "mug_1", "facing": "bowl_1" }),
        json!({ "op": "resize", "target": "mug_1", "factor": 1.5 }),
        json!({ "op": "recolor", "target": "mug_1", "color": "red", "material": "glass" }),
        json!({ "op": "relabel", "target": "mug_1", "label": "cup" }),
        json!({ "op": "restyle_table", "material": "oak", "color": "white" }),
        json!({ "op": "stack", "targets": ["book_1", "book_2"] }),
        json!({ "op": "swap", "targets": ["book_1", "book_2"] }),
        json!({ "op": "arrange", "targets": ["the books"], "arrangement": "row", "sort_by": "size", "where": { "relation": "at_left" } }),
        json!({ "op": "tidy" }),
        json!({ "op": "clutter", "count": 3, "theme": "hobby_desk" }),
        json!({ "op": "remake", "target": "mug_1" }),
        json!({ "op": "rearrange" }),
        json!({ "op": "set_physics", "target": "mug_1", "mass_factor": 2.0, "friction_factor": 0.5 }),
        json!({ "op": "relight", "azimuth_rad": 0.5, "elevation_rad": 1.0, "intensity": 1.5 }),
        json!({ "op": "move_camera", "turn_rad": 0.1, "raise_rad": 0.1, "distance_factor": 2.0, "focal_factor": 2.0 }),
    ];
    compare::<EditOperation>(&["op"], &operations);
    let words = &contract::schema("EditRelation")["enum"];
    for word in words.as_array().expect("a list") {
        serde_json::from_value::<scene::RelationKind>(word.clone()).expect("a relation");
    }
}

#[test]
fn sources_of_scenes_are_those_of_the_type() {
    let digest = "0".repeat(64);
    let sources = [
        json!({ "kind": "text", "text": "a mug" }),
        json!({ "kind": "image", "sha256": digest, "media_type": "image/png", "text": "a mug" }),
        json!({
            "kind": "edit", "parent": "5ce9e", "bundle_sha256": digest, "operations": [{ "op": "tidy" }],
            "text": "tidy up",
        }),
        json!({ "kind": "variant", "parent": "5ce9e", "bundle_sha256": digest, "randomize": { "layout": true } }),
    ];
    compare::<Input>(&["kind"], &sources);
}

#[test]
fn parts_of_texts_are_those_of_the_type() {
    let understood = |mut meaning: Value| {
        meaning["span"] = json!({ "start": 0, "end": 5, "text": "a mug" });
        meaning
    };
    let meanings = [
        json!({ "kind": "object", "category": "mug", "objects": ["mug_1"] }),
        json!({ "kind": "property", "property": "color", "value": "red", "objects": ["mug_1"] }),
        json!({ "kind": "relation", "relation": "left_of", "objects": ["mug_1"], "targets": ["bowl_1"] }),
        json!({ "kind": "arrangement", "index": 0, "objects": ["mug_1", "mug_2"] }),
        json!({ "kind": "exclusion", "categories": ["knife"] }),
        json!({ "kind": "goal", "index": 0 }),
        json!({ "kind": "table" }),
        json!({ "kind": "theme", "theme": "hobby_desk" }),
        json!({ "kind": "completion", "complete": true }),
        json!({ "kind": "correction", "corrected": "mug" }),
    ];
    compare::<Understood>(&["kind"], &meanings.map(understood));
    let unmet = |mut demand: Value| {
        demand["objects"] = json!(["mug_1"]);
        demand
    };
    let relation =
        json!({ "kind": "relation", "relation": "left_of", "targets": ["bowl_1"], "distance_m": 0.1 });
    let arrangement = |form: &str| json!({ "kind": "arrangement", "index": 0, "arrangement": form });
    let mut demands = vec![
        relation,
        json!({ "kind": "arrangement", "index": 0, "arrangement": "grid", "columns": 2 }),
        json!({ "kind": "yaw", "yaw_rad": 0.5 }),
        json!({ "kind": "position", "x_m": 0.1, "y_m": 0.2 }),
    ];
    demands.extend(["row", "column", "circle", "pile", "pyramid"].map(arrangement));
    let demands: Vec<Value> = demands.into_iter().map(unmet).collect();
    compare::<Unmet>(&["kind", "arrangement"], &demands);
}

#[test]
fn findings_of_scenes_are_those_of_the_type() {
    let relaxations = [
        json!({ "name": "mug_1", "outcome": "shrunk", "scale": 0.9 }),
        json!({ "name": "mug_1", "outcome": "moved", "from": "tray_1" }),
    ];
    compare::<Relaxation>(&["outcome"], &relaxations);
    let regions = json!({
        "share": 0.1, "largest": [{ "body": "mug_1", "bbox_px": [0, 0, 9, 9], "image_share": 0.01 }],
    });
    let fidelity = json!({
        "is_judged": true, "silhouette_iou": 0.9, "color_difference": 3.0, "left_out_px": [[0, 0, 9, 9]],
        "missed": regions, "invented": regions,
        "methods": [{ "method": "category", "objects": 1, "share": 1.0 }],
        "appearance": { "extractor": "embedded/classical", "model": "1", "similarity": 0.9 },
    });
    compare::<Fidelity>(&[], &[fidelity]);
    let metrics = scene::Metrics { col_o: 0.0, col_s: 0.0, ss: 1.0, dss_aligned: 1.0, dss_shipped: 1.0 };
    contract::hold_schema("Metrics", &json!(metrics));
}

#[test]
fn lines_of_batches_are_those_of_the_type() {
    let request = BatchRequest {
        custom_id: "r1".to_owned(),
        body: RequestBody {
            text: Some("a mug".to_owned()),
            image: None,
            seed: Some(7),
            labels: [("set".to_owned(), "a1".to_owned())].into(),
            ..RequestBody::default()
        },
    };
    contract::hold_schema("BatchRequestLine", &json!(request));
    let line = OutputLine {
        custom_id: Some("r1".to_owned()),
        scene_id: Some("0192f3a4-5b6c-7d8e-9fa0-b1c2d3e4f5a6".to_owned()),
        state: RequestState::Failed,
        verdict: Some("pass".to_owned()),
        bundle: Some("/scenes/0192f3a4-5b6c-7d8e-9fa0-b1c2d3e4f5a6/bundle".to_owned()),
        error: Some(OutputError {
            column: Some(3),
            ..OutputError::new("failed", "why").on_line(2).at("/body")
        }),
        stages_s: 1.5,
        attempts: 1,
        duplicate_of: Some("r0".to_owned()),
    };
    contract::hold_schema("BatchResult", &json!(line));
}

#[test]
fn lists_of_words_are_those_of_the_types() {
    let words = |name: &str| -> BTreeSet<String> {
        let words = contract::schema(name)["enum"].as_array().expect(name);
        words.iter().map(|word| word.as_str().expect("a word").to_owned()).collect()
    };
    let rules = json!(LeakageRules::ALL);
    let kinds: BTreeSet<String> = rules.as_object().expect("an object").keys().cloned().collect();
    assert_eq!(words("SharingKind"), kinds);
    for name in words("UsualRandomization") {
        assert!(Randomization::named(&name).is_some(), "{name}");
    }
}
