//! A stand-in keeps its label and is marked in every file that describes it; other bodies are not.

use super::specimen::{settings, specimen, text};
use crate::round_trip::read_back;
use crate::*;

fn written(is_stand_in: bool, form: UsdForm) -> Vec<BundleFile> {
    let (mut scene, certificate, assets, images) = specimen();
    scene.instances[1].stand_in = is_stand_in;
    write_formats(&scene, &certificate, &assets, &images, Vec::new(), &settings(form)).expect("sound")
}

/// The mark of `box_1` in every file that describes it, and its label beside it.
const MARKS: [(&str, &[&str]); 9] = [
    ("urdf/box_1/box_1.urdf", &["link=\"box_1\" text=\"box of pencils\" stand_in=\"true\""]),
    ("urdf/scene.urdf", &["link=\"box_1\" text=\"box of pencils\" stand_in=\"true\""]),
    (
        "mjcf/box_1/box_1.xml",
        &["name=\"label_box_1\" data=\"box of pencils\"", "name=\"stand_in_box_1\" data=\"true\""],
    ),
    (
        "mjcf/scene.xml",
        &["name=\"label_box_1\" data=\"box of pencils\"", "name=\"stand_in_box_1\" data=\"true\""],
    ),
    ("sdf/models/box_1/model.sdf", &["<model name=\"box_1\" tabletopgen:stand_in=\"true\">"]),
    ("sdf/world.sdf", &["<model name=\"box_1\" tabletopgen:stand_in=\"true\">"]),
    (
        "usd/assets/box_1/simready_usd/box_1.usda",
        &["displayName = \"box of pencils\"", "custom uniform bool tabletopgen:stand_in = 1"],
    ),
    ("README.md", &["| `box_1` | box of pencils (stand-in) |", "A stand-in is a plain shape"]),
    ("report.html", &["<bdi>box of pencils</bdi> <span class=\"note\">stand-in</span>"]),
];

#[test]
fn stand_ins_are_marked_in_every_format() {
    let files = written(true, UsdForm::Usda);
    for (path, marks) in MARKS {
        for mark in marks {
            let found = text(&files, path).matches(mark).count();
            assert_eq!(found, 1, "{path} has {mark} {found} times");
        }
    }
    let json =
        |path: &str| -> serde_json::Value { serde_json::from_str(text(&files, path)).expect("our own JSON") };
    assert_eq!(json("scene.json")["instances"][1]["stand_in"], true);
    assert_eq!(json("manifest.json")["assets"][2]["stand_in"], true);
    assert_eq!(json("report.json")["text"]["stand_ins"][0], "box_1");
    for path in ["glb/scene.glb", "glb/box_1.glb"] {
        let extras = r#""extras":{"label":"box of pencils","stand_in":true}"#;
        assert_eq!(occurrences(&files, path, extras), 1, "{path}");
    }
}

#[test]
fn other_bodies_have_no_mark() {
    let files = written(false, UsdForm::Usda);
    let is_written_here = |file: &&BundleFile| {
        !["json", "html"].iter().any(|ending| file.path.ends_with(ending)) && file.media_type != "image/png"
    };
    for file in files.iter().filter(is_written_here) {
        assert_eq!(occurrences(&files, &file.path, "stand_in"), 0, "{}", file.path);
        assert_eq!(occurrences(&files, &file.path, "stand-in"), 0, "{}", file.path);
    }
    let scene: serde_json::Value = serde_json::from_str(text(&files, "scene.json")).expect("our own JSON");
    assert_eq!(scene["instances"][1].get("stand_in"), None);
    // Only the namespace of the labels of URDF is written in any case.
    assert_eq!(occurrences(&files, "sdf/world.sdf", "tabletopgen"), 0);
}

#[test]
fn read_back_rejects_a_missing_or_wrong_mark() {
    let (mut scene, _, assets, _) = specimen();
    for form in [UsdForm::Usda, UsdForm::Usdc, UsdForm::Usdz] {
        for is_stand_in in [true, false] {
            let files = written(!is_stand_in, form);
            scene.instances[1].stand_in = is_stand_in;
            let bodies = body::bodies(&scene, &assets).expect("sound");
            let error = read_back(&bodies, &files).expect_err("the files tell the opposite");
            assert!(error.to_string().contains("stand-in"), "{error}");
        }
    }
}

#[test]
fn read_back_checks_the_mark_in_each_file() {
    let (scene, _, assets, _) = specimen();
    let bodies = body::bodies(&scene, &assets).expect("sound");
    let in_glb = [("glb/scene.glb", GLB_MARK), ("glb/box_1.glb", GLB_MARK)];
    let last = |marks: &[&'static str]| *marks.last().expect("a mark");
    let read: Vec<_> = MARKS[..7].iter().map(|(path, marks)| (*path, last(marks))).chain(in_glb).collect();
    for (path, mark) in read {
        let mut files = written(true, UsdForm::Usda);
        let file = files.iter_mut().find(|file| file.path == path).expect("written");
        let at = file.bytes.windows(mark.len()).position(|window| window == mark.as_bytes());
        let at = at.unwrap_or_else(|| panic!("{path} has no {mark}"));
        let without = match path.ends_with(".glb") {
            true => " ".repeat(mark.len()),
            false => mark.replace("true", "false").replace("= 1", "= 0"),
        };
        drop(file.bytes.splice(at..at + mark.len(), without.into_bytes()));
        let error = read_back(&bodies, &files).expect_err("one file tells the opposite");
        assert!(error.to_string().contains("stand-in"), "{path}: {error}");
    }
}

/// The mark among the extras of a glTF node.
const GLB_MARK: &str = ",\"stand_in\":true";

fn occurrences(files: &[BundleFile], path: &str, words: &str) -> usize {
    let file = files.iter().find(|file| file.path == path).expect("written");
    file.bytes.windows(words.len()).filter(|window| *window == words.as_bytes()).count()
}
