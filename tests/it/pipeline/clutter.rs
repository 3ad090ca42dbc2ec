//! Clutter: objects without a stated place lie as they fell, in a scene that its certificate passes.

use std::path::Path;
use std::process::Command;

use serde_json::{Value, json};

const TEXT: &str = "a desk with an apple, a banana, a book, a mug, a pen, a tape dispenser, and a plate with an orange on it";

fn made(folder: &Path, arguments: &[&str]) -> Value {
    let done = Command::new(env!("CARGO_BIN_EXE_tabletopgen"))
        .args(arguments)
        .args(["--data-dir", "data", "--json"])
        .current_dir(folder)
        .output()
        .unwrap();
    assert!(done.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&done.stderr));
    serde_json::from_slice(&done.stdout).expect("is JSON")
}

fn read(folder: &Path, path: &str) -> Value {
    serde_json::from_slice(&std::fs::read(folder.join(path)).unwrap()).unwrap()
}

fn instance<'a>(scene: &'a Value, name: &str) -> &'a Value {
    let instances = scene["instances"].as_array().unwrap();
    instances.iter().find(|object| object["name"] == name).unwrap_or_else(|| panic!("no {name}"))
}

fn stage<'a>(document: &'a Value, name: &str) -> Option<&'a Value> {
    document["stages"].as_array().unwrap().iter().find(|stage| stage["stage"] == name)
}

#[test]
fn objects_without_a_stated_place_lie_as_they_fell_and_the_certificate_passes() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let text = ["generate", "--text", TEXT, "--seed", "4"];
    let plain = made(folder, &[&text[..], &["--out", "plain"]].concat());
    let heaped = made(folder, &[&text[..], &["--clutter", "0.8", "--out", "heaped"]].concat());
    assert!(stage(&plain, "clutter").is_none());
    assert_eq!(stage(&heaped, "clutter").expect("a stage")["found"], 0);
    assert_eq!(stage(&heaped, "resolve").expect("a stage")["found"], 1, "only the drop is new");

    let (before, scene, report) = (
        read(folder, "plain/scene.json"),
        read(folder, "heaped/scene.json"),
        read(folder, "heaped/report.json"),
    );
    assert_eq!((&report["verdict"], &scene["metrics"]["col_s"]), (&json!("pass"), &json!(0.0)));
    assert_eq!((&scene["metrics"]["ss"], &scene["metrics"]["dss_shipped"]), (&json!(1.0), &json!(1.0)));
    assert_eq!(
        (&scene["request"]["version"], &scene["request"]["options"]["clutter"]["density"]),
        (&json!(4), &json!(0.8))
    );
    assert_eq!(report["fidelity"]["is_judged"], false);
    let clutter = &report["clutter"];
    assert_eq!((clutter, &clutter["density"]), (&scene["clutter"], &json!(0.8)));
    let placement = |name: &str| {
        let objects = clutter["objects"].as_array().unwrap();
        objects.iter().find(|object| object["name"] == name).unwrap()["placement"].clone()
    };
    // The text demands a place for these two, and the others leave theirs.
    for name in ["plate_1", "orange_1"] {
        assert_eq!(placement(name), "kept");
        let moved_m: Vec<f64> = (0..2)
            .map(|k| {
                let at = |scene: &Value| instance(scene, name)["translation_m"][k].as_f64().unwrap();
                (at(&scene) - at(&before)).abs()
            })
            .collect();
        assert!(moved_m.iter().all(|moved_m| *moved_m < 0.006), "{name} {moved_m:?}");
    }
    for name in ["apple_1", "banana_1", "book_1", "mug_1", "pen_1"] {
        assert_ne!(placement(name), "kept", "{name}");
        assert_ne!(instance(&scene, name)["translation_m"], instance(&before, name)["translation_m"]);
    }
    assert_eq!(instance(&scene, "orange_1")["support"]["parent"], "plate_1");
    assert_eq!(scene["text"].get("unmet"), before["text"].get("unmet"));
    let covered = clutter["covered_share"].as_f64().unwrap();
    assert!((0.1..=1.0).contains(&covered), "{covered}");
    assert!(plain["summary"].get("clutter").is_none() && before.get("clutter").is_none());
    assert!(std::fs::read_to_string(folder.join("heaped/report.html")).unwrap().contains("Clutter"));

    // Equal requests have equal bytes, and another density gives another scene.
    let again = ["--clutter", "0.8", "--out", "again", "--data-dir", "other"];
    let done = Command::new(env!("CARGO_BIN_EXE_tabletopgen"))
        .args([&text[..], &again].concat())
        .current_dir(folder)
        .status()
        .unwrap();
    assert!(done.success());
    let manifest = |bundle: &str| std::fs::read(folder.join(bundle).join("manifest.json")).unwrap();
    assert_eq!(manifest("heaped"), manifest("again"));
    made(folder, &[&text[..], &["--clutter", "0", "--out", "spread"]].concat());
    let spread = read(folder, "spread/scene.json");
    assert!(spread["clutter"]["covered_share"].as_f64().unwrap() < covered, "{}", spread["clutter"]);

    // What an edit names is no longer where it fell, and all else is.
    let operations = json!([{ "op": "move", "target": "orange_1", "where": { "relation": "at_back_left" } },
                            { "op": "remove", "target": "pen_1" }]);
    made(folder, &["edit", "--bundle", "spread", "--operations", &operations.to_string(), "--out", "edited"]);
    let edited = read(folder, "edited/scene.json");
    let names: Vec<&str> = edited["clutter"]["objects"]
        .as_array()
        .unwrap()
        .iter()
        .filter_map(|object| object["name"].as_str())
        .collect();
    assert!(names.contains(&"apple_1") && !names.contains(&"pen_1"), "{names:?}");
}

#[test]
fn a_density_out_of_range_is_refused() {
    for density in ["-0.1", "1.5", "many"] {
        let done = Command::new(env!("CARGO_BIN_EXE_tabletopgen"))
            .args(["generate", "--text", "a mug", "--clutter", density])
            .output()
            .unwrap();
        assert_eq!(done.status.code(), Some(2));
        let words = String::from_utf8_lossy(&done.stderr).into_owned();
        assert!(words.contains("a number from 0 to 1"), "{words}");
    }
}
