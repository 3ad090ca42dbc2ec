//! `doctor`, and the commands that describe the program: `catalog`, `robots`, `completions`, `man`.

use std::net::TcpListener;

use serde_json::Value;

use super::commands::{run, text};

/// The checks of a run by name, with their states.
fn states(document: &Value) -> Vec<(&str, &str)> {
    let checks = document["checks"].as_array().expect("checks");
    checks.iter().map(|of| (of["check"].as_str().unwrap(), of["state"].as_str().unwrap())).collect()
}

#[test]
fn doctor_tries_everything_and_makes_a_scene() {
    let home = tempfile::tempdir().unwrap();
    let taken = TcpListener::bind("127.0.0.1:0").unwrap();
    let listen = format!("server.listen={}", taken.local_addr().unwrap());
    let output = run(home.path(), &["doctor", "--json", "--set", &listen, "--set", "compute.device=cpu"]);
    let document: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    assert_eq!(output.status.code(), Some(0), "{document:#}");
    let expected = [
        ("program", "ok"),
        ("configuration", "ok"),
        ("models", "ok"),
        ("gpu", "skipped"),
        ("store", "ok"),
        ("address", "warning"),
        ("scene", "ok"),
    ];
    let states = states(&document);
    for check in expected {
        assert!(states.contains(&check), "{check:?} is not in {document:#}");
    }
    assert!(!home.path().join("data").exists(), "a check made the data directory");
}

#[test]
fn doctor_says_what_is_wrong_and_fails() {
    let home = tempfile::tempdir().unwrap();
    std::fs::write(home.path().join("wrong.toml"), "[dro]\nkeeep = 2\n").unwrap();
    let output = run(home.path(), &["doctor", "--config", "wrong.toml"]);
    assert_eq!(output.status.code(), Some(1));
    assert!(text(&output.stdout).contains("the nearest is dro.keep"), "{}", text(&output.stdout));

    std::fs::create_dir(home.path().join("data")).unwrap();
    std::fs::write(home.path().join("data/tabletopgen.sqlite"), "no database").unwrap();
    let output = run(home.path(), &["doctor", "--no-scene", "--json", "--set", "server.listen=192.0.2.1:80"]);
    assert_eq!(output.status.code(), Some(1));
    let document: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let states = states(&document);
    for check in [("store", "failed"), ("address", "failed"), ("scene", "skipped")] {
        assert!(states.contains(&check), "{check:?} is not in {document:#}");
    }
}

#[test]
fn the_usual_configuration_file_is_read() {
    let home = tempfile::tempdir().unwrap();
    let folder = home.path().join("tabletopgen");
    std::fs::create_dir(&folder).unwrap();
    std::fs::write(folder.join("config.toml"), "[dro]\nkeep = 3\n").unwrap();
    let checked = |name: &str, value: &std::path::Path| {
        let mut command = super::commands::tabletopgen(home.path(), &["check-config"]);
        let output = command.env(name, value).output().expect("starts");
        text(&output.stdout)
    };
    assert!(checked("XDG_CONFIG_HOME", home.path()).contains("keep = 3  # file"));
    assert!(checked("TABLETOPGEN_CONFIG", &folder.join("config.toml")).contains("keep = 3  # file"));
    assert!(checked("TABLETOPGEN_CONFIG", &folder.join("none.toml")).is_empty());
    assert!(!checked("XDG_CONFIG_HOME", &folder).contains("keep = 3"));
}

#[test]
fn quiet_writes_no_notes() {
    let home = tempfile::tempdir().unwrap();
    let arguments = ["keys", "create", "--name", "arm"];
    assert_eq!(run(home.path(), &["migrate", "--create"]).status.code(), Some(0));
    assert!(!run(home.path(), &arguments).stderr.is_empty());
    let quiet = run(home.path(), &[&["--quiet"][..], &arguments[..]].concat());
    assert!(quiet.stderr.is_empty() && text(&quiet.stdout).starts_with("tt_"));
    let complaint = run(home.path(), &["-q", "generate", "--text", " "]);
    assert!(text(&complaint.stderr).contains("--text is empty"));
}

#[test]
fn shells_and_manuals_know_every_command() {
    let home = tempfile::tempdir().unwrap();
    for shell in ["bash", "zsh", "fish"] {
        let script = text(&run(home.path(), &["completions", shell]).stdout);
        assert!(script.contains("check-config") && script.contains("max-objects"), "{shell}");
    }
    assert!(text(&run(home.path(), &["man"]).stdout).contains(".TH tabletopgen"));
    assert_eq!(run(home.path(), &["man", "--out", "man"]).status.code(), Some(0));
    let page = std::fs::read_to_string(home.path().join("man/tabletopgen-generate.1")).unwrap();
    assert!(page.contains("max\\-objects") && page.contains("Example"), "{page}");
}

#[test]
fn the_catalog_and_the_robots_are_listed() {
    let home = tempfile::tempdir().unwrap();
    let list = |arguments: &[&str]| -> Value {
        let output = run(home.path(), arguments);
        serde_json::from_slice(&output.stdout).unwrap_or_else(|_| panic!("{}", text(&output.stderr)))
    };
    let all = list(&["catalog", "list", "--json"]);
    assert!(all["categories"].as_array().unwrap().len() > 400);
    let cutlery = list(&["catalog", "list", "--group", "cutlery", "--json"]);
    let names: Vec<&str> =
        cutlery["categories"].as_array().unwrap().iter().map(|of| of["name"].as_str().unwrap()).collect();
    assert!(names.contains(&"fork") && !names.contains(&"mug"), "{names:?}");
    assert_eq!(list(&["catalog", "show", "mug", "--json"])["name"], "mug");
    assert!(text(&run(home.path(), &["catalog", "show", "mug"]).stdout).contains("substance"));
    assert_eq!(run(home.path(), &["catalog", "show", "zorgle"]).status.code(), Some(2));
    let refused = run(home.path(), &["catalog", "list", "--group", "zorgle"]);
    assert!(text(&refused.stderr).contains("cutlery"), "{}", text(&refused.stderr));
    let robots = list(&["robots", "--json"]);
    assert_eq!(robots["robots"][0]["name"], "panda");
}
