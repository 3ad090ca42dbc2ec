//! `execute` and `judge`, from outside: what is written, and that both decide alike.

use std::path::Path;
use std::process::{Command, Output};

use serde_json::{Value, json};

fn run(directory: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_tabletopgen"));
    command.args(arguments).current_dir(directory).output().expect("starts")
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

fn read(path: &Path) -> Value {
    serde_json::from_slice(&std::fs::read(path).expect("written")).expect("JSON")
}

/// The state of the objects in a frame of the record.
fn state(trajectory: &Value, frame: &Value) -> Value {
    let names = trajectory["objects"].as_array().expect("names").iter();
    let poses = frame["object_poses"].as_array().expect("poses");
    let objects: serde_json::Map<String, Value> = names
        .zip(poses)
        .map(|(name, pose)| (name.as_str().expect("a name").to_owned(), pose.clone()))
        .collect();
    json!({ "objects": objects })
}

#[test]
fn an_executed_task_is_done_in_the_last_frame_and_not_in_the_first() {
    let home = tempfile::tempdir().expect("a folder");
    let at = home.path();
    let made =
        run(at, &["generate", "--text", "A table with a block and a plate", "--seed", "3", "--out", "scene"]);
    assert!(made.status.success(), "{}", text(&made.stderr));
    let instruction = "put the block on the plate";
    let done = run(at, &["execute", "--bundle", "scene", "--task", instruction, "--out", "run", "--video"]);
    assert!(done.status.success(), "{}{}", text(&done.stdout), text(&done.stderr));

    let files = ["execution.json", "task.json", "trajectory.json", "trajectory.parquet", "video.mp4"];
    let in_scene = ["mjcf/scene_with_panda.xml", "urdf/scene_with_panda.urdf", "usd/scene_with_panda.usda"];
    for file in files.into_iter().chain(in_scene).chain(["mjcf/panda.xml", "mjcf/scene.xml"]) {
        let size = std::fs::metadata(at.join("run").join(file)).map_or(0, |about| about.len());
        assert!(size > 100, "{file} has {size} bytes");
    }
    let again = run(at, &["execute", "--bundle", "scene", "--task", "run/task.json", "--out", "again"]);
    assert!(again.status.success(), "{}", text(&again.stderr));
    let bytes = |folder: &str| std::fs::read(at.join(folder).join("trajectory.json")).expect("written");
    assert_eq!(bytes("run"), bytes("again"), "the same motion, whether the task came as words or as a file");

    let trajectory = read(&at.join("run/trajectory.json"));
    let frames = trajectory["frames"].as_array().expect("frames");
    for (frame, code, reached) in [(&frames[0], 6, false), (&frames[frames.len() - 1], 0, true)] {
        std::fs::write(at.join("state.json"), state(&trajectory, frame).to_string()).expect("written");
        let arguments =
            ["judge", "--bundle", "scene", "--task", "run/task.json", "--state", "state.json", "--json"];
        let judged = run(at, &arguments);
        assert_eq!(judged.status.code(), Some(code), "{}", text(&judged.stderr));
        let verdict: Value = serde_json::from_slice(&judged.stdout).expect("JSON");
        assert_eq!(verdict["reached"], reached);
    }
    check_given_bases(at);
    std::fs::write(at.join("state.json"), r#"{"objects": {"spoon_9": {"translation_m": [0, 0, 0]}}}"#)
        .expect("written");
    let arguments = ["judge", "--bundle", "scene", "--task", "run/task.json", "--state", "state.json"];
    let refused = run(at, &arguments);
    assert_eq!(refused.status.code(), Some(2), "{}", text(&refused.stdout));
    assert!(
        text(&refused.stderr).contains("state.json cannot be read as the state"),
        "{}",
        text(&refused.stderr)
    );
}

/// The base stands at a given place, and is refused where the arm is not free.
fn check_given_bases(at: &Path) {
    let chosen = read(&at.join("run/execution.json"))["execution"]["world_from_base"].clone();
    let part = |list: &str, k: usize| chosen[list][k].as_f64().expect("a number");
    let (x_m, y_m, z_m) = (part("translation_m", 0), part("translation_m", 1), part("translation_m", 2));
    let yaw_rad = 2.0 * part("rotation_xyzw", 2).atan2(part("rotation_xyzw", 3));
    let with_base = |base: &str| {
        run(at, &["execute", "--bundle", "scene", "--task", "run/task.json", "--base", base, "--json"])
    };
    let done = with_base(&format!("{x_m},{y_m},{z_m},{yaw_rad}"));
    assert!(done.status.success(), "{}", text(&done.stderr));
    let printed: Value = serde_json::from_slice(&done.stdout).expect("JSON");
    let found = &printed["execution"]["world_from_base"];
    for (list, count) in [("translation_m", 3), ("rotation_xyzw", 4)] {
        for k in 0..count {
            let off = found[list][k].as_f64().expect("a number") - part(list, k);
            assert!(off.abs() < 1e-9, "{list} {k} of {found} and {chosen}");
        }
    }
    for (base, expected) in [("0,0,-0.3,0", "base_not_free"), ("5,0,0.02,0", "table_out_of_reach")] {
        let refused = with_base(base);
        assert_eq!(refused.status.code(), Some(2), "{base}: {}", text(&refused.stdout));
        let printed: Value = serde_json::from_slice(&refused.stdout).expect("JSON");
        assert_eq!(printed["failure"]["problem"]["code"], expected, "{base}: {printed}");
    }
    for base in ["1,2,3", "a,b,c,d", "0,0,0,NaN", "99,0,0,0"] {
        assert_eq!(with_base(base).status.code(), Some(2), "{base}");
    }
}
