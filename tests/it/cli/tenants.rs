//! `tenants`: limits of one tenant, set and shown beside a data directory.

use std::path::Path;
use std::process::{Command, Output};

use serde_json::{Value, json};

fn run(home: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_tabletopgen"));
    command
        .env_remove("RUST_LOG")
        .args(arguments)
        .args(["--data-dir", "d"])
        .current_dir(home)
        .output()
        .expect("starts")
}

fn shown(output: &Output) -> Value {
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    serde_json::from_slice(&output.stdout).expect("is JSON")
}

#[test]
fn limits_of_a_tenant_are_set_shown_and_given_back() {
    let home = tempfile::tempdir().unwrap();
    let missing = run(home.path(), &["tenants", "show"]);
    assert_eq!(missing.status.code(), Some(1), "{missing:?}");
    assert_eq!(run(home.path(), &["migrate", "--create"]).status.code(), Some(0));
    assert_eq!(shown(&run(home.path(), &["tenants", "show", "--json"])), json!({ "tenants": [] }));

    let limits = ["tenants", "limit", "lab", "--waiting-jobs", "7", "--usd-per-month", "2.5", "--json"];
    let document = shown(&run(home.path(), &limits));
    let lab = &document["tenants"][0];
    assert_eq!(lab["tenant"], "lab");
    assert_eq!(lab["limits"]["waiting_jobs"], json!({ "max": 7, "used": 0, "is_own": true }));
    assert_eq!(lab["limits"]["usd_per_month"], json!({ "max": 2.5, "used": 0.0, "is_own": true }));
    assert_eq!(lab["limits"]["running_jobs"], json!({ "max": null, "used": 0, "is_own": false }));

    let usual = ["tenants", "limit", "lab", "--waiting-jobs", "usual", "--usd-per-month", "0", "--json"];
    let lab = &shown(&run(home.path(), &usual))["tenants"][0];
    assert_eq!(lab["limits"]["waiting_jobs"], json!({ "max": 10000, "used": 0, "is_own": false }));
    assert_eq!(lab["limits"]["usd_per_month"]["max"], Value::Null);
    let text = run(home.path(), &["tenants", "show", "lab"]);
    let text = String::from_utf8(text.stdout).unwrap();
    assert!(text.contains("lab\n") && text.contains("  waiting_jobs: 0 of 10000\n"), "{text}");

    for (arguments, says) in [
        (vec!["tenants", "limit", "lab"], "give a limit"),
        (vec!["tenants", "limit", "lab", "--bytes=-1"], "whole number"),
        (vec!["tenants", "limit", "lab", "--usd-per-month=-1"], "US dollars"),
        (vec!["tenants", "limit", "two words", "--bytes", "1"], "two words"),
    ] {
        let refused = run(home.path(), &arguments);
        assert_eq!(refused.status.code(), Some(2), "{arguments:?}: {refused:?}");
        let text = String::from_utf8(refused.stderr).unwrap();
        assert!(text.contains(says), "{arguments:?}: {text}");
    }
}
