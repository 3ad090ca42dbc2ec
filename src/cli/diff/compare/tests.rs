//! One difference at a time, and several together.

use serde_json::{Value, json};

use super::*;

fn object(name: &str, category: &str, x_m: f64) -> Value {
    json!({
        "name": name, "label": category, "category": category, "image": { "bbox_px": [0, 0, 9, 9] },
        "translation_m": [x_m, 0.0, 0.0], "rotation_xyzw": [0.0, 0.0, 0.0, 1.0], "yaw_rad": 0.0,
        "symmetry_order": 1, "scale": [1.0, 1.0, 1.0], "size_m": [0.1, 0.1, 0.1], "mass_kg": 0.3,
        "center_of_mass_m": [0.0, 0.0, 0.05], "inertia_diagonal_kg_m2": [1e-3, 1e-3, 1e-3],
        "principal_axes_xyzw": [0.0, 0.0, 0.0, 1.0], "friction": { "static": 0.5, "dynamic": 0.4 },
        "restitution": 0.2, "support": { "parent": "table", "relation": "on" }, "hulls": 1,
        "mesh": format!("glb/{name}.glb"),
        "provenance": { "mesh_by": "embedded/catalog", "licence": "CC0-1.0", "notes": [] },
    })
}

/// A mug, a book and a can on a table.
fn scene() -> Value {
    json!({
        "format": Scene::FORMAT, "id": "0a1b", "seed": 7,
        "request": { "version": 1, "input": { "kind": "text", "text": "a" }, "seed": 7, "options": {} },
        "frame": { "up": "+z", "handedness": "right", "origin": "center", "units": "meters" },
        "camera": {
            "width_px": 96, "height_px": 72, "fx": 150.0, "fy": 150.0, "cx": 48.0, "cy": 36.0,
            "world_from_camera": { "translation_m": [0.0, -1.0, 1.0], "rotation_xyzw": [1.0, 0.0, 0.0, 0.0] },
        },
        "table": {
            "name": "table", "label": "desk", "shape": "rectangular",
            "outline_m": [[0.5, 0.4], [-0.5, 0.4], [-0.5, -0.4], [0.5, -0.4]], "height_m": 0.7, "model": "desk",
            "size_m": [1.0, 0.8, 0.7], "mass_kg": 20.0, "center_of_mass_m": [0.0, 0.0, -0.3],
            "inertia_diagonal_kg_m2": [1.0, 1.0, 1.0], "principal_axes_xyzw": [0.0, 0.0, 0.0, 1.0],
            "friction": { "static": 0.5, "dynamic": 0.4 }, "restitution": 0.2, "hulls": 5, "mesh": "glb/table.glb",
        },
        "instances": [object("mug_1", "mug", 0.0), object("book_1", "book", 0.2), object("can_1", "can", -0.2)],
        "metrics": { "col_o": 0.0, "col_s": 0.0, "ss": 1.0, "dss_aligned": 0.5, "dss_shipped": 1.0 },
    })
}

fn appearance() -> Appearance {
    Appearance { color: [10, 20, 30], materials: vec!["glaze".to_owned()], triangles: "d1".to_owned() }
}

fn contents(scene: Value) -> SceneContents {
    let scene: Scene = serde_json::from_value(scene).expect("a scene");
    let names = scene.instances.iter().map(|object| object.name.to_string()).chain(["table".to_owned()]);
    let appearances = names.map(|name| (name, appearance())).collect();
    SceneContents { scene, appearances }
}

/// The scene with other values at these pointers.
fn with(values: &[(&str, Value)]) -> Value {
    let mut scene = scene();
    for (pointer, value) in values {
        *scene.pointer_mut(pointer).expect(pointer) = value.clone();
    }
    scene
}

/// The differences of the scene from the same with other values, as JSON without empty lists.
fn difference(values: &[(&str, Value)]) -> Value {
    let found = compare(&contents(scene()), &contents(with(values)));
    let Value::Object(fields) = json!(found) else { panic!("{found:?}") };
    Value::Object(fields.into_iter().filter(|(_, list)| *list != json!([])).collect())
}

#[test]
fn equal_scenes_have_no_difference() {
    assert!(compare(&contents(scene()), &contents(scene())).is_empty());
    // Another id, another request and rounding are no differences.
    for values in [
        [("/id", json!("ffff")), ("/request/input/text", json!("b"))],
        [("/seed", json!(9)), ("/instances/0/mass_kg", json!(0.3 + 1e-14))],
        [("/instances/1/translation_m/0", json!(0.2 + 1e-12)), ("/camera/fx", json!(151.0))],
    ] {
        assert_eq!(difference(&values), json!({}), "{values:?}");
    }
}

