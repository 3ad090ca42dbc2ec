//! Tests of the validation of deserialized requests, recognitions and scenes.

use serde::de::DeserializeOwned;
use serde_json::{Value, json};

use super::request::RequestOptions;
use super::{Input, Recognition, Scene, SceneRequest};

/// A change of a JSON document: pointer, new value, and the pointer that the error must name.
type Case = (&'static str, Value, &'static str);

/// Every case must be rejected with an error that names the field; the unchanged document must be accepted.
fn check<T: DeserializeOwned + std::fmt::Debug>(valid: &Value, cases: &[Case]) {
    let parsed: Result<T, _> = serde_json::from_value(valid.clone());
    parsed.expect("the unchanged document is valid");
    for (pointer, value, field) in cases {
        let mut document = valid.clone();
        *document.pointer_mut(pointer).unwrap_or_else(|| panic!("no {pointer}")) = value.clone();
        let error = serde_json::from_value::<T>(document).expect_err(&format!("{pointer} = {value}"));
        assert!(error.to_string().contains(&format!("{field}: ")), "{pointer} = {value}: {error}");
    }
}

fn request() -> Value {
    json!({
        "version": 1,
        "input": { "kind": "text", "text": "a mug" },
        "seed": 7,
        "options": {
            "table": { "size_m": [1.2, 0.8, 0.75], "model": "desk", "color": "red" },
            "metric_anchor": { "object": "mug", "width_m": 0.09 },
            "max_objects": 8,
            "budget_usd": 1.5,
            "robot": "panda",
            "clutter": { "density": 0.6 },
            "set": { "dro.seed": "1" },
        },
    })
}

#[test]
fn scene_request_rejects_values_out_of_range() {
    check::<SceneRequest>(
        &request(),
        &[
            ("/version", json!(SceneRequest::VERSION + 1), "/version"),
            ("/seed", json!(1_u64 << 53), "/seed"),
            ("/options/max_objects", json!(0), "/options/max_objects"),
            ("/options/max_objects", json!(65), "/options/max_objects"),
            ("/options/budget_usd", json!(-0.1), "/options/budget_usd"),
            ("/options/budget_usd", json!(10_001), "/options/budget_usd"),
            ("/options/metric_anchor/width_m", json!(0), "/options/metric_anchor/width_m"),
            ("/options/metric_anchor/object", json!(""), "/options/metric_anchor/object"),
            ("/options/table/size_m/0", json!(-1.2), "/options/table/size_m/0"),
            ("/options/table/size_m/2", json!(9), "/options/table/size_m/2"),
            ("/options/table/model", json!(""), "/options/table/model"),
            ("/options/robot", json!(""), "/options/robot"),
            ("/options/clutter/density", json!(-0.1), "/options/clutter/density"),
            ("/options/clutter/density", json!(1.5), "/options/clutter/density"),
            ("/options/set", json!({ "a": "x".repeat(1001) }), "/options/set"),
        ],
    );
}

/// Workers of an earlier version do not know the option, and leave such a request to others.
#[test]
fn a_request_for_a_robot_has_a_newer_version() {
    let input = || Input::Text { text: "a mug".into() };
    let of = |robot: Option<&str>| {
        let options = RequestOptions { robot: robot.map(str::to_owned), ..RequestOptions::default() };
        SceneRequest::new(input(), 7, options)
    };
    assert_eq!((of(None).version, of(Some("panda")).version), (1, 3));
    let stored = serde_json::to_value(of(None)).expect("JSON");
    assert_eq!(stored["options"], json!({}));
}

#[test]
fn a_request_for_clutter_has_a_newer_version() {
    let options: RequestOptions =
        serde_json::from_value(json!({ "clutter": { "density": 0.5 } })).expect("options");
    assert_eq!(SceneRequest::new(Input::Text { text: "a mug".into() }, 7, options).version, 4);
}

fn recognized(id: &str, stands_on: Value) -> Value {
    json!({
        "id": id, "label": id, "category": "mug", "size_m": [0.1, 0.1, 0.1], "color": null, "material": null,
        "seed": 1, "stands_on": stands_on,
    })
}

fn camera() -> Value {
    json!(geometry::Camera {
        width_px: 64,
        height_px: 48,
        fx: 60.0,
        fy: 60.0,
        cx: 32.0,
        cy: 24.0,
        world_from_camera: geometry::Pose::IDENTITY,
    })
}

