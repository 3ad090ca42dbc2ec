//! Painting pictures and the benchmark of reading them, from outside.

use std::path::Path;
use std::process::{Command, Output};

use serde_json::Value;

fn run(directory: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_tabletopgen"));
    command.args(arguments).current_dir(directory).output().expect("starts")
}

fn told(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

#[test]
fn painting_goes_on_where_it_was() {
    let home = tempfile::tempdir().unwrap();
    let paint = |count: &str| {
        let arguments = [
            "paint-pictures",
            "--split",
            "validation",
            "--count",
            count,
            "--size-px",
            "96",
            "--out",
            "painted",
        ];
        let output = run(home.path(), &arguments);
        assert_eq!(output.status.code(), Some(0), "{}", told(&output));
        told(&output)
    };
    assert!(paint("2").contains("2 painted, 0 were there"));
    let first = home.path().join("painted/validation/000000");
    let picture = std::fs::read(first.join("picture.jpg")).unwrap();
    std::fs::remove_file(first.join("truth.json")).unwrap();
    assert!(paint("3").contains("2 painted, 1 were there"));
    assert_eq!(std::fs::read(first.join("picture.jpg")).unwrap(), picture);
    let truth: Value = serde_json::from_slice(&std::fs::read(first.join("truth.json")).unwrap()).unwrap();
    assert_eq!((&truth["split"], &truth["number"]), (&Value::from("validation"), &Value::from(0)));
}

#[test]
fn the_picture_benchmark_writes_its_tables_and_sheets() {
    let home = tempfile::tempdir().unwrap();
    let output =
        run(home.path(), &["evaluate", "--set", "pictures", "--scenes", "2", "--artifacts", "sheets"]);
    assert_eq!(output.status.code(), Some(0), "{}", told(&output));
    let markdown = std::fs::read_to_string(home.path().join("out/evaluate/pictures.md")).unwrap();
    assert_eq!(markdown, String::from_utf8_lossy(&output.stdout));
    assert!(markdown.contains("| all | 2 |"), "{markdown}");
    let json = std::fs::read(home.path().join("out/evaluate/pictures.json")).unwrap();
    let report: Value = serde_json::from_slice(&json).unwrap();
    assert_eq!((&report["set"], &report["set_size"]), (&Value::from("pictures"), &Value::from(200)));
    assert_eq!(report["pictures"].as_array().map(Vec::len), Some(2));
    assert!(home.path().join("sheets/0001.png").is_file());
    let named = run(home.path(), &["evaluate", "--set", "pictures", "--scene", "office"]);
    assert_eq!(named.status.code(), Some(2), "{}", told(&named));
}
