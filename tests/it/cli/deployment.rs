//! The settings that the files of `docker/` give are settings of the program.

use std::path::Path;
use std::process::Command;

use serde_json::Value;

fn file(name: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("docker").join(name);
    std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// Checks a configuration of these variables and options.
fn check(environment: &[(String, String)], options: &[&str]) {
    let home = tempfile::tempdir().unwrap();
    let done = Command::new(env!("CARGO_BIN_EXE_tabletopgen"))
        .arg("check-config")
        .args(options)
        .envs(environment.iter().cloned())
        .current_dir(home.path())
        .output()
        .expect("starts");
    assert!(done.status.success(), "{environment:?}: {}", String::from_utf8_lossy(&done.stderr));
}

#[test]
fn image_sets_valid_settings() {
    let dockerfile = file("Dockerfile").replace("\\\n", " ");
    let pairs =
        dockerfile.lines().filter_map(|line| line.strip_prefix("ENV ")).flat_map(str::split_whitespace);
    let environment: Vec<(String, String)> = pairs
        .filter_map(|pair| pair.split_once('='))
        .map(|(name, value)| (name.to_owned(), value.to_owned()))
        .collect();
    assert!(environment.iter().any(|(name, _)| name == "TABLETOPGEN__WORKER__LISTEN"), "{environment:?}");
    check(&environment, &[]);
}

#[test]
fn compose_sets_valid_settings() {
    let compose: Value = serde_norway::from_str(&file("compose.yaml")).expect("is YAML");
    let variables = compose["x-tabletopgen"]["environment"].as_object().expect("has an environment");
    let environment: Vec<(String, String)> = variables
        .iter()
        .map(|(name, value)| (name.clone(), value.as_str().expect("is a text").to_owned()))
        .collect();
    assert!(environment.iter().any(|(name, _)| name == "TABLETOPGEN_DATABASE_URL"), "{environment:?}");
    check(&environment, &[]);
}

#[test]
fn kubernetes_sets_valid_settings() {
    let home = tempfile::tempdir().unwrap();
    let settings = home.path().join("settings.toml");
    std::fs::write(&settings, file("kubernetes/settings.toml")).unwrap();
    let secrets = file("kubernetes/example.env");
    let pairs = secrets.lines().filter(|line| !line.starts_with('#')).filter_map(|line| line.split_once('='));
    let environment: Vec<(String, String)> =
        pairs.map(|(name, value)| (name.to_owned(), value.to_owned())).collect();
    check(&environment, &["--config", settings.to_str().unwrap()]);
}
