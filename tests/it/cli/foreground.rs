//! `tasks` and `execute`, from outside: their progress, their end by signals, and what they refuse alike.

use std::io::Read;
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::time::Duration;

use serde_json::Value;

use super::signals;

const PUT: &str = "put the block on the plate";

fn command(directory: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_tabletopgen"));
    command.args(arguments).current_dir(directory);
    command
}

fn run(directory: &Path, arguments: &[&str]) -> Output {
    command(directory, arguments).output().expect("starts")
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

#[test]
fn tasks_and_executions_show_their_stages_and_end_by_signals() {
    let home = tempfile::tempdir().expect("a folder");
    let at = home.path();
    let made =
        run(at, &["generate", "--text", "A table with a block and a plate", "--seed", "3", "--out", "scene"]);
    assert!(made.status.success(), "{}", text(&made.stderr));

    let bundle = ["--bundle", "scene"];
    let proposed = run(at, &[&["tasks", "--count", "2"][..], &bundle].concat());
    let said = text(&proposed.stderr);
    assert!(proposed.status.success() && said.contains("rehearse: 1 of 2: "), "{said}");
    assert!(said.lines().any(|line| line.starts_with("rehearse ") && line.ends_with(" s")), "{said}");
    let quiet = run(at, &[&["tasks", "--count", "20", "--no-rehearse", "--json"][..], &bundle].concat());
    let found: Value = serde_json::from_slice(&quiet.stdout).expect("JSON");
    assert!(found["proposed"].as_array().is_some_and(|list| list.len() > 2) && quiet.stderr.is_empty());
    let many = run(at, &[&["tasks", "--count", "20"][..], &bundle].concat());
    assert_eq!(many.status.code(), Some(2));
    assert!(text(&many.stderr).contains("--no-rehearse"), "{}", text(&many.stderr));

    let done = run(at, &[&["execute", "--task", PUT][..], &bundle].concat());
    let said = text(&done.stderr);
    for stage in ["grasps ", "motion "] {
        assert!(said.lines().any(|line| line.starts_with(stage)), "{stage}: {said}");
    }

    // Trials without an end.
    let long = ["--set", "grasps.max_trials=10000", "--set", "grasps.wanted_stable=10000"];
    let long = [&long[..], &["--set", "grasps.max_candidates=10000"], &bundle].concat();
    let execute = [&["execute", "--task", PUT, "--out", "run"][..], &long].concat();
    let tasks = [&["tasks", "--out", "run"][..], &long].concat();
    for signal in signals::that_stop() {
        let arguments = if signal == "-HUP" { &tasks } else { &execute };
        let mut process =
            command(at, arguments).stderr(Stdio::piped()).stdout(Stdio::null()).spawn().expect("starts");
        signals::wait_for_handlers(&process);
        std::thread::sleep(Duration::from_millis(300));
        let sent = Command::new("kill").args([signal, &process.id().to_string()]).status().expect("kill");
        assert!(sent.success());
        let ended = process.wait().expect("ends");
        let mut said = String::new();
        process.stderr.take().expect("piped").read_to_string(&mut said).expect("text");
        assert_eq!(ended.code(), Some(130), "{arguments:?} {signal}: {said}");
        assert!(said.contains("stopping") && said.contains("nothing was written"), "{said}");
    }
    assert!(!at.join("run").exists());
    check_refusals(at);
}

/// Regressions: another task was done than was asked for, and messages said neither what there is nor what is wrong.
fn check_refusals(at: &Path) {
    let bundle = ["--bundle", "scene"];
    for (task, more, code, says) in [
        ("shake the block", &[][..], "verb_not_performed", "\"shake\""),
        ("hand me the block", &[][..], "verb_not_performed", "\"hand\""),
        ("throw the block onto the plate", &[][..], "verb_not_performed", "put"),
        ("pour tea into the plate", &[][..], "verb_not_performed", "\"pour\""),
        ("turn the block upside down", &[][..], "predicate_not_supported", "put"),
        ("lift the elephant", &[][..], "absent_object", "block_1, plate_1"),
        (PUT, &["--base", "5,5,0,0"][..], "table_out_of_reach", "x 5.00, y 5.00"),
    ] {
        let refused = run(at, &[&["execute", "--task", task, "--json"][..], &bundle, more].concat());
        let printed: Value = serde_json::from_slice(&refused.stdout).expect("JSON");
        assert_eq!(refused.status.code(), Some(2), "{task}: {printed}");
        assert_eq!(printed["failure"]["problem"]["code"], code, "{task}: {printed}");
        let message = printed["failure"]["message"].as_str().expect("a message");
        assert!(message.contains(says), "{task}: {message}");
    }
    let task = r#"{"format": "tabletopgen-task/1", "instruction": "lift it", "robot": "panda",
        "goal": [{"predicate": "lifted", "object": "mug_9"}],
        "limits": {"max_duration_s": 60, "max_displacement_of_others_m": 0.03, "max_rotation_of_others_rad": 0.5,
            "min_gripper_distance_m": 0.02, "min_rest_s": 1}}"#;
    std::fs::write(at.join("absent.json"), task).expect("written");
    let refused = run(at, &[&["execute", "--task", "absent.json"][..], &bundle].concat());
    assert_eq!(refused.status.code(), Some(2));
    assert!(text(&refused.stderr).contains("it has block_1, plate_1"), "{}", text(&refused.stderr));
    let edited = run(
        at,
        &[&["edit", "--text", "move the block 5 meters to the left", "--out", "e"][..], &bundle].concat(),
    );
    let said = text(&edited.stderr);
    assert!(said.contains("over the edge of the table; in that direction it can go"), "{said}");
}
