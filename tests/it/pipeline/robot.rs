//! A robot that a request names is tried in the finished scene, and a request without one gives the scene as ever.

use std::path::Path;
use std::process::Command;

use serde_json::{Value, json};

/// Fewer trials than usual, so that they take seconds.
const FEW: [&str; 6] =
    ["--set", "grasps.max_trials=8", "--set", "grasps.wanted_stable=2", "--set", "grasps.surface_points=300"];

fn made(folder: &Path, arguments: &[&str]) -> Value {
    let done = Command::new(env!("CARGO_BIN_EXE_tabletopgen"))
        .args(arguments)
        .args(["--data-dir", "data", "--json"])
        .args(FEW)
        .current_dir(folder)
        .output()
        .unwrap();
    assert!(done.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&done.stderr));
    serde_json::from_slice(&done.stdout).expect("is JSON")
}

fn stage<'a>(document: &'a Value, name: &str) -> Option<&'a Value> {
    document["stages"].as_array().unwrap().iter().find(|stage| stage["stage"] == name)
}

#[test]
fn a_robot_is_tried_in_the_finished_scene_and_only_where_one_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let read = |path: &str| std::fs::read_to_string(folder.join(path)).unwrap();
    let json_of = |path: &str| -> Value { serde_json::from_str(&read(path)).unwrap() };
    let text = ["generate", "--text", "a mug and a plate", "--seed", "5"];
    let plain = made(folder, &[&text[..], &["--out", "plain"]].concat());
    let tried = made(folder, &[&text[..], &["--out", "tried", "--robot", "panda"]].concat());

    // All that the robot does not decide is found, and the rest is computed.
    assert_eq!(stage(&tried, "resolve").unwrap()["found"], 1);
    let grasp = stage(&tried, "grasp").expect("a stage");
    let graspable = grasp["instances"].as_u64().unwrap();
    assert!(graspable > 0 && grasp["found"] == 0, "{grasp}");
    assert_eq!(stage(&tried, "rehearse").expect("a stage")["found"], 0);
    assert!(stage(&plain, "grasp").is_none() && stage(&plain, "rehearse").is_none());

    let (scene, report) = (json_of("tried/scene.json"), json_of("tried/report.json"));
    assert_eq!(
        (&scene["request"]["version"], &scene["request"]["options"]["robot"]),
        (&json!(3), &json!("panda"))
    );
    let mug = scene["instances"].as_array().unwrap().iter().find(|object| object["name"] == "mug_1").unwrap();
    let grasps = mug["grasps"]["grasps"].as_array().expect("grasps");
    assert!(!grasps.is_empty() && grasps.len() <= 10 && mug["grasps"]["robot"] == "panda", "{mug}");
    assert!(grasps.iter().all(|grasp| grasp["verdict"] == "stable" && grasp["slip_m"].as_f64() < Some(1e-3)));
    let yaml: serde_norway::Value = serde_norway::from_str(&read("tried/grasps/mug_1.yaml")).expect("YAML");
    assert_eq!(
        (yaml["format"].as_str(), yaml["object_frame"].as_str()),
        (Some("isaac_grasp"), Some("mug_1"))
    );
    assert_eq!(yaml["grasps"].as_mapping().map(serde_norway::Mapping::len), Some(grasps.len()));
    let position = grasps[0]["object_from_tool"]["translation_m"][2].as_f64();
    assert_eq!(yaml["grasps"]["grasp_0"]["position"][2].as_f64(), position);
    assert!(read("tried/README.md").contains("## Grasps"));

    let robot = &report["robot"];
    assert_eq!(*robot, tried["summary"]["robot"]);
    let count = |name: &str| robot[name].as_u64().unwrap();
    assert_eq!((&robot["name"], count("objects")), (&json!("panda"), graspable));
    assert!((1..=graspable).contains(&count("pickable")), "{robot}");
    let tasks = robot["tasks"].as_array().unwrap();
    assert_eq!(tasks.len() as u64, count("tasks_proposed"));
    let done = tasks.iter().filter(|task| task["outcome"] == "done").count() as u64;
    assert!((1..=3).contains(&count("tasks_proposed")) && done == count("tasks_done"), "{robot}");
    assert!(read("tried/report.html").contains("panda picks up"));

    // The scene is the same, and nothing of a robot is where none was named.
    let (plain_scene, plain_report) = (json_of("plain/scene.json"), json_of("plain/report.json"));
    for (a, b) in
        scene["instances"].as_array().unwrap().iter().zip(plain_scene["instances"].as_array().unwrap())
    {
        let mut a = a.clone();
        a.as_object_mut().unwrap().shift_remove("grasps");
        assert_eq!(a, *b);
    }
    assert!(!folder.join("plain/grasps").exists() && plain_report.get("robot").is_none());
    assert_eq!(
        (&plain_scene["request"]["version"], &plain_scene["request"]["options"]),
        (&json!(1), &json!({}))
    );
    let settings = |report: &Value| report["made_with"]["settings"].get("grasps").is_some();
    assert!(settings(&report) && !settings(&plain_report));
    assert!(!read("plain/README.md").contains("## Grasps"));

    // A variant with another layout has the same objects, whose grasps are found.
    let variant = ["variants", "--bundle", "plain", "--count", "1", "--vary", "layout", "--robot", "panda"];
    let variants = made(folder, &[&variant[..], &["--seed", "3", "--out", "variants"]].concat());
    let grasp = stage(&variants[0], "grasp").expect("a stage");
    assert_eq!(
        (grasp["instances"].as_u64(), grasp["found"].as_u64()),
        (Some(graspable), Some(graspable)),
        "{grasp}"
    );
    let scene = json_of("variants/variant_0001/scene.json");
    let again =
        scene["instances"].as_array().unwrap().iter().find(|object| object["name"] == "mug_1").unwrap();
    assert_eq!(again["grasps"], mug["grasps"]);
    assert_ne!(again["translation_m"], mug["translation_m"]);
}
