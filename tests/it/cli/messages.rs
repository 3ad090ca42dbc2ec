//! Messages of commands about wrong input: what was attempted, on what, and what to do instead.

use std::path::Path;
use std::process::{Command, Output};

use super::edits::bundle;

fn run(home: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_tabletopgen"));
    command.args(arguments).current_dir(home).output().expect("starts")
}

/// Words of libraries that do not help.
const BANNED: [&str; 9] = [
    "EOCD",
    "invalid digit",
    "invalid float",
    "cannot parse integer",
    "stream did not contain",
    "os error 20",
    "os error 21",
    "panicked",
    "unwrap",
];

/// Asserts the exit code 2, the words, and that none is of a library.
fn refused(home: &Path, arguments: &[&str], says: &[&str]) {
    let done = run(home, arguments);
    let complaint = String::from_utf8_lossy(&done.stderr).into_owned();
    assert_eq!(done.status.code(), Some(2), "{arguments:?}: {complaint}");
    for words in says {
        assert!(complaint.contains(words), "{arguments:?} lacks {words:?}: {complaint}");
    }
    for words in BANNED {
        assert!(!complaint.contains(words), "{arguments:?}: {complaint}");
    }
}

/// Files of each kind that is given by mistake.
fn mistakes() -> tempfile::TempDir {
    let home = tempfile::tempdir().unwrap();
    bundle(home.path(), "scene", 0.0);
    std::fs::create_dir(home.path().join("a folder")).unwrap();
    for (name, bytes) in [
        ("notes.txt", &b"a mug"[..]),
        ("empty.json", b""),
        ("binary.json", b"\xff\xfe\x00"),
        ("half.json", b"{"),
        ("other.json", b"{}"),
        ("half.zip", b"PK\x05\x06"),
        ("binary.zip", b"\xff\xfe\x00\x01"),
        ("empty.zip", b""),
    ] {
        std::fs::write(home.path().join(name), bytes).unwrap();
    }
    home
}

#[test]
fn what_is_no_bundle_is_named_by_every_command_that_reads_one() {
    let home = mistakes();
    let commands: [&[&str]; 9] = [
        &["edit", "--text", "tidy the table", "--out", "new", "--bundle"],
        &["variants", "--count", "1", "--out", "new", "--bundle"],
        &["tasks", "--bundle"],
        &["execute", "--task", "put the mug on the plate", "--bundle"],
        &["episodes", "--task", "put the mug on the plate", "--count", "1", "--out", "new", "--bundle"],
        &["diff", "scene"],
        &["diff", "--json", "scene"],
        &["render", "--out", "new.png", "--bundle"],
        &["dataset", "freeze", "--name", "k", "--out", "new", "--from"],
    ];
    for command in commands {
        for file in ["half.zip", "binary.zip", "empty.zip", "notes.txt"] {
            refused(home.path(), &[command, &[file]].concat(), &[file, "bundle", "damaged one"]);
        }
        refused(home.path(), &[command, &["a folder"]].concat(), &["a folder", "bundle", "give "]);
        refused(home.path(), &[command, &["missing"]].concat(), &["cannot read", "missing", "give "]);
    }
}

#[test]
fn documents_that_will_not_do_are_named_with_what_they_should_be() {
    let home = mistakes();
    let commands: [(&[&str], &str, &str); 7] = [
        (
            &["edit", "--bundle", "scene", "--out", "new", "--operations"],
            "the operations",
            "give a list of operations",
        ),
        (&["execute", "--bundle", "scene", "--task"], "the task", "`tasks --out`"),
        (
            &["episodes", "--bundle", "scene", "--count", "1", "--out", "new", "--task"],
            "the task",
            "`tasks --out`",
        ),
        (&["judge", "--bundle", "scene", "--state", "other.json", "--task"], "the task", "`tasks --out`"),
        (&["evaluate", "--out", "new.json"], "the list of scenes", "give a file such as"),
        (
            &["episodes", "--bundle", "scene", "--count", "1", "--out", "new", "--task", "x", "--cameras"],
            "the list of cameras",
            "docs/episodes.md",
        ),
        (
            &["episodes", "--bundle", "scene", "--count", "1", "--out", "new", "--task", "x", "--randomize"],
            "the amplitudes",
            "docs/episodes.md",
        ),
    ];
    for (command, what, advice) in commands {
        let call = |file: &'static str| [command, &[file][..]].concat();
        refused(
            home.path(),
            &call("missing.json"),
            &["cannot read", what, "missing.json: there is no such file", advice],
        );
        refused(
            home.path(),
            &call("binary.json"),
            &["cannot read", what, "binary.json: it is no text", advice],
        );
        refused(home.path(), &call("empty.json"), &["empty.json", what, "it is no JSON", advice]);
        // Where a list is expected, the first brace is complained of before the missing end.
        refused(home.path(), &call("half.json"), &["half.json", what, advice]);
    }
    refused(
        home.path(),
        &["execute", "--bundle", "scene", "--task", "other.json"],
        &["other.json", "the task"],
    );
    for (arguments, says) in [
        (&["batch", "missing.jsonl", "--out", "new"][..], &["missing.jsonl", "give a .jsonl file"][..]),
        (&["batch", "a folder", "--out", "new"], &["a folder is not a file", "give a .jsonl file"]),
        (&["batch", "notes.txt", "--out", "new"], &["notes.txt is neither .jsonl"]),
        (&["generate", "--image", "notes.txt", "--out", "new"], &["--image notes.txt", "PNG, JPEG or WebP"]),
        (&["generate", "--image", "a folder", "--out", "new"], &["the image a folder", "PNG, JPEG or WebP"]),
        (&["generate", "--image", "missing.png", "--out", "new"], &["missing.png", "give a PNG"]),
        (&["check-config", "--config", "missing.toml"], &["missing.toml", "give a TOML file"]),
        (
            &["dataset", "freeze", "--name", "k", "--output-file", "missing", "--out", "new"],
            &["missing", "output.jsonl"],
        ),
        (&["dataset", "verify", "a folder"], &["a folder holds no dataset.json; give"]),
        (
            &["regenerate-episode", "--dataset", "missing", "--episode", "0", "--bundle", "scene"],
            &["cannot read the dataset missing", "`episodes --out`"],
        ),
        (
            &["regenerate-episode", "--dataset", "a folder", "--episode", "0", "--bundle", "scene"],
            &["a folder is no dataset", "`episodes --out`"],
        ),
    ] {
        refused(home.path(), arguments, says);
    }
    assert!(!home.path().join("new").exists());
}

