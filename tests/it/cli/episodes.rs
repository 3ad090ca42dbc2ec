//! `episodes`, from outside: a dataset, the same after a kill and with other workers, and what is refused.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

fn program(directory: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_tabletopgen"));
    command.args(arguments).current_dir(directory);
    command
}

fn run(directory: &Path, arguments: &[&str]) -> Output {
    program(directory, arguments).output().expect("starts")
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// Every file below a folder with its bytes.
fn files(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut found = BTreeMap::new();
    let mut open = vec![folder.to_owned()];
    while let Some(at) = open.pop() {
        for entry in std::fs::read_dir(&at).expect("a folder") {
            let path = entry.expect("an entry").path();
            if path.is_dir() {
                open.push(path);
            } else {
                let bytes = std::fs::read(&path).expect("a file");
                found.insert(path.strip_prefix(folder).expect("below").to_owned(), bytes);
            }
        }
    }
    found
}

fn scene(at: &Path) {
    let sentence = "A table with a block and a plate";
    let made = run(at, &["generate", "--text", sentence, "--seed", "3", "--out", "scene"]);
    assert!(made.status.success(), "{}", text(&made.stderr));
}

const TASK: &str = "put the block on the plate";
const FEW: [&str; 12] = [
    "episodes",
    "--bundle",
    "scene",
    "--task",
    TASK,
    "--count",
    "2",
    "--cameras",
    "front,wrist",
    "--size",
    "32",
    "--format=lerobot-v2.1,parquet-png",
];

#[test]
fn a_dataset_is_the_same_after_a_kill_and_with_other_workers() {
    let home = tempfile::tempdir().expect("a folder");
    let at = home.path();
    scene(at);
    let whole = run(at, &[&FEW[..], &["--out", "whole", "--workers", "1", "--json"]].concat());
    assert!(whole.status.success(), "{}{}", text(&whole.stdout), text(&whole.stderr));
    let report: serde_json::Value = serde_json::from_slice(&whole.stdout).expect("JSON");
    assert_eq!(report["episodes"], 2);
    assert!(report["frames"].as_u64().expect("a number") > 60, "{report}");

    again(at);

    let with_two = [&FEW[..], &["--out", "parted", "--workers", "2"]].concat();
    let mut killed = program(at, &with_two).stderr(Stdio::null()).spawn().expect("starts");
    let begun = Instant::now();
    let has_unit = || {
        let units = std::fs::read_dir(at.join("parted.units")).into_iter().flatten().flatten();
        units.into_iter().any(|entry| entry.path().extension().is_some_and(|end| end == "unit"))
    };
    while !has_unit() && begun.elapsed() < Duration::from_secs(240) {
        std::thread::sleep(Duration::from_millis(20));
    }
    killed.kill().expect("is killed");
    killed.wait().expect("ends");
    assert!(!at.join("parted").exists(), "nothing incomplete looks complete");
    let other = run(at, &[&with_two[..], &["--seed", "9"]].concat());
    assert_eq!(other.status.code(), Some(1), "{}", text(&other.stderr));
    assert!(text(&other.stderr).contains("episodes of another order"), "{}", text(&other.stderr));
    let resumed = run(at, &with_two);
    assert!(resumed.status.success(), "{}", text(&resumed.stderr));
    assert!(!at.join("parted.units").exists());
    let refused = run(at, &with_two);
    assert_eq!(refused.status.code(), Some(2), "{}", text(&refused.stderr));
    assert!(text(&refused.stderr).contains("add --force to replace it"), "{}", text(&refused.stderr));

    let (whole, parted) = (files(&at.join("whole")), files(&at.join("parted")));
    // The title is the name of the folder.
    let differ = |path: &&PathBuf| !path.ends_with("README.md") && whole.get(*path) != parted.get(*path);
    assert_eq!(whole.keys().collect::<Vec<_>>(), parted.keys().collect::<Vec<_>>());
    assert_eq!(whole.keys().filter(differ).collect::<Vec<_>>(), Vec::<&PathBuf>::new());
}

/// Makes the second episode of a dataset again.
fn again(at: &Path) {
    let words = ["regenerate-episode", "--dataset", "whole", "--scene", "scene", "--episode"];
    let made = run(at, &[&words[..], &["1", "--out", "again", "--json"]].concat());
    assert!(made.status.success(), "{}{}", text(&made.stdout), text(&made.stderr));
    let first = files(&at.join("again"));
    let replaced = run(at, &[&words[..], &["0", "--out", "again", "--force"]].concat());
    assert!(replaced.status.success(), "{}", text(&replaced.stderr));
    assert_ne!(files(&at.join("again")), first, "it holds the other episode");
    let back = run(at, &[&words[..], &["1", "--out", "again", "--force"]].concat());
    assert!(back.status.success(), "{}", text(&back.stderr));
    assert_eq!(files(&at.join("again")), first);
    let report: serde_json::Value = serde_json::from_slice(&made.stdout).expect("JSON");
    assert_eq!((&report["same"], &report["digest"]), (&true.into(), &report["recorded_digest"]));
    let folder = |dataset: &str, number: u64| {
        files(&at.join(format!("{dataset}/parquet-png/episodes/episode_{number:06}")))
    };
    let (recorded, made) = (folder("whole", 1), folder("again", 0));
    assert!(recorded.len() > 60 && recorded.keys().eq(made.keys()));
    let is_image = |path: &&PathBuf| path.extension().is_some_and(|end| end == "png");
    assert!(recorded.keys().filter(is_image).all(|image| recorded[image] == made[image]));

    for (options, says) in
        [(&["2"][..], "has 2 episodes"), (&["0", "--out", "again"], "add --force to replace it")]
    {
        let refused = run(at, &[&words[..], options].concat());
        assert!(!refused.status.success());
        assert!(text(&refused.stderr).contains(says), "{options:?}: {}", text(&refused.stderr));
    }
    let none = run(at, &["regenerate-episode", "--dataset", "scene", "--scene", "scene", "--episode", "0"]);
    assert!(text(&none.stderr).contains("is no dataset"), "{}", text(&none.stderr));
    let records = std::fs::read_to_string(at.join("whole/parquet-png/records.jsonl")).expect("records");
    std::fs::create_dir(at.join("other")).expect("made");
    let digest: serde_json::Value =
        serde_json::from_str(records.lines().next().expect("a line")).expect("JSON");
    let digest = digest["record"]["scene"].as_str().expect("a digest").to_owned();
    std::fs::write(at.join("other/records.jsonl"), records.replace(&digest, &"0".repeat(64)))
        .expect("written");
    let other = run(at, &["regenerate-episode", "--dataset", "other", "--scene", "scene", "--episode", "0"]);
    assert!(text(&other.stderr).contains("was recorded in the bundle"), "{}", text(&other.stderr));
}

#[test]
fn orders_that_will_not_do_are_refused_before_anything_is_recorded() {
    let home = tempfile::tempdir().expect("a folder");
    let at = home.path();
    scene(at);
    let inside = r#"[{"name": "own", "mount": "world", "eye_m": [0, 0, -0.01], "target_m": [1, 0, 0],
        "fov_x_rad": 1.0, "width_px": 64, "height_px": 64}]"#;
    std::fs::write(at.join("inside.json"), inside).expect("written");
    std::fs::create_dir(at.join("there")).expect("made");
    std::fs::write(at.join("there/thesis.tex"), "years of work").expect("written");
    for (options, says) in [
        (&["--task", TASK, "--count", "0", "--out", "d"][..], "--count"),
        (&["--task", TASK, "--count", "1", "--out", "d", "--format", "rlds"], "no format is named rlds"),
        (&["--task", TASK, "--count", "1", "--out", "d", "--cameras", "top"], "none of the usual cameras"),
        (&["--task", TASK, "--count", "1", "--out", "d", "--cameras", "inside.json"], "inside the table"),
        (&["--task", TASK, "--count", "1", "--out", "d", "--size", "33"], "choose even sides"),
        (&["--task", TASK, "--count", "1", "--out", "d", "--fps", "0"], "--fps"),
        (&["--task", TASK, "--count", "1", "--out", "d", "--amplitude", "mass=0.9"], "must be from 0 to 0.5"),
        (&["--task", TASK, "--count", "1", "--out", "d", "--amplitude", "wind=1"], "there is no axis wind"),
        (&["--task", TASK, "--count", "1", "--out", "there", "--force"], "no part of a dataset of episodes"),
        (
            &["--task", TASK, "--count", "1", "--out", "d", "--depth"],
            "is kept by none of the formats; add one of robomimic, parquet-png",
        ),
        (&["--task", TASK, "--count", "1", "--out", "d", "--instance-ids"], "--instance-ids"),
        (&["--task", TASK, "--count", "1", "--out", "d", "--point-cloud", "64"], "--point-cloud"),
        (
            &[
                "--task",
                TASK,
                "--count",
                "1",
                "--out",
                "d",
                "--depth",
                "--format",
                "robomimic",
                "--cameras",
                "none",
            ],
            "--depth needs a camera",
        ),
        (&["--task", "put the fork on the plate", "--count", "1", "--out", "d"], "fork"),
        (&["--task", TASK, "--task", TASK, "--count", "1", "--out", "d"], "twice"),
        (&["--count", "1", "--out", "d"], "--task"),
        (&["--task", TASK, "--count", "1", "--out", "d", "--robot", "hal"], "hal"),
    ] {
        let refused = run(at, &[&["episodes", "--bundle", "scene"], options].concat());
        assert_eq!(refused.status.code(), Some(2), "{options:?}: {}", text(&refused.stderr));
        assert!(text(&refused.stderr).contains(says), "{options:?}: {}", text(&refused.stderr));
        assert!(!at.join("d").exists() && !at.join("d.units").exists(), "{options:?}");
    }
}
