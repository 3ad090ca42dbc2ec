//! Edits of a finished scene: what is asked for happens, and everything else stays exactly where it is.

use std::path::Path;
use std::process::{Command, Output};

use serde_json::{Value, json};

const TEXT: &str = "a laptop, a red mug, a bowl with two apples in it, and three books";

fn tabletopgen(folder: &Path, arguments: &[&str]) -> Output {
    let program = env!("CARGO_BIN_EXE_tabletopgen");
    Command::new(program).args(arguments).current_dir(folder).output().unwrap()
}

fn made(folder: &Path, arguments: &[&str]) {
    let done = tabletopgen(folder, arguments);
    assert!(done.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&done.stderr));
}

fn scene(folder: &Path, bundle: &str) -> Value {
    let text = std::fs::read_to_string(folder.join(bundle).join("scene.json")).unwrap();
    serde_json::from_str(&text).unwrap()
}

fn instance<'a>(scene: &'a Value, name: &str) -> Option<&'a Value> {
    scene["instances"].as_array().unwrap().iter().find(|object| object["name"] == name)
}

fn pose(scene: &Value, name: &str) -> (Value, Value) {
    let object = instance(scene, name).unwrap_or_else(|| panic!("no {name}"));
    (object["translation_m"].clone(), object["rotation_xyzw"].clone())
}

#[test]
fn an_edit_does_what_it_states_and_leaves_every_other_object_exactly_in_place() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    made(folder, &["generate", "--text", TEXT, "--seed", "3", "--out", "parent"]);
    let operations = json!([
        { "op": "move", "target": "the red mug", "where": { "relation": "left_of", "target": "laptop_1" } },
        { "op": "add", "object": "a spoon", "where": { "relation": "in", "target": "mug_1" } },
        { "op": "remove", "target": "book_3" },
        { "op": "recolor", "target": "bowl_1", "color": "blue" },
    ]);
    let edit = ["edit", "--bundle", "parent", "--operations", &operations.to_string(), "--seed", "5"];
    made(folder, &[&edit[..], &["--out", "child"]].concat());
    let (before, after) = (scene(folder, "parent"), scene(folder, "child"));

    let x = |scene: &Value, name: &str| pose(scene, name).0[0].as_f64().unwrap();
    assert!(x(&after, "mug_1") < x(&after, "laptop_1"));
    let spoon = instance(&after, "spoon_1").expect("a new object");
    assert_eq!(spoon["support"], json!({ "parent": "mug_1", "relation": "in" }));
    assert!(instance(&after, "book_3").is_none());
    let moved: Vec<&str> =
        after["edit"]["moved"].as_array().unwrap().iter().filter_map(|m| m["name"].as_str()).collect();
    for object in before["instances"].as_array().unwrap() {
        let name = object["name"].as_str().unwrap();
        if !["mug_1", "book_3"].contains(&name) && !moved.contains(&name) {
            assert_eq!(pose(&before, name), pose(&after, name), "{name}");
        }
    }
    assert_eq!(after["metrics"]["col_s"], 0.0);
    assert_eq!(after["edit"]["parent"], before["id"]);
    assert_eq!(after["request"]["input"]["kind"], "edit");
    assert_ne!(after["id"], before["id"]);

    // The prediction of a part that needs no new object is what the edit did.
    let predicted = tabletopgen(folder, &[&edit[..], &["--dry-run"]].concat());
    let predicted: Value = serde_json::from_slice(&predicted.stdout).expect("is JSON");
    assert_eq!(predicted["prediction"]["undetermined"], json!([1]), "{predicted}");
    let ops = predicted["prediction"]["operations"].as_array().unwrap().iter().map(|done| &done["op"]);
    assert_eq!(ops.collect::<Vec<_>>(), ["move", "remove", "recolor"]);
    let difference = tabletopgen(folder, &["diff", "parent", "child", "--json"]);
    assert_eq!(difference.status.code(), Some(1));
    let difference: Value = serde_json::from_slice(&difference.stdout).expect("is JSON");
    let difference = &difference["difference"];
    assert_eq!(
        (&difference["added"][0]["name"], &difference["removed"][0]["name"]),
        (&json!("spoon_1"), &json!("book_3"))
    );
    let properties = |name: &str| -> Vec<&Value> {
        let changed =
            difference["changed"].as_array().unwrap().iter().filter(|object| object["name"] == name);
        changed
            .flat_map(|object| object["changes"].as_array().unwrap())
            .map(|change| &change["property"])
            .collect()
    };
    assert!(properties("mug_1").contains(&&json!("pose")), "{difference}");
    assert!(properties("bowl_1").contains(&&json!("color")), "{difference}");
    assert_eq!(properties("laptop_1"), [] as [&Value; 0]);

    // The same edit gives the same bytes, and its scene can be edited again.
    made(folder, &[&edit[..], &["--out", "again"]].concat());
    let manifest = |bundle: &str| std::fs::read(folder.join(bundle).join("manifest.json")).unwrap();
    assert_eq!(manifest("child"), manifest("again"));
    let next = json!([{ "op": "move", "target": "bowl_1", "where": { "relation": "at_back_right" } }]);
    made(folder, &["edit", "--bundle", "child", "--operations", &next.to_string(), "--out", "grandchild"]);
    let last = scene(folder, "grandchild");
    let apples: Vec<&str> = last["edit"]["moved"]
        .as_array()
        .unwrap()
        .iter()
        .filter_map(|moved| moved["name"].as_str())
        .filter(|name| name.starts_with("apple"))
        .collect();
    assert_eq!(apples, ["apple_1", "apple_2"], "what is in the bowl moves with it, and this is reported");
}

