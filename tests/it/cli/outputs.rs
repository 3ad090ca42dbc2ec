//! No command writes over what it did not write, over its input, or over an earlier output unless it is forced.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

use serde_json::json;

use super::edits::bundle;
use super::signals;

fn command(home: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_tabletopgen"));
    command.args(arguments).current_dir(home);
    command
}

fn run(home: &Path, arguments: &[&str]) -> Output {
    command(home, arguments).output().expect("starts")
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
                found.insert(path, bytes);
            }
        }
    }
    found
}

/// Commands that write, with the option of their output last.
const WRITERS: [(&[&str], Writes); 14] = [
    (&["generate", "--text", "a mug", "--out"], Writes::Folder { can_be_forced: true }),
    (
        &["edit", "--bundle", "desk", "--text", "tidy the table", "--out"],
        Writes::Folder { can_be_forced: true },
    ),
    (&["variants", "--bundle", "desk", "--count", "1", "--out"], Writes::FolderInside("variant_0001")),
    (&["tasks", "--bundle", "desk", "--out"], Writes::Folder { can_be_forced: true }),
    (
        &["execute", "--bundle", "desk", "--task", "put a on b", "--out"],
        Writes::Folder { can_be_forced: true },
    ),
    (
        &["episodes", "--bundle", "desk", "--task", "put a on b", "--count", "1", "--out"],
        Writes::Folder { can_be_forced: true },
    ),
    (
        &["regenerate-episode", "--dataset", "d", "--episode", "0", "--bundle", "desk", "--out"],
        Writes::Folder { can_be_forced: true },
    ),
    (&["batch", "requests.jsonl", "--out"], Writes::Folder { can_be_forced: true }),
    (&["backup", "--data-dir", "data"], Writes::Folder { can_be_forced: false }),
    (&["diff", "desk", "other", "--image"], Writes::File),
    (&["render", "--bundle", "desk", "--out"], Writes::File),
    (&["evaluate", "scenes.json", "--out"], Writes::File),
    (&["dataset", "stats", "frozen", "--html"], Writes::File),
    (&["catalog", "check", "own.toml", "--sheet"], Writes::File),
];

