//! `evaluate`: scenes beside the images that they were made from.

use serde_json::{Value, json};

use super::commands::{run, text};

/// Narrow networks of the same form, with weights by chance: what their numbers are says nothing of the scene.
fn narrow_weights(folder: &std::path::Path) {
    std::fs::create_dir_all(folder.join("lpips")).unwrap();
    for name in ["backbone", "linear_layers"] {
        let file = format!("{name}.safetensors");
        let golden = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/golden/lpips/alexnet");
        std::fs::copy(format!("{golden}/{file}"), folder.join("lpips").join(file)).unwrap();
    }
}

#[test]
fn a_scene_has_numbers_by_the_weights_that_are_there_and_names_the_files_that_are_not() {
    let home = tempfile::tempdir().unwrap();
    let made = run(home.path(), &["generate", "--text", "a mug on a desk", "--seed", "3", "--out", "desk"]);
    assert_eq!(made.status.code(), Some(0), "{}", text(&made.stderr));
    narrow_weights(&home.path().join("weights"));
    let scenes = json!({ "scenes": [
        { "name": "with image", "bundle": "desk", "image": "desk/preview/hero.png" },
        { "name": "without", "bundle": "desk" },
    ] });
    std::fs::write(home.path().join("scenes.json"), scenes.to_string()).unwrap();
    let arguments = [
        "evaluate",
        "scenes.json",
        "--weights",
        "weights",
        "--out",
        "table.json",
        "--csv",
        "table.csv",
        "--html",
        "table.html",
    ];
    let output = run(home.path(), &arguments);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let printed = text(&output.stdout);
    assert!(
        printed.contains("LPIPS   best view") && printed.contains("clip/config.json is not in the folder"),
        "{printed}"
    );

    let table: Value =
        serde_json::from_slice(&std::fs::read(home.path().join("table.json")).unwrap()).unwrap();
    let weights = table["protocol"]["weights"].as_array().unwrap();
    assert_eq!((weights.len(), table["protocol"]["views"].as_u64()), (2, Some(160)));
    let lpips = &table["means"]["lpips"];
    assert_eq!((lpips["scenes"].as_u64(), &table["means"]["clip"]), (Some(1), &Value::Null));
    assert!(lpips["best"].as_f64() < lpips["mean"].as_f64(), "{lpips}");
    assert_eq!(table["scenes"][1]["scores"], Value::Null);
    assert_eq!(table["means"]["physics"]["scenes"], 2);
    let csv = std::fs::read_to_string(home.path().join("table.csv")).unwrap();
    assert_eq!(csv.lines().count(), 4, "{csv}");
    assert!(std::fs::read_to_string(home.path().join("table.html")).unwrap().contains("dinov2/config.json"));

    let again = run(home.path(), &arguments);
    assert_eq!(again.status.code(), Some(2), "an earlier table was replaced");
}

#[test]
fn lists_of_scenes_that_will_not_do_are_refused_by_name() {
    let home = tempfile::tempdir().unwrap();
    for (scenes, says) in [
        (json!({ "scenes": [] }), "lists no scene"),
        (
            json!({ "scenes": [{ "name": "a", "bundle": "x" }, { "name": "a", "bundle": "y" }] }),
            "two scenes \"a\"",
        ),
        (json!({ "scenes": [{ "name": "a", "bundle": "missing" }] }), "missing"),
        (json!({ "scenes": [{ "name": "a", "bundle": "x", "picture": "y" }] }), "unknown field"),
    ] {
        std::fs::write(home.path().join("scenes.json"), scenes.to_string()).unwrap();
        let output = run(home.path(), &["evaluate", "scenes.json", "--out", "table.json"]);
        let complaint = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{complaint}");
        assert!(complaint.contains(says), "{complaint}");
        assert!(!home.path().join("table.json").exists());
    }
}