/// Objects change places, stand in a sorted row, get one new object each, and half of them leave.
#[test]
fn an_instruction_in_words_swaps_lines_up_and_gives_one_to_each() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let text = "A large table with two plates, a lamp at the back left, a vase at the front right, and four dice, and nothing else";
    made(folder, &["generate", "--text", text, "--seed", "4", "--out", "parent"]);
    let edit = |parent: &str, text: &str, out: &str| {
        made(folder, &["edit", "--bundle", parent, "--text", text, "--seed", "5", "--out", out]);
        scene(folder, out)
    };
    let before = scene(folder, "parent");
    let at = |scene: &Value, name: &str| -> [f64; 2] {
        let place = pose(scene, name).0;
        [0, 1].map(|axis| place[axis].as_f64().unwrap())
    };
    let apart_m = |a: [f64; 2], b: [f64; 2]| (a[0] - b[0]).hypot(a[1] - b[1]);

    let swapped = edit("parent", "Could you swap the vase and the lamp?", "swapped");
    let (lamp, vase) = ("desk_lamp_1", "vase_1");
    assert!(apart_m(at(&swapped, vase), at(&before, lamp)) < 0.15, "{swapped}");
    assert!(apart_m(at(&swapped, lamp), at(&before, vase)) < 0.15);

    let row = edit(
        "swapped",
        "line the dice up along the front edge, and a fork to the left of every plate",
        "row",
    );
    let mut dice: Vec<[f64; 2]> = (1..=4).map(|k| at(&row, &format!("dice_{k}"))).collect();
    dice.sort_by(|a, b| a[0].total_cmp(&b[0]));
    for pair in dice.windows(2) {
        assert!((pair[0][1] - pair[1][1]).abs() < 0.01 && pair[1][0] - pair[0][0] > 0.005, "{dice:?}");
    }
    for fork in ["fork_1", "fork_2"] {
        let fork = at(&row, fork);
        assert!(["plate_1", "plate_2"].iter().any(|plate| fork[0] < at(&row, plate)[0]), "{row}");
    }

    let fewer =
        edit("row", "half of the dice can go; move vase_1 10 cm to the right and color it red", "fewer");
    let left = (1..=4).filter(|k| instance(&fewer, &format!("dice_{k}")).is_some()).count();
    assert_eq!(left, 2);
    let operations = fewer["edit"]["operations"].as_array().unwrap();
    assert_eq!(operations.last().unwrap()["objects"], json!(["vase_1"]), "{operations:?}");
    assert!((at(&fewer, vase)[0] - at(&row, vase)[0] - 0.1).abs() < 0.02);
}

