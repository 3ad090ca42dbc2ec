//! The `synthesize` command and the image benchmark, from outside.

use std::path::Path;
use std::process::{Command, Output};

use serde_json::Value;

fn run(directory: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_tabletopgen-lab"));
    command.args(arguments).current_dir(directory).output().expect("starts")
}

fn message(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

#[test]
fn synthesize_resumes_interrupted_run() {
    let home = tempfile::tempdir().unwrap();
    let synthesize = |count: &str| {
        let arguments = [
            "synthesize",
            "--split",
            "validation",
            "--count",
            count,
            "--size-px",
            "96",
            "--out",
            "synthetic",
        ];
        let output = run(home.path(), &arguments);
        assert_eq!(output.status.code(), Some(0), "{}", message(&output));
        message(&output)
    };
    assert!(synthesize("2").contains("2 synthesized, 0 kept"));
    let first = home.path().join("synthetic/validation/000000");
    let image = std::fs::read(first.join("image.jpg")).unwrap();
    std::fs::remove_file(first.join("truth.json")).unwrap();
    assert!(synthesize("3").contains("2 synthesized, 1 kept"));
    assert_eq!(std::fs::read(first.join("image.jpg")).unwrap(), image);
    let truth: Value = serde_json::from_slice(&std::fs::read(first.join("truth.json")).unwrap()).unwrap();
    assert_eq!((&truth["split"], &truth["number"]), (&Value::from("validation"), &Value::from(0)));
}

#[test]
fn image_benchmark_writes_tables_and_comparison_images() {
    let home = tempfile::tempdir().unwrap();
    let output = run(home.path(), &["evaluate", "--set", "images", "--scenes", "2", "--artifacts", "sheets"]);
    assert_eq!(output.status.code(), Some(0), "{}", message(&output));
    let markdown = std::fs::read_to_string(home.path().join("out/evaluate/images.md")).unwrap();
    assert_eq!(markdown, String::from_utf8_lossy(&output.stdout));
    assert!(markdown.contains("| all | 2 |"), "{markdown}");
    let json = std::fs::read(home.path().join("out/evaluate/images.json")).unwrap();
    let report: Value = serde_json::from_slice(&json).unwrap();
    assert_eq!((&report["set"], &report["set_size"]), (&Value::from("images"), &Value::from(200)));
    assert_eq!(report["images"].as_array().map(Vec::len), Some(2));
    assert!(home.path().join("sheets/0001.png").is_file());
    assert!(report.get("with_text").is_none() && !markdown.contains("Labels beside a text"));
    let with_text = ["evaluate", "--set", "images", "--scenes", "2", "--with-text", "--out", "with_text"];
    let output = run(home.path(), &with_text);
    assert_eq!(output.status.code(), Some(0), "{}", message(&output));
    let json = std::fs::read(home.path().join("with_text/images.json")).unwrap();
    let report: Value = serde_json::from_slice(&json).unwrap();
    let candidates = &report["with_text"]["groups"]["categories"];
    let count = |key: &str| candidates[key].as_u64().unwrap_or_else(|| panic!("{key}: {report}"));
    assert!(count("right_with_text") >= count("right") && count("right_with_text") > 0, "{candidates}");
    let named = run(home.path(), &["evaluate", "--set", "images", "--scene", "office"]);
    assert_eq!(named.status.code(), Some(2), "{}", message(&named));
}
