//! Statements of the parser and the layout about a text reach the bundle, the report and the printed documents.

use std::path::Path;
use std::process::Command;

use serde_json::{Value, json};

const TEXT: &str = "Put the sextant in the basket. A plate stands 2 m to the right of the basket, and there are a \
                    bannana and a zorgle on the desk. The desk is 1 m wide.";

fn tabletopgen(folder: &Path, arguments: &[&str]) -> String {
    let done =
        Command::new(env!("CARGO_BIN_EXE_tabletopgen")).args(arguments).current_dir(folder).output().unwrap();
    assert!(done.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&done.stderr));
    String::from_utf8(done.stdout).unwrap()
}

#[test]
fn the_account_of_a_text_reaches_every_reader() {
    let folder = tempfile::tempdir().unwrap();
    let parsed: Value =
        serde_json::from_str(&tabletopgen(folder.path(), &["parse", TEXT, "--seed", "5", "--json"])).unwrap();
    let data_dir = ["--data-dir", "data"];
    let made = ["generate", "--text", TEXT, "--seed", "5", "--out", "out", "--force"];
    let document: Value =
        serde_json::from_str(&tabletopgen(folder.path(), &[&made[..], &data_dir, &["--json"]].concat()))
            .unwrap();
    let printed = tabletopgen(folder.path(), &[&made[..], &data_dir].concat());
    let read = |name: &str| std::fs::read_to_string(folder.path().join("out").join(name)).unwrap();
    let json_of = |name: &str| -> Value { serde_json::from_str(&read(name)).unwrap() };
    let (scene, report) = (json_of("scene.json"), json_of("report.json"));

    // One account everywhere; the layout adds what yielded.
    let account = &scene["text"];
    assert_eq!(*account, report["text"]);
    assert_eq!(*account, document["summary"]["text"]);
    let mut before_layout = account.clone();
    let unmet = before_layout.as_object_mut().unwrap().remove("unmet");
    assert_eq!(before_layout, parsed["text"]);
    let [demand] = unmet.as_ref().and_then(Value::as_array).unwrap().as_slice() else {
        panic!("{unmet:?} is not one demand");
    };
    assert_eq!((&demand["objects"], &demand["relation"]), (&json!(["plate_1"]), &json!("right_of")));

    assert_eq!(account["stand_ins"], json!(["sextant_1"]));
    let sextant = scene["instances"].as_array().unwrap().iter().find(|object| object["name"] == "sextant_1");
    let sextant = sextant.expect("an instance");
    assert_eq!((&sextant["label"], &sextant["stand_in"]), (&json!("sextant"), &json!(true)));
    assert_eq!(sextant["stands_for"], "sextant");
    let counted = "1 of 4 objects is a stand-in.";
    let verdict = report["summary"].as_str().unwrap();
    assert!(verdict.ends_with(counted), "{verdict}");
    assert_eq!(document["summary"]["verdict_text"], verdict);
    assert!(read("report.html").contains(counted) && printed.contains(counted));
    assert!(read("mjcf/scene.xml").contains("<text name=\"stand_in_sextant_1\" data=\"true\"/>"));

    let page = read("report.html");
    for words in
        ["sextant_1 in basket_1", "bannana", "zorgle", "plate_1 right of basket_1, at 200 cm", "stand-in"]
    {
        assert!(page.contains(words), "the page lacks {words}");
    }
    let line = |start: &str, words: &str| {
        let found = printed.lines().any(|line| line.trim().starts_with(start) && line.contains(words));
        assert!(found, "no line {start:?} with {words:?} in {printed}");
    };
    line("understood", "read as \"banana\"");
    line("understood", "1 × plate: plate_1");
    line("without effect \"zorgle\"", "unknown");
    line("stand-in", "sextant_1");
    line("yielded", "plate_1 right of basket_1");
    line("goal", "start state");
    line("sextant_1 in basket_1", "");
}

#[test]
fn on_unknown_decides_about_stand_ins() {
    let folder = tempfile::tempdir().unwrap();
    let text = "a mug and a sextant";
    let account = |policy: &str| -> Value {
        let printed = tabletopgen(folder.path(), &["parse", text, "--on-unknown", policy, "--json"]);
        serde_json::from_str(&printed).unwrap()
    };
    let stood_in = account("stand-in");
    assert_eq!(stood_in["request"]["options"]["on_unknown"], "stand_in");
    assert_eq!(
        (&stood_in["text"]["stand_ins"], &stood_in["text"]["unrecognized"]),
        (&json!(["sextant_1"]), &json!([]))
    );
    let dropped = account("drop");
    assert_eq!(dropped["text"]["stand_ins"], json!([]));
    assert_eq!(dropped["text"]["unrecognized"][0]["span"]["text"], "sextant");
}
