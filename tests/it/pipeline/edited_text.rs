//! The account of an edited scene is about that scene: nothing in it claims what an edit removed or changed.

use std::path::Path;
use std::process::Command;

use serde_json::{Value, json};

const TEXT: &str = "a teapot to the left of a red mug, a spork, and a bowl with an apple in it";

fn made(folder: &Path, arguments: &[&str]) {
    let done =
        Command::new(env!("CARGO_BIN_EXE_tabletopgen")).args(arguments).current_dir(folder).output().unwrap();
    assert!(done.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&done.stderr));
}

fn json_of(folder: &Path, path: &str) -> Value {
    serde_json::from_str(&std::fs::read_to_string(folder.join(path)).unwrap()).unwrap()
}

/// A scene after operations on another one.
fn edited(folder: &Path, parent: &str, operations: &Value, out: &str) -> Value {
    made(folder, &["edit", "--bundle", parent, "--operations", &operations.to_string(), "--out", out]);
    json_of(folder, &format!("{out}/scene.json"))
}

fn names(scene: &Value) -> Vec<&str> {
    scene["instances"].as_array().unwrap().iter().map(|object| object["name"].as_str().unwrap()).collect()
}

fn marked(scene: &Value) -> Vec<&str> {
    let objects = scene["instances"].as_array().unwrap().iter();
    objects
        .filter(|object| object["stand_in"] == true)
        .map(|object| object["name"].as_str().unwrap())
        .collect()
}

/// Words of the parts that an edit changed, with what was done.
fn changed(scene: &Value) -> Vec<(&str, &str)> {
    let parts = scene["text"]["changed"].as_array().map_or(&[][..], Vec::as_slice).iter();
    parts.map(|part| (part["span"]["text"].as_str().unwrap(), part["by"].as_str().unwrap())).collect()
}

/// Meanings of some kind, as the words of the text.
fn understood<'a>(scene: &'a Value, kind: &str) -> Vec<&'a str> {
    let parts = scene["text"]["understood"].as_array().unwrap().iter().filter(|part| part["kind"] == kind);
    parts.map(|part| part["span"]["text"].as_str().unwrap()).collect()
}

/// Every object that the account names is in the scene, and its stand-ins are the marked ones.
fn assert_is_about_its_scene(scene: &Value) {
    let account = &scene["text"];
    let lists = ["objects", "targets"];
    let parts = account["understood"].as_array().unwrap().iter();
    let named = parts.flat_map(|part| lists.iter().filter_map(|list| part[*list].as_array())).flatten();
    for name in named.filter_map(Value::as_str) {
        assert!(names(scene).contains(&name), "{name} is not in the scene: {account}");
    }
    assert_eq!(account["stand_ins"], json!(marked(scene)));
}

#[test]
fn the_account_of_an_edited_scene_is_about_that_scene() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    made(folder, &["generate", "--text", TEXT, "--seed", "3", "--out", "parent"]);
    let parent = json_of(folder, "parent/scene.json");
    assert_is_about_its_scene(&parent);
    assert_eq!(marked(&parent), ["spork_1"]);
    assert_eq!((parent["text"].get("of_scene"), parent["text"].get("changed")), (None, None));

    let removed = edited(folder, "parent", &json!([{ "op": "remove", "target": "the teapot" }]), "removed");
    assert_is_about_its_scene(&removed);
    assert_eq!(removed["text"]["of_scene"], parent["id"]);
    assert!(!understood(&removed, "object").contains(&"teapot"));
    assert_eq!(understood(&removed, "relation").len() + 1, understood(&parent, "relation").len());
    assert!(changed(&removed).contains(&("teapot", "removed teapot_1")), "{:?}", changed(&removed));
    let report = std::fs::read_to_string(folder.join("removed/report.html")).unwrap();
    assert!(report.contains("Changed by edits") && report.contains("removed teapot_1"));

    let recolored = edited(
        folder,
        "removed",
        &json!([{ "op": "recolor", "target": "mug_1", "color": "blue" }]),
        "recolored",
    );
    assert_is_about_its_scene(&recolored);
    assert!(!understood(&recolored, "property").contains(&"red"));
    assert!(understood(&recolored, "object").contains(&"mug"));
    // The changes of all edits, and the scene of the text.
    let words: Vec<&str> = changed(&recolored).iter().map(|(words, _)| *words).collect();
    assert!(words.contains(&"teapot") && words.contains(&"red"), "{words:?}");
    assert_eq!(recolored["text"]["of_scene"], parent["id"]);

    let replaced = edited(
        folder,
        "parent",
        &json!([
            { "op": "replace", "target": "spork_1", "object": "a plate" },
            { "op": "add", "object": "a dumbbell rack" },
        ]),
        "replaced",
    );
    assert_is_about_its_scene(&replaced);
    assert!(!understood(&replaced, "object").contains(&"spork"));
    assert_eq!(marked(&replaced), ["dumbbell_rack_1"], "an added stand-in is marked, too");
    let rack = replaced["instances"].as_array().unwrap().iter().find(|one| one["stand_in"] == true).unwrap();
    assert_eq!((&rack["stands_for"], &rack["shown_as"]), (&json!("dumbbell rack"), &json!("dish rack")));

    let moved = edited(
        folder,
        "parent",
        &json!([{ "op": "move", "target": "teapot_1", "where": { "relation": "right_of", "target": "mug_1" } }]),
        "moved",
    );
    assert_is_about_its_scene(&moved);
    assert_eq!(understood(&moved, "object"), understood(&parent, "object"));
    assert_eq!(understood(&moved, "relation").len() + 1, understood(&parent, "relation").len());

    made(folder, &["variants", "--bundle", "parent", "--count", "1", "--seed", "7", "--out", "made"]);
    let variant = json_of(folder, "made/variant_0001/scene.json");
    assert_is_about_its_scene(&variant);
    assert_eq!(changed(&variant), [], "a variant keeps what the text states");
    assert_eq!(variant["text"]["understood"], parent["text"]["understood"]);
}

#[test]
fn a_goal_leaves_the_account_with_its_object_and_when_an_edit_reaches_it() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    made(
        folder,
        &[
            "generate",
            "--text",
            "Put the apple in the bowl. There is a mug.",
            "--seed",
            "3",
            "--out",
            "parent",
        ],
    );
    let parent = json_of(folder, "parent/scene.json");
    assert_eq!(parent["text"]["goal"]["predicates"][0]["object"], "apple_1");
    for (operation, keeps_goal) in [
        (json!({ "op": "remove", "target": "mug_1" }), true),
        (json!({ "op": "remove", "target": "apple_1" }), false),
        (
            json!({ "op": "move", "target": "apple_1", "where": { "relation": "in", "target": "bowl_1" } }),
            false,
        ),
    ] {
        let scene = edited(folder, "parent", &json!([operation]), "edited");
        assert_eq!(!scene["text"]["goal"].is_null(), keeps_goal, "{operation}");
        assert_eq!(understood(&scene, "goal").is_empty(), !keeps_goal, "{operation}");
        assert_is_about_its_scene(&scene);
        std::fs::remove_dir_all(folder.join("edited")).unwrap();
    }
}