#[test]
fn recognition_rejects_invalid_names_sizes_and_supports() {
    let on = |id: &str| json!({ "kind": "on", "object": id });
    let valid = json!({
        "camera": camera(),
        "camera_is": "known",
        "table": {
            "label": "table", "shape": "round", "model": "desk", "size_m": [1, 1, 0.7], "color": null,
            "material": null, "seed": 1,
        },
        "objects": [
            recognized("plate_1", json!({ "kind": "table" })),
            recognized("mug_1", on("plate_1")),
            recognized("spoon_1", json!({ "kind": "in", "object": "mug_1" })),
        ],
    });
    check::<Recognition>(
        &valid,
        &[
            ("/table/size_m/2", json!(0), "/table/size_m"),
            ("/objects/1/size_m/0", json!(-0.1), "/objects/1/size_m"),
            ("/objects/1/id", json!("plate_1"), "/objects/1/id"),
            ("/objects/2/id", json!("table"), "/objects/2/id"),
            ("/objects/1/stands_on", on("mug_1"), "/objects/1/stands_on"),
            ("/objects/0/stands_on", on("spoon_1"), "/stands_on"),
            ("/objects/0/stands_on", on("jug_1"), "/objects/0/stands_on"),
        ],
    );
}

#[test]
fn support_height_is_the_sum_of_the_supporters_heights() {
    let on = |id: &str| json!({ "kind": "on", "object": id });
    let mut recognition: Recognition = serde_json::from_value(json!({
        "camera": camera(),
        "camera_is": "known",
        "table": {
            "label": "table", "shape": "round", "model": "desk", "size_m": [1, 1, 0.7], "color": null,
            "material": null, "seed": 1,
        },
        "objects": [
            recognized("spoon_1", json!({ "kind": "in", "object": "mug_1" })),
            recognized("mug_1", on("plate_1")),
            recognized("plate_1", json!({ "kind": "table" })),
        ],
    }))
    .expect("a valid recognition");
    recognition.objects[2].size_m.z = 0.25;
    let supports = recognition.support_tree().expect("a tree");
    let heights_m = [0, 1, 2].map(|index| recognition.support_height_m(&supports, index));
    assert_eq!(heights_m, [0.35, 0.25, 0.0]);
}

fn instance(name: &str, parent: &str) -> Value {
    json!({
        "name": name, "label": name, "category": "mug", "image": { "bbox_px": [0, 0, 1, 1] },
        "translation_m": [0, 0, 0], "rotation_xyzw": [0, 0, 0, 1], "yaw_rad": 0, "symmetry_order": 1,
        "scale": [1, 1, 1], "size_m": [0.1, 0.1, 0.1], "mass_kg": 0.3, "center_of_mass_m": [0, 0, 0.05],
        "inertia_diagonal_kg_m2": [1e-4, 1e-4, 1e-4], "principal_axes_xyzw": [0, 0, 0, 1],
        "friction": { "static": 0.6, "dynamic": 0.5 }, "restitution": 0.1,
        "support": { "parent": parent, "relation": "on" }, "hulls": 1, "mesh": "glb/a.glb",
        "provenance": { "mesh_by": "embedded/catalog", "licence": "CC0-1.0", "notes": [] },
    })
}

#[test]
fn scene_rejects_invalid_names_sizes_and_supports() {
    let valid = json!({
        "format": "tabletopgen-scene/1",
        "id": "0a1b",
        "seed": 7,
        "request": request(),
        "frame": super::finished::Frame::world(),
        "camera": camera(),
        "table": {
            "name": "table", "label": "a desk", "shape": "rectangular",
            "outline_m": [[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]], "height_m": 0.7, "model": "desk",
            "size_m": [1, 1, 0.7], "mass_kg": 20, "center_of_mass_m": [0, 0, -0.3],
            "inertia_diagonal_kg_m2": [1, 1, 1], "principal_axes_xyzw": [0, 0, 0, 1],
            "friction": { "static": 0.6, "dynamic": 0.5 }, "restitution": 0.1, "hulls": 5,
            "mesh": "glb/table.glb",
        },
        "instances": [instance("plate_1", "table"), instance("mug_1", "plate_1")],
        "metrics": { "col_o": 0, "col_s": 0, "ss": 1, "dss_aligned": 1, "dss_shipped": 1 },
    });
    check::<Scene>(
        &valid,
        &[
            ("/format", json!("tabletopgen-scene/2"), "/format"),
            ("/request/seed", json!(1_u64 << 53), "/seed"),
            ("/table/size_m/0", json!(0), "/table/size_m"),
            ("/instances/1/size_m/1", json!(0), "/instances/1/size_m"),
            ("/instances/1/name", json!("plate_1"), "/instances/1/name"),
            ("/instances/0/name", json!("table"), "/instances/0/name"),
            ("/instances/0/support/parent", json!("mug_1"), "/support/parent"),
            ("/instances/1/support/parent", json!("jug_1"), "/instances/1/support/parent"),
        ],
    );
    let scene: Scene = serde_json::from_value(valid).expect("valid");
    let again: Scene =
        serde_json::from_str(&serde_json::to_string(&scene).expect("serializes")).expect("valid");
    assert_eq!(again, scene);
}