#[test]
fn an_edit_that_cannot_be_done_is_refused_and_writes_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    made(folder, &["generate", "--text", "a mug and two plates", "--seed", "1", "--out", "parent"]);
    let cases = [
        (json!([{ "op": "remove", "target": "the violin" }]), "violin"),
        (json!([{ "op": "move", "target": "plate", "where": { "relation": "at_left" } }]), "plate_2"),
        (json!([{ "op": "replace", "target": "the table", "object": "a mug" }]), "table"),
        (
            json!([{ "op": "move", "target": "plate_1", "where": { "relation": "in", "target": "mug_1" } }]),
            "does not fit",
        ),
        (
            json!([{ "op": "move", "target": "mug_1", "where": { "relation": "next_to", "target": "mug_1" } }]),
            "itself",
        ),
    ];
    for (operations, words) in cases {
        let operations = operations.to_string();
        let refused =
            tabletopgen(folder, &["edit", "--bundle", "parent", "--operations", &operations, "--out", "no"]);
        let said = String::from_utf8_lossy(&refused.stderr).into_owned();
        assert!(!refused.status.success() && said.contains(words), "{operations}: {said}");
        assert!(!folder.join("no").join("scene.json").exists(), "{operations}");
    }
}

#[test]
fn variants_differ_and_keep_what_the_text_states() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let text = "a red mug to the left of a laptop, a bowl with an apple in it, two books and a 300 g stapler";
    made(folder, &["generate", "--text", text, "--seed", "3", "--out", "parent"]);
    let variants = ["variants", "--bundle", "parent", "--count", "2", "--seed", "7", "--out", "made"];
    let axes = ["--vary", "layout,meshes,sizes,light,camera,mass,friction,table"];
    made(folder, &[&variants[..], &axes[..]].concat());
    let before = scene(folder, "parent");
    let x = |scene: &Value, name: &str| pose(scene, name).0[0].as_f64().unwrap();
    let mut places = Vec::new();
    for bundle in ["made/variant_0001", "made/variant_0002"] {
        let after = scene(folder, bundle);
        let names = |scene: &Value| -> Vec<Value> {
            let mut names: Vec<Value> =
                scene["instances"].as_array().unwrap().iter().map(|object| object["name"].clone()).collect();
            names.sort_by_key(ToString::to_string);
            names
        };
        assert_eq!(names(&after), names(&before));
        assert!(x(&after, "mug_1") < x(&after, "laptop_1"), "{bundle}");
        let apple = instance(&after, "apple_1").expect("an apple");
        assert_eq!(apple["support"], json!({ "parent": "bowl_1", "relation": "in" }));
        assert_eq!(after["metrics"]["col_s"], 0.0, "{bundle}");
        assert_ne!(after["camera"], before["camera"]);
        assert!(after["light"]["azimuth_rad"].is_number(), "{bundle}");
        assert_eq!(after["edit"]["moved"], json!([]), "every movement is one that the layout asks for");
        let kg = |scene: &Value, name: &str| instance(scene, name).unwrap()["mass_kg"].as_f64().unwrap();
        assert_ne!(kg(&after, "bowl_1"), kg(&before, "bowl_1"));
        assert_eq!(kg(&after, "stapler_1"), kg(&before, "stapler_1"), "the text states its mass");
        places.push(pose(&after, "laptop_1"));
    }
    assert_ne!(places[0], places[1]);
    // The same command leaves what is there, and another seed does not mix with it.
    let manifest = || std::fs::read(folder.join("made/variant_0002/manifest.json")).unwrap();
    let first = manifest();
    std::fs::remove_dir_all(folder.join("made/variant_0002")).unwrap();
    made(folder, &[&variants[..], &axes[..]].concat());
    assert_eq!(manifest(), first, "a variant is made again to the byte");
    let other = ["variants", "--bundle", "parent", "--count", "1", "--seed", "8", "--out", "made"];
    let refused = tabletopgen(folder, &other);
    assert!(!refused.status.success());
    assert!(String::from_utf8_lossy(&refused.stderr).contains("holds another scene"));
}