#[test]
fn numbers_are_refused_with_argument_value_and_range() {
    let home = mistakes();
    let seeds = "from 0 to 9007199254740991";
    let episodes = ["episodes", "--bundle", "scene", "--task", "x", "--out", "new"];
    let with_count = [&episodes[..], &["--count", "1"]].concat();
    let freeze = ["dataset", "freeze", "--name", "k", "--from", "scene", "--out", "new"];
    let batch = ["batch", "requests.jsonl", "--out", "new"];
    for (command, option, range) in [
        (&["generate", "--text", "a mug", "--out", "new"][..], "--seed", seeds),
        (&["generate", "--text", "a mug", "--out", "new"], "--threads", "1 or more"),
        (&["generate", "--text", "a mug", "--out", "new"], "--max-objects", "from 1 to 64"),
        (&["parse", "a mug"], "--seed", seeds),
        (&["variants", "--bundle", "scene", "--out", "new"], "--count", "from 1 to 1000"),
        (&["tasks", "--bundle", "scene"], "--count", "from 1 to 50"),
        (&["tasks", "--bundle", "scene"], "--seed", seeds),
        (&["execute", "--bundle", "scene", "--task", "x"], "--seed", seeds),
        (&episodes, "--count", "from 1 to 100000"),
        (&with_count, "--seed", seeds),
        (&with_count, "--fps", "from 1 to 100"),
        (&with_count, "--size", "from 1 to 8192"),
        (&with_count, "--point-cloud", "from 1 to 8192"),
        (&with_count, "--workers", "1 or more"),
        (&with_count, "--max-attempts", "1 or more"),
        (&["regenerate-episode", "--dataset", "d", "--bundle", "scene"], "--episode", "0 or more"),
        (&batch, "--workers", "1 or more"),
        (&batch, "--limit", "1 or more"),
        (&batch, "--budget", "a number of US dollars"),
        (&freeze, "--seed", seeds),
        (&freeze, "--shard-mb", "from 1 to 1048576"),
        (&freeze, "--shard-scenes", "from 1 to 4294967295"),
        (&freeze, "--number", "from 1 to 4294967295"),
        (&["worker"], "--slots", "1 or more"),
    ] {
        for value in ["many", "-1.5", "99999999999999999999999"] {
            if option == "--budget" && value != "many" {
                continue;
            }
            refused(home.path(), &[command, &[option, value]].concat(), &[option, value, range]);
        }
    }
    refused(
        home.path(),
        &["check-config", "--set", "worker.concurrency=many"],
        &["\"many\"", "from 1 to 64 (jobs)"],
    );
}

#[test]
fn unknown_settings_name_a_near_key_or_what_there_is() {
    let home = mistakes();
    for (set, says, never) in [
        ("servr.x=1", "section server has", "nearest"),
        ("x=1", "the sections are", "nearest"),
        ("worker=2", "section worker has", "nearest"),
        ("worker.concurency=1", "the nearest is worker.concurrency", "sections"),
        ("server.fsync=1", "the nearest is store.fsync", "sections"),
    ] {
        refused(home.path(), &["check-config", "--set", set], &["there is no such key", says]);
        let done = run(home.path(), &["check-config", "--set", set]);
        assert!(!String::from_utf8_lossy(&done.stderr).contains(never), "{set}");
    }
}
