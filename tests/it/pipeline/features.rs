//! The feature port's adapters, from outside: weights are checked before the work, and the certificate names who made
//! its appearance score.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use serde_json::Value;

fn run(directory: &Path, arguments: &[String]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_tabletopgen"));
    command.args(arguments).current_dir(directory).output().expect("starts")
}

/// A small model with random weights.
fn golden() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden/dinov2/mlp")
}

fn with_weights(command: &[&str], weights: &Path) -> Vec<String> {
    let weights = format!("features.weights={}", weights.display());
    let set = ["--set", "features.adapter=dinov2", "--set", weights.as_str()];
    command.iter().chain(&set).map(|word| word.to_string()).collect()
}

#[test]
fn weights_that_will_not_do_are_said_before_the_work() {
    let home = tempfile::tempdir().unwrap();
    let broken = home.path().join("broken");
    std::fs::create_dir(&broken).unwrap();
    std::fs::copy(golden().join("config.json"), broken.join("config.json")).unwrap();
    let swiglu = golden().with_file_name("swiglu").join("model.safetensors");
    std::fs::copy(swiglu, broken.join("model.safetensors")).unwrap();
    let missing = home.path().join("missing");
    for (weights, says) in [
        (&missing, "missing: No such file"),
        (&broken, "tensor embeddings.patch_embeddings.projection.weight has shape"),
    ] {
        for command in [
            vec!["check-config"],
            vec!["generate", "--text", "a mug"],
            vec!["serve", "--listen", "127.0.0.1:0"],
        ] {
            let done = run(home.path(), &with_weights(&command, weights));
            let complaint = String::from_utf8(done.stderr).unwrap();
            assert_eq!(done.status.code(), Some(2), "{command:?}: {complaint}");
            assert!(complaint.contains("features.weights (--set): "), "{command:?}: {complaint}");
            assert!(complaint.contains(says), "{command:?}: {complaint}");
            assert!(done.stdout.is_empty(), "{command:?}");
        }
    }
    let done = run(home.path(), &with_weights(&["check-config"], &golden()));
    assert_eq!(done.status.code(), Some(0), "{}", String::from_utf8_lossy(&done.stderr));
}

#[test]
fn the_certificate_names_the_extractor_of_its_score() {
    let home = tempfile::tempdir().unwrap();
    let appearance = |arguments: Vec<String>, folder: &str| {
        let done = run(home.path(), &arguments);
        assert_eq!(done.status.code(), Some(0), "{}", String::from_utf8_lossy(&done.stderr));
        let report = std::fs::read(home.path().join(folder).join("report.json")).unwrap();
        let report: Value = serde_json::from_slice(&report).unwrap();
        let found = report["fidelity"]["appearance"].clone();
        assert!(found["similarity"].as_f64().is_some_and(|score| score.abs() < 1.001), "{found}");
        (found["extractor"].as_str().unwrap().to_owned(), found["model"].as_str().unwrap().to_owned())
    };
    let command = |folder| ["generate", "--text", "A mug and a bowl", "--seed", "3", "--out", folder];
    let plain = appearance(command("plain").map(str::to_owned).to_vec(), "plain");
    assert_eq!(plain, ("embedded/descriptor".to_owned(), "1".to_owned()));
    let (extractor, model) = appearance(with_weights(&command("learned"), &golden()), "learned");
    assert_eq!(extractor, "embedded/dinov2");
    assert!(model.starts_with("1 sha256:") && model.len() == 73, "{model}");
}