#[test]
fn each_property_has_a_change() {
    let changed = |changes: Value| json!({ "changed": [{ "name": "mug_1", "changes": changes }] });
    for (values, expected) in [
        (
            vec![("/instances/0/label", json!("cup"))],
            changed(json!([{ "property": "label", "before": "mug", "after": "cup" }])),
        ),
        (
            vec![("/instances/0/category", json!("cup"))],
            changed(json!([{ "property": "category", "before": "mug", "after": "cup" }])),
        ),
        (
            vec![("/instances/0/name", json!("cup_1"))],
            json!({ "changed": [{ "name": "cup_1", "changes": [
                { "property": "name", "before": "mug_1", "after": "cup_1" },
            ] }] }),
        ),
        (
            vec![("/instances/0/translation_m", json!([0.0, 0.3, 0.4]))],
            changed(json!([{ "property": "pose", "distance_m": 0.5, "angle_rad": 0.0 }])),
        ),
        (
            vec![("/instances/0/size_m/2", json!(0.2)), ("/instances/0/mass_kg", json!(0.6))],
            changed(json!([
                { "property": "size", "before_m": [0.1, 0.1, 0.1], "after_m": [0.1, 0.1, 0.2] },
                { "property": "mass", "before_kg": 0.3, "after_kg": 0.6 },
            ])),
        ),
        (
            vec![("/instances/0/friction/dynamic", json!(0.3)), ("/instances/0/restitution", json!(0.1))],
            changed(json!([
                { "property": "friction", "before": { "static": 0.5, "dynamic": 0.4 },
                  "after": { "static": 0.5, "dynamic": 0.3 } },
                { "property": "restitution", "before": 0.2, "after": 0.1 },
            ])),
        ),
        (
            vec![("/instances/0/support", json!({ "parent": "book_1", "relation": "in" }))],
            changed(json!([{ "property": "support", "before": "on table", "after": "in book_1" }])),
        ),
        (
            vec![("/table/model", json!("oak_desk")), ("/table/outline_m/0", json!([0.6, 0.4]))],
            json!({ "table": [
                { "property": "model", "before": "desk", "after": "oak_desk" },
                { "property": "outline" },
            ] }),
        ),
        (
            vec![("/metrics/dss_aligned", json!(0.75))],
            json!({ "metrics": [{ "name": "dss_aligned", "before": 0.5, "after": 0.75 }] }),
        ),
    ] {
        assert_eq!(difference(&values), expected, "{values:?}");
    }
}

#[test]
fn a_turn_is_measured_in_either_sign_of_the_quaternion() {
    for (angle_rad, sign) in [(1e-6, 1.0), (0.5, 1.0), (0.5, -1.0), (-0.5, 1.0), (std::f64::consts::PI, 1.0)]
    {
        let rotation = [0.0, 0.0, sign * (0.5_f64 * angle_rad).sin(), sign * (0.5_f64 * angle_rad).cos()];
        let found =
            compare(&contents(scene()), &contents(with(&[("/instances/0/rotation_xyzw", json!(rotation))])));
        let [ObjectChange { changes, .. }] = found.changed.as_slice() else { panic!("{found:?}") };
        let [Change::Pose { distance_m, angle_rad: measured_rad }] = changes.as_slice() else {
            panic!("{changes:?}")
        };
        assert_eq!(*distance_m, 0.0);
        assert!((measured_rad - f64::abs(angle_rad)).abs() < 1e-12, "{angle_rad}: {measured_rad}");
    }
}

#[test]
fn colors_materials_and_meshes_come_from_appearances() {
    let mut after = contents(scene());
    let mug =
        Appearance { color: [255, 0, 128], materials: vec!["steel".to_owned()], triangles: "d2".to_owned() };
    after.appearances.insert("mug_1".to_owned(), mug);
    after.appearances.remove("book_1");
    let table = Appearance { color: [10, 20, 31], ..appearance() };
    after.appearances.insert("table".to_owned(), table);
    let found = compare(&contents(scene()), &after);
    let expected = vec![
        Change::Color { before: "#0a141e".to_owned(), after: "#ff0080".to_owned() },
        Change::Materials { before: vec!["glaze".to_owned()], after: vec!["steel".to_owned()] },
        Change::Mesh,
    ];
    assert_eq!(found.changed, [ObjectChange { name: "mug_1".to_owned(), changes: expected }]);
    assert_eq!(found.table, [Change::Color { before: "#0a141e".to_owned(), after: "#0a141f".to_owned() }]);
}

#[test]
fn objects_of_one_scene_are_added_or_removed() {
    let instances =
        json!([object("spoon_1", "spoon", 0.1), object("can_1", "can", -0.2), object("book_2", "book", 0.3)]);
    let found = compare(&contents(scene()), &contents(with(&[("/instances", instances)])));
    let names =
        |objects: &[ObjectSummary]| -> Vec<String> { objects.iter().map(|o| o.name.clone()).collect() };
    assert_eq!(names(&found.added), ["spoon_1", "book_2"]);
    assert_eq!(names(&found.removed), ["mug_1", "book_1"]);
    assert_eq!(found.changed, [], "a book elsewhere under another name is another book");
    assert_eq!(found.added[0].support, "on table");
}
