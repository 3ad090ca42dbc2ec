//! A stand-in keeps its label and is marked in every file that describes it; other bodies are not.

use super::specimen::{settings, specimen, text};
use crate::round_trip::read_back;
use crate::*;
use scene::StandIn;

fn pencil_case() -> StandIn {
    StandIn { stands_for: "pencil case".into(), shown_as: "box".into() }
}

fn written(is_stand_in: bool, form: UsdForm) -> Vec<BundleFile> {
    let (mut scene, certificate, assets, images) = specimen();
    scene.instances[1].stand_in = is_stand_in.then(pencil_case);
    write_formats(&scene, &certificate, &assets, &images, Vec::new(), &settings(form)).expect("sound")
}

const IN_URDF: &[&str] = &[
    "link=\"box_1\" text=\"box of pencils\" stand_in=\"true\" stands_for=\"pencil case\" shown_as=\"box\"",
    "stands_for=\"pencil case\"",
    "shown_as=\"box\"",
    "stand_in=\"true\"",
];

const IN_MJCF: &[&str] = &[
    "name=\"label_box_1\" data=\"box of pencils\"",
    "name=\"stands_for_box_1\" data=\"pencil case\"",
    "name=\"shown_as_box_1\" data=\"box\"",
    "name=\"stand_in_box_1\" data=\"true\"",
];

const IN_SDF: &[&str] = &[
    "<model name=\"box_1\" tabletopgen:stand_in=\"true\" tabletopgen:stands_for=\"pencil case\" \
     tabletopgen:shown_as=\"box\">",
    "tabletopgen:stands_for=\"pencil case\"",
    "tabletopgen:shown_as=\"box\"",
    "tabletopgen:stand_in=\"true\"",
];

const IN_USD: &[&str] = &[
    "displayName = \"box of pencils\"",
    "custom uniform string tabletopgen:stands_for = \"pencil case\"",
    "custom uniform string tabletopgen:shown_as = \"box\"",
    "custom uniform bool tabletopgen:stand_in = 1",
];

/// The label of `box_1` in every file that describes it, then the parts of its mark, each once.
const MARKS: [(&str, &[&str]); 9] = [
    ("urdf/box_1/box_1.urdf", IN_URDF),
    ("urdf/scene.urdf", IN_URDF),
    ("mjcf/box_1/box_1.xml", IN_MJCF),
    ("mjcf/scene.xml", IN_MJCF),
    ("sdf/models/box_1/model.sdf", IN_SDF),
    ("sdf/world.sdf", IN_SDF),
    ("usd/assets/box_1/simready_usd/box_1.usda", IN_USD),
    (
        "README.md",
        &[
            "| `box_1` | box of pencils (stand-in, shown as: box) |",
            "A stand-in is another body, or a plain shape",
        ],
    ),
    (
        "report.html",
        &["<bdi>box of pencils</bdi> <span class=\"note\">stand-in for pencil case, shown as box</span>"],
    ),
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
    for marked in [&json("scene.json")["instances"][1], &json("manifest.json")["assets"][2]] {
        assert_eq!(marked["stand_in"], true);
        assert_eq!((&marked["stands_for"], &marked["shown_as"]), (&"pencil case".into(), &"box".into()));
    }
    assert_eq!(json("report.json")["text"]["stand_ins"][0], "box_1");
    for path in ["glb/scene.glb", "glb/box_1.glb"] {
        let extras = format!(r#""extras":{{"label":"box of pencils"{}}}"#, IN_GLB.concat());
        assert_eq!(occurrences(&files, path, &extras), 1, "{path}");
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
            scene.instances[1].stand_in = is_stand_in.then(pencil_case);
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
    let in_xml = MARKS[..7].iter().flat_map(|(path, marks)| marks[1..].iter().map(|mark| (*path, *mark)));
    let in_glb = ["glb/scene.glb", "glb/box_1.glb"].into_iter();
    let read = in_xml.chain(in_glb.flat_map(|path| IN_GLB.map(|mark| (path, mark))));
    for (path, mark) in read {
        let mut files = written(true, UsdForm::Usda);
        let file = files.iter_mut().find(|file| file.path == path).expect("written");
        let at = file.bytes.windows(mark.len()).position(|window| window == mark.as_bytes());
        let at = at.unwrap_or_else(|| panic!("{path} has no {mark}"));
        let without = match path.ends_with(".glb") {
            true => " ".repeat(mark.len()),
            false => ["true", "pencil case", "\"box\"", "= 1"]
                .iter()
                .zip(["false", "pencil cask", "\"bar\"", "= 0"])
                .fold(mark.to_owned(), |mark, (right, wrong)| mark.replace(right, wrong)),
        };
        drop(file.bytes.splice(at..at + mark.len(), without.into_bytes()));
        let error = read_back(&bodies, &files).expect_err("one file tells the opposite");
        assert!(error.to_string().contains("stand-in"), "{path}: {error}");
    }
}

/// The mark among the extras of a glTF node.
const IN_GLB: [&str; 3] = [",\"stand_in\":true", ",\"stands_for\":\"pencil case\"", ",\"shown_as\":\"box\""];

fn occurrences(files: &[BundleFile], path: &str, words: &str) -> usize {
    let file = files.iter().find(|file| file.path == path).expect("written");
    file.bytes.windows(words.len()).filter(|window| *window == words.as_bytes()).count()
}
