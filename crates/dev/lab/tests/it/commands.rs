//! The command line of `tabletopgen-lab`: help, and arguments that are refused before any work.

use std::path::Path;
use std::process::{Command, Output};

fn run(home: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_tabletopgen-lab")).current_dir(home).args(arguments).output().unwrap()
}

#[test]
fn help_lists_every_command() {
    let home = tempfile::tempdir().unwrap();
    let help = String::from_utf8(run(home.path(), &["--help"]).stdout).unwrap();
    for command in ["evaluate", "synthesize", "parse", "pick-place", "mock-vendors"] {
        assert!(help.contains(command), "{help}");
    }
}

#[test]
fn invalid_arguments_are_refused_before_the_work() {
    let home = tempfile::tempdir().unwrap();
    for (arguments, code, says) in [
        (vec![], 2, "Usage"),
        (vec!["evaluate"], 2, "--set <NAME>"),
        (vec!["evaluate", "--set", "layuot"], 2, "[possible values: layout, images, regions]"),
        (vec!["evaluate", "--set", "layout", "--scenes", "0"], 2, "--scenes"),
        (vec!["evaluate", "--set", "layout", "--out", "/proc/none"], 1, "cannot write /proc/none"),
        (vec!["parse", "--texts", "/proc/none"], 1, "cannot read /proc/none"),
        (vec!["pick-place", "--bundle", "/proc/none"], 2, "cannot read the bundle /proc/none"),
        (vec!["pick-place", "--bundle", ".", "--robot", "crane"], 2, "crane"),
        (vec!["dance"], 2, "unrecognized subcommand"),
    ] {
        let done = run(home.path(), &arguments);
        let complaint = String::from_utf8(done.stderr).unwrap();
        assert_eq!(done.status.code(), Some(code), "{arguments:?}: {complaint}");
        assert!(complaint.contains(says), "{arguments:?}: {complaint}");
        assert!(!complaint.contains("panicked") && done.stdout.is_empty(), "{arguments:?}: {complaint}");
        assert!(!home.path().join("out").exists(), "{arguments:?} left a folder");
    }
}