#[derive(Clone, Copy, PartialEq)]
enum Writes {
    Folder { can_be_forced: bool },
    FolderInside(&'static str),
    File,
}

fn with_inputs() -> tempfile::TempDir {
    let home = tempfile::tempdir().unwrap();
    let at = |name: &str| home.path().join(name);
    bundle(home.path(), "desk", 0.0);
    bundle(home.path(), "other", 0.1);
    std::fs::create_dir(at("frozen")).unwrap();
    std::fs::write(at("frozen/dataset.json"), "{}").unwrap();
    std::fs::write(at("own.toml"), "category = []").unwrap();
    std::fs::write(at("scenes.json"), r#"{"scenes": [{"name": "desk", "bundle": "desk"}]}"#).unwrap();
    std::fs::write(at("requests.jsonl"), r#"{"custom_id": "a", "body": {"text": "a mug"}}"#).unwrap();
    home
}

#[test]
fn files_of_others_are_refused_by_every_command_and_stay() {
    let home = with_inputs();
    let mine = home.path().join("mine");
    for (arguments, writes) in WRITERS {
        let forms: &[&[&str]] = match writes {
            Writes::Folder { can_be_forced: false } => &[&[]],
            _ => &[&[], &["--force"]],
        };
        for more in forms {
            let place = match writes {
                Writes::FolderInside(name) => mine.join(name),
                Writes::Folder { .. } | Writes::File => mine.clone(),
            };
            if writes == Writes::File {
                std::fs::write(&place, "years of work").unwrap();
                if !more.is_empty() {
                    // A file that is named and forced is meant.
                    std::fs::remove_file(&place).unwrap();
                    std::fs::create_dir(&place).unwrap();
                }
            } else {
                std::fs::create_dir_all(&place).unwrap();
                std::fs::write(place.join("task.json"), "years of work").unwrap();
            }
            let before = files(home.path());
            let done = run(home.path(), &[arguments, &["mine"], *more].concat());
            let complaint = text(&done.stderr);
            assert_eq!(done.status.code(), Some(2), "{arguments:?} {more:?}: {complaint}");
            assert!(complaint.contains("mine"), "{arguments:?}: {complaint}");
            assert!(complaint.contains("name "), "{complaint}");
            assert_eq!(files(home.path()), before, "{arguments:?} {more:?}");
            let removed =
                if mine.is_dir() { std::fs::remove_dir_all(&mine) } else { std::fs::remove_file(&mine) };
            removed.unwrap();
        }
    }
}

#[test]
fn inputs_are_refused_as_outputs_by_every_command() {
    let home = with_inputs();
    let before = files(home.path());
    for (arguments, writes) in WRITERS {
        if ["generate", "batch", "backup"].contains(&arguments[0]) {
            continue;
        }
        for place in match writes {
            Writes::File => &["desk/page.html", "frozen/page.html"][..],
            Writes::Folder { .. } | Writes::FolderInside(_) => &["desk", "desk/new"][..],
        } {
            let reads = if place.starts_with("frozen") { "dataset" } else { "desk" };
            if !arguments.contains(&reads) {
                continue;
            }
            let done = run(home.path(), &[arguments, &[place]].concat());
            let complaint = text(&done.stderr);
            assert_eq!(done.status.code(), Some(2), "{arguments:?} {place}: {complaint}");
            assert!(!complaint.contains("panicked"), "{complaint}");
            assert_eq!(files(home.path()), before, "{arguments:?} {place}");
        }
    }
    let forced = ["edit", "--bundle", "desk", "--text", "tidy the table", "--force", "--out"];
    for (place, says) in [("desk", "is an input"), (".", "holds an input"), ("desk/new", "lies inside")] {
        let done = run(home.path(), &[&forced[..], &[place]].concat());
        assert_eq!(done.status.code(), Some(2));
        assert!(text(&done.stderr).contains(says), "{place}: {}", text(&done.stderr));
    }
}

#[test]
fn every_command_that_writes_is_in_the_table() {
    let home = tempfile::tempdir().unwrap();
    let help = |arguments: &[&str]| text(&run(home.path(), &[arguments, &["--help"]].concat()).stdout);
    let names = |help: &str| -> Vec<String> {
        let commands = help.split("Commands:").nth(1).unwrap_or_default();
        let lines = commands.lines().skip(1).take_while(|line| line.starts_with("  "));
        lines.filter_map(|line| line.split_whitespace().next()).map(str::to_owned).collect()
    };
    let mut writers = Vec::new();
    for name in names(&help(&[])).into_iter().filter(|name| name != "help") {
        let inner = names(&help(&[&name]));
        let calls: Vec<Vec<&str>> = match inner.is_empty() {
            true => vec![vec![&name]],
            false => inner.iter().filter(|inner| *inner != "help").map(|inner| vec![&*name, inner]).collect(),
        };
        for call in calls {
            let help = help(&call);
            let writes = ["--out <", "--html <", "--image <FILE>", "--sheet <"]
                .iter()
                .any(|option| help.contains(option));
            if writes {
                writers.push(call.join(" "));
            }
        }
    }
    // Tests of the crate freeze into folders with other files. Tools have names of results, which must be new, and a
    // manual is written beside others.
    let elsewhere = ["dataset freeze", "mcp", "man"];
    for writer in &writers {
        let is_listed = WRITERS.iter().any(|(arguments, _)| arguments.join(" ").starts_with(writer.as_str()));
        assert!(is_listed || elsewhere.contains(&writer.as_str()), "{writer} writes and is not tested");
    }
    assert!(writers.len() >= 9, "{writers:?}");
}

#[test]
fn a_scene_is_replaced_when_forced_and_survives_what_fails() {
    let home = tempfile::tempdir().unwrap();
    let at = home.path();
    let with = |seed: &'static str, more: &[&'static str]| {
        [&["generate", "--text", "a mug", "--out", "scene", "--seed", seed], more].concat()
    };
    let made = run(at, &with("1", &[]));
    assert!(made.status.success(), "{}", text(&made.stderr));
    let first = files(at);
    let refused = run(at, &with("2", &[]));
    assert_eq!(refused.status.code(), Some(2));
    assert!(text(&refused.stderr).contains("add --force to replace it"), "{}", text(&refused.stderr));
    // One that fails, and one that is interrupted.
    let unknown = ["generate", "--text", "a qwrtz", "--on-unknown", "fail", "--out", "scene", "--force"];
    assert_eq!(run(at, &unknown).status.code(), Some(4));
    let mut stopped =
        command(at, &with("2", &["--force"])).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
    signals::wait_for_handlers(&stopped);
    let sent = Command::new("kill").args(["-INT", &stopped.id().to_string()]).status().unwrap();
    assert!(sent.success());
    let begun = Instant::now();
    while stopped.try_wait().unwrap().is_none() && begun.elapsed() < Duration::from_secs(60) {
        std::thread::sleep(Duration::from_millis(20));
    }
    assert_eq!(stopped.wait().unwrap().code(), Some(130));
    assert_eq!(files(at), first, "nothing of the first scene is lost, and nothing is left beside it");
    let replaced = run(at, &with("2", &["--force"]));
    assert!(replaced.status.success(), "{}", text(&replaced.stderr));
    let second = files(at);
    assert_ne!(second[&at.join("scene/scene.json")], first[&at.join("scene/scene.json")]);
    assert!(second.keys().all(|path| path.starts_with(at.join("scene"))), "{:?}", second.keys());

    // Without --out the folder has the name of the scene, and the same scene is not written twice.
    for _ in 0..2 {
        let usual = run(at, &["generate", "--text", "a mug", "--seed", "1"]);
        assert!(usual.status.success(), "{}", text(&usual.stderr));
        assert_eq!(std::fs::read_dir(at.join("out")).unwrap().count(), 1);
    }
    let name = std::fs::read_dir(at.join("out")).unwrap().next().unwrap().unwrap().path();
    std::fs::write(name.join("report.json"), "notes of mine").unwrap();
    let again = run(at, &["generate", "--text", "a mug", "--seed", "1"]);
    assert!(again.status.success(), "{}", text(&again.stderr));
    assert_eq!(std::fs::read_dir(at.join("out")).unwrap().count(), 2, "beside the changed one");
    assert_eq!(std::fs::read(name.join("report.json")).unwrap(), b"notes of mine");
}

#[test]
fn a_changed_request_does_not_replace_a_bundle_unless_forced() {
    let home = tempfile::tempdir().unwrap();
    let at = home.path();
    let write = |text: &str| {
        let line = json!({ "custom_id": "a", "body": { "text": text, "seed": 7 } });
        std::fs::write(at.join("requests.jsonl"), line.to_string()).unwrap();
    };
    let batch = ["batch", "requests.jsonl", "--out", "out"];
    write("a mug");
    assert!(run(at, &batch).status.success());
    let scene = || std::fs::read(at.join("out/a/scene.json")).unwrap();
    let first = scene();
    write("a bowl");
    let refused = run(at, &batch);
    assert_eq!(refused.status.code(), Some(2), "{}", text(&refused.stderr));
    assert!(text(&refused.stderr).contains("out/a exists"), "{}", text(&refused.stderr));
    assert_eq!(scene(), first);
    let forced = run(at, &[&batch[..], &["--force"]].concat());
    assert!(forced.status.success(), "{}", text(&forced.stderr));
    assert_ne!(scene(), first);
    assert!(run(at, &batch).status.success(), "the same command goes on");
}
