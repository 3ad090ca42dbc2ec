//! `batch`: a file of requests that is stopped on the way, wrong lines, and what is refused before the work.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

use serde_json::{Value, json};

/// Scenes that take little time, since the real pipeline makes them.
const TEXTS: [&str; 3] = ["a mug", "a bowl", "a wooden block"];

/// The line of the batch file that is no JSON.
const MALFORMED_LINE: usize = 517;

fn command(home: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_tabletopgen"));
    command.arg("batch").args(arguments).current_dir(home);
    command
}

fn run(home: &Path, arguments: &[&str]) -> Output {
    command(home, arguments).output().expect("starts")
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).expect("is UTF-8")
}

/// Lines of a file of the batch, by name; a line that was cut off is none.
fn lines(path: PathBuf) -> BTreeMap<String, Value> {
    let content = std::fs::read_to_string(path).unwrap_or_default();
    let lines = content.lines().filter_map(|line| serde_json::from_str::<Value>(line).ok());
    lines.map(|line| (line["custom_id"].as_str().unwrap_or("?").to_owned(), line)).collect()
}

fn request(custom_id: &str, text: &str) -> String {
    json!({ "custom_id": custom_id, "body": { "text": text, "seed": 7 } }).to_string()
}

/// Three scenes, one of them on the last line; duplicates of the first one; line 517 is malformed.
fn batch_file() -> String {
    let mut lines = vec![request("first", TEXTS[0]), request("second", TEXTS[1])];
    while lines.len() < MALFORMED_LINE - 1 {
        lines.push(request(&format!("again-{}", lines.len() + 1), TEXTS[0]));
    }
    lines.push(r#"{"custom_id": "broken", "body": {"text": "a mug}"#.to_owned());
    lines.push(request("last", TEXTS[2]));
    lines.join("\n")
}

/// Waits for a condition on the files of a running batch.
fn wait_until(child: &mut Child, condition: impl Fn() -> bool) {
    let begun = Instant::now();
    while !condition() {
        assert!(child.try_wait().expect("a child").is_none(), "the batch ended early");
        assert!(begun.elapsed() < Duration::from_secs(300), "the batch is too slow");
        std::thread::sleep(Duration::from_millis(20));
    }
}

fn start(home: &Path, arguments: &[&str]) -> Child {
    let log = std::fs::File::create(home.join("log")).unwrap();
    command(home, arguments).stdout(Stdio::null()).stderr(log).spawn().expect("starts")
}

#[test]
fn a_batch_that_was_killed_and_interrupted_ends_as_one_that_was_not() {
    let home = tempfile::tempdir().unwrap();
    let at = |name: &str| home.path().join(name);
    std::fs::write(at("batch.jsonl"), batch_file()).unwrap();
    let stopped = ["batch.jsonl", "--out", "stopped", "--workers", "1"];

    let mut child = start(home.path(), &stopped);
    wait_until(&mut child, || lines(at("stopped/output.jsonl")).contains_key("first"));
    child.kill().unwrap();
    child.wait().unwrap();
    let after_kill = lines(at("stopped/output.jsonl"));
    assert!(!after_kill.contains_key("last"), "it was killed on the way");
    // What a crash of the machine may leave.
    std::fs::write(at("stopped/output.jsonl"), "{\"custom_id\":\"first\",\"sce").unwrap();
    std::fs::remove_dir_all(at("stopped/first")).unwrap();

    let mut child = start(home.path(), &stopped);
    wait_until(&mut child, || lines(at("stopped/output.jsonl")).contains_key("first"));
    let sent = Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    assert!(sent.success());
    assert_eq!(child.wait().unwrap().code(), Some(130));
    let log = std::fs::read_to_string(at("log")).unwrap();
    assert!(log.contains("the same command goes on there"), "{log}");

    let done = run(home.path(), &stopped);
    let log = text(&done.stderr);
    assert_eq!(done.status.code(), Some(5), "{log}");
    assert!(log.contains("batch.jsonl:517:48: EOF"), "{log}");
    assert!(text(&done.stdout).contains("3 of 518 requests succeeded, 514 duplicate, 1 invalid"));

    let whole = run(home.path(), &["batch.jsonl", "--out", "whole", "--workers", "2", "--json"]);
    assert_eq!(whole.status.code(), Some(5));
    let document: Value = serde_json::from_slice(&whole.stdout).expect("is JSON");
    let counts = &document["request_counts"];
    assert_eq!(
        (&counts["total"], &counts["succeeded"], &counts["pending"]),
        (&json!(518), &json!(3), &json!(0))
    );

    let (output, reference) = (lines(at("stopped/output.jsonl")), lines(at("whole/output.jsonl")));
    assert_eq!(output.keys().collect::<Vec<_>>(), reference.keys().collect::<Vec<_>>());
    assert_eq!(output.len(), 517, "every line but one");
    assert_eq!(output["first"]["scene_id"], after_kill["first"]["scene_id"], "it was not made twice");
    assert_eq!(output["first"]["attempts"], 1);
    assert_eq!(output["again-9"]["duplicate_of"], "first");
    for name in ["first", "second", "last"] {
        assert_eq!((&output[name]["state"], &output[name]["verdict"]), (&json!("succeeded"), &json!("pass")));
        let manifest = |out: &str| std::fs::read(at(out).join(name).join("manifest.json")).expect(name);
        assert_eq!(manifest("stopped"), manifest("whole"), "{name} has the same bytes");
    }
    for out in ["stopped", "whole"] {
        let errors = lines(at(out).join("errors.jsonl"));
        assert_eq!(errors.keys().collect::<Vec<_>>(), ["?"]);
        let error = &errors["?"]["error"];
        assert_eq!((&error["code"], &error["line"]), (&json!("malformed_json"), &json!(MALFORMED_LINE)));
        assert!(!at(out).join(".partial").exists());
    }
}

#[test]
fn a_recipe_makes_archives_and_a_second_run_makes_nothing() {
    let home = tempfile::tempdir().unwrap();
    let recipe = json!({ "templates": ["{item}"], "slots": { "item": ["a mug", "a bowl"] }, "seeds": [7] });
    std::fs::write(home.path().join("recipe.json"), recipe.to_string()).unwrap();
    let arguments = ["recipe.json", "--out", "out", "--zip", "--limit", "1", "--json"];
    for finished in [1, 0] {
        let done = run(home.path(), &arguments);
        assert_eq!(done.status.code(), Some(0), "{}", text(&done.stderr));
        let document: Value = serde_json::from_slice(&done.stdout).expect("is JSON");
        assert_eq!(document["finished_in_this_run"], finished);
        assert_eq!(document["request_counts"]["succeeded"], 1);
    }
    let output = lines(home.path().join("out/output.jsonl"));
    assert_eq!(output.keys().collect::<Vec<_>>(), ["t0_a-mug_s7"]);
    assert_eq!(output["t0_a-mug_s7"]["bundle"], "t0_a-mug_s7.zip");
    let archive = std::fs::File::open(home.path().join("out/t0_a-mug_s7.zip")).unwrap();
    let archive = zip::ZipArchive::new(archive).expect("is an archive");
    assert!(archive.file_names().any(|name| name.is_ok_and(|name| name.ends_with("/scene.json"))));
}

#[test]
fn a_failed_request_is_begun_again_on_demand_alone() {
    let home = tempfile::tempdir().unwrap();
    let line =
        json!({ "custom_id": "a", "body": { "text": "a qwrtz", "options": { "on_unknown": "fail" } } });
    std::fs::write(home.path().join("a.jsonl"), line.to_string()).unwrap();
    let mut attempts = Vec::new();
    for more in [vec![], vec![], vec!["--retry-failed"]] {
        let done = run(home.path(), &[vec!["a.jsonl", "--out", "out", "--json"], more].concat());
        assert_eq!(done.status.code(), Some(5), "{}", text(&done.stderr));
        let document: Value = serde_json::from_slice(&done.stdout).expect("is JSON");
        attempts.push(document["finished_in_this_run"].as_u64());
        let errors = lines(home.path().join("out/errors.jsonl"));
        assert_eq!(errors["a"]["state"], "failed");
        assert!(errors["a"]["error"]["message"].as_str().unwrap().contains("qwrtz"), "{errors:?}");
    }
    assert_eq!(attempts, [Some(1), Some(0), Some(1)]);
}

#[test]
fn what_will_not_do_is_said_before_the_work() {
    let home = tempfile::tempdir().unwrap();
    let write = |name: &str, content: &str| std::fs::write(home.path().join(name), content).unwrap();
    write("good.jsonl", &request("a", "a mug"));
    write("empty.jsonl", "\n\n");
    write("notes.txt", "a mug");
    write("slots.json", r#"{"templates": ["a {color} mug"], "slots": {"color": []}}"#);
    std::fs::create_dir(home.path().join("full")).unwrap();
    write("full/thesis.tex", "years of work");
    for (arguments, says) in [
        (vec!["good.jsonl"], "--out"),
        (
            vec!["missing.jsonl", "--out", "out"],
            "cannot read the requests missing.jsonl: there is no such file",
        ),
        (vec!["full", "--out", "out"], "is not a file"),
        (vec!["notes.txt", "--out", "out"], "neither .jsonl"),
        (vec!["slots.json", "--out", "out"], "/slots/color: has no values"),
        (
            vec!["good.jsonl", "--out", "full"],
            "--out full is not empty and holds files that are no part of a batch",
        ),
        (vec!["good.jsonl", "--out", "notes.txt"], "is a file"),
        (vec!["good.jsonl", "--out", "out", "--workers", "65"], "worker.concurrency (--workers): 65"),
        (vec!["good.jsonl", "--out", "out", "--budget=-1"], "--budget must be from 0"),
        (vec!["good.jsonl", "--out", "out", "--set", "dro.keeep=2"], "nearest is dro.keep"),
    ] {
        let done = run(home.path(), &arguments);
        let complaint = text(&done.stderr);
        assert_eq!(done.status.code(), Some(2), "{arguments:?}: {complaint}");
        assert!(complaint.contains(says), "{arguments:?}: {complaint}");
        assert!(!home.path().join("out").exists(), "{arguments:?}");
    }
    let done = run(home.path(), &["empty.jsonl", "--out", "out"]);
    assert_eq!(done.status.code(), Some(2));
    assert!(text(&done.stderr).contains("has no requests"));
}
