//! `edit` and `diff`, from outside: what is refused before any work, and what two bundles differ in.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use imaging::Image;
use imaging::codec::{decode_png, encode_png};
use serde_json::{Value, json};
use store::Digest;

fn run(directory: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_tabletopgen"));
    command.args(arguments).current_dir(directory).output().expect("starts")
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).expect("is UTF-8")
}

/// `scene.json` of a mug at `x_m` on a desk.
fn scene(x_m: f64) -> Value {
    json!({
        "format": "tabletopgen-scene/1", "id": "0a1b", "seed": 7,
        "request": { "version": 1, "input": { "kind": "text", "text": "a mug" }, "seed": 7, "options": {} },
        "frame": { "up": "+z", "handedness": "right", "origin": "center", "units": "meters" },
        "camera": {
            "width_px": 96, "height_px": 72, "fx": 150.0, "fy": 150.0, "cx": 48.0, "cy": 36.0,
            "world_from_camera": { "translation_m": [0.0, -1.0, 1.0], "rotation_xyzw": [1.0, 0.0, 0.0, 0.0] },
        },
        "table": {
            "name": "table", "label": "desk", "shape": "rectangular",
            "outline_m": [[0.5, 0.4], [-0.5, 0.4], [-0.5, -0.4], [0.5, -0.4]], "height_m": 0.7, "model": "desk",
            "size_m": [1.0, 0.8, 0.7], "mass_kg": 20.0, "center_of_mass_m": [0.0, 0.0, -0.3],
            "inertia_diagonal_kg_m2": [1.0, 1.0, 1.0], "principal_axes_xyzw": [0.0, 0.0, 0.0, 1.0],
            "friction": { "static": 0.5, "dynamic": 0.4 }, "restitution": 0.2, "hulls": 5, "mesh": "glb/table.glb",
        },
        "instances": [{
            "name": "mug_1", "label": "mug", "category": "mug", "image": { "bbox_px": [0, 0, 9, 9] },
            "translation_m": [x_m, 0.0, 0.0], "rotation_xyzw": [0.0, 0.0, 0.0, 1.0], "yaw_rad": 0.0,
            "symmetry_order": 1, "scale": [1.0, 1.0, 1.0], "size_m": [0.1, 0.1, 0.1], "mass_kg": 0.3,
            "center_of_mass_m": [0.0, 0.0, 0.05], "inertia_diagonal_kg_m2": [1e-3, 1e-3, 1e-3],
            "principal_axes_xyzw": [0.0, 0.0, 0.0, 1.0], "friction": { "static": 0.5, "dynamic": 0.4 },
            "restitution": 0.2, "support": { "parent": "table", "relation": "on" }, "hulls": 1,
            "mesh": "glb/mug_1.glb",
            "provenance": { "mesh_by": "embedded/catalog", "licence": "CC0-1.0", "notes": [] },
        }],
        "metrics": { "col_o": 0.0, "col_s": 0.0, "ss": 1.0, "dss_aligned": 1.0, "dss_shipped": 1.0 },
    })
}

/// Writes the files that the commands read of a bundle, and their manifest.
pub(super) fn bundle(home: &Path, name: &str, x_m: f64) -> PathBuf {
    let mut top = Image::filled(20, 10, [200, 190, 180, 255]);
    top.set_pixel((10.0 + x_m * 10.0) as u32, 5, [20, 20, 20, 255]);
    let files = [
        ("scene.json", scene(x_m).to_string().into_bytes()),
        ("preview/top.png", encode_png(&top)),
        ("glb/mug_1.glb", b"a mesh that both bundles have".to_vec()),
        ("glb/table.glb", b"another one".to_vec()),
    ];
    let folder = home.join(name);
    let listed = files.map(|(path, bytes)| {
        std::fs::create_dir_all(folder.join(path).parent().unwrap()).unwrap();
        std::fs::write(folder.join(path), &bytes).unwrap();
        json!({
            "path": path, "sha256": Digest::of(&bytes).as_str(), "size": bytes.len(), "role": "file",
            "media_type": "application/octet-stream",
        })
    });
    let manifest = json!({ "format": "tabletopgen-manifest/1", "files": listed });
    std::fs::write(folder.join("manifest.json"), manifest.to_string()).unwrap();
    folder
}

#[test]
fn an_edit_that_will_not_do_is_refused_before_the_work() {
    let home = tempfile::tempdir().unwrap();
    bundle(home.path(), "mug", 0.0);
    let changed = bundle(home.path(), "changed", 0.0);
    std::fs::write(changed.join("glb/mug_1.glb"), "another mesh").unwrap();
    std::fs::create_dir(home.path().join("empty")).unwrap();
    std::fs::write(home.path().join("bad.json"), "[{\"op\": \"tidy\"}").unwrap();
    let tidy = ["--operations", "[{\"op\": \"tidy\"}]"];
    let edit = |more: &[&'static str]| [&["edit", "--bundle"][..], more].concat();
    for (arguments, says) in [
        (vec!["edit"], "--bundle"),
        (edit(&["mug"]), "--text"),
        (edit(&["mug", "--text", "tidy the table", tidy[0], tidy[1]]), "cannot be used with"),
        (edit(&["nowhere", tidy[0], tidy[1]]), "cannot read the bundle nowhere"),
        (edit(&["empty", tidy[0], tidy[1]]), "empty is no bundle: it has no manifest.json"),
        (edit(&["bad.json", tidy[0], tidy[1]]), "bad.json is no bundle"),
        (edit(&["changed", tidy[0], tidy[1]]), "glb/mug_1.glb of the bundle changed was changed"),
        (
            edit(&["mug", "--operations", "bad.json"]),
            "bad.json cannot be read as the operations, it is no JSON",
        ),
        (
            edit(&["mug", "--operations", "none.json"]),
            "cannot read the operations none.json: there is no such file",
        ),
        (edit(&["mug", "--operations", "[]"]), "--operations must have 1 to 64 operations"),
        (
            edit(&["mug", "--operations", "[{\"op\": \"tidy\"}, {\"op\": \"remove\"}]"]),
            "--operations/1 must have",
        ),
        (
            edit(&["mug", "--operations", "[{\"op\": \"add\", \"object\": \"a\", \"where\": {}}]"]),
            "--operations/0/where give one of `relation`",
        ),
        (edit(&["mug", "--text", "  "]), "--text is empty"),
        (edit(&["mug", "--text", "qwrtz zorgle"]), "--text"),
        (edit(&["mug", "--seed", "-1", tidy[0], tidy[1]]), "--seed"),
        (edit(&["mug", "--set", "dro.keeep=2", tidy[0], tidy[1]]), "nearest is dro.keep"),
        (edit(&["mug", "--out", "bad.json", tidy[0], tidy[1]]), "is a file"),
    ] {
        let done = run(home.path(), &arguments);
        let complaint = text(&done.stderr);
        assert_eq!(done.status.code(), Some(2), "{arguments:?}: {complaint}");
        assert!(complaint.contains(says), "{arguments:?}: {complaint}");
        assert!(done.stdout.is_empty(), "{arguments:?}: {}", text(&done.stdout));
        assert!(!home.path().join("out").exists(), "{arguments:?} left a folder");
    }
    let refused = run(home.path(), &edit(&["mug", "--json", "--operations", "[{\"op\": \"explode\"}]"]));
    let document: Value = serde_json::from_slice(&refused.stdout).expect("is JSON");
    assert_eq!(document["failure"]["problem"]["errors"][0]["pointer"], "/operations/0/op");
}

#[test]
fn bundles_are_equal_or_differ_and_the_exit_code_says_which() {
    let home = tempfile::tempdir().unwrap();
    for (name, x_m) in [("a", 0.0), ("same", 0.0), ("moved", 0.25)] {
        bundle(home.path(), name, x_m);
    }
    let equal = run(home.path(), &["diff", "a", "same"]);
    assert_eq!((equal.status.code(), text(&equal.stdout).as_str()), (Some(0), "no difference\n"));

    let different = run(home.path(), &["diff", "a", "moved", "--image", "difference.png"]);
    assert_eq!(different.status.code(), Some(1), "{}", text(&different.stderr));
    assert_eq!(text(&different.stdout), "~ mug_1  moved 250.00 mm, turned 0.00°\n");
    let image = decode_png(&std::fs::read(home.path().join("difference.png")).unwrap()).unwrap();
    // Three images of 20 x 10 pixels with gaps of 6; the mug is at column 10 in one and at 12 in the other.
    assert_eq!((image.width_px(), image.height_px()), (72, 10));
    assert_eq!([10, 12, 11].map(|x| image.pixel(52 + x, 5)[0]), [180, 180, 0]);

    let document = run(home.path(), &["diff", "a", "moved", "--json"]);
    assert_eq!(document.status.code(), Some(1));
    let document: Value = serde_json::from_slice(&document.stdout).expect("is JSON");
    assert_eq!(document["equal"], false);
    let changes = &document["difference"]["changed"][0]["changes"];
    assert_eq!(changes, &json!([{ "property": "pose", "distance_m": 0.25, "angle_rad": 0.0 }]));
}

#[test]
fn a_comparison_that_fails_has_the_exit_code_2() {
    let home = tempfile::tempdir().unwrap();
    bundle(home.path(), "a", 0.0);
    let broken = bundle(home.path(), "broken", 0.0);
    std::fs::write(broken.join("scene.json"), "{}").unwrap();
    for (arguments, says) in [
        (vec!["diff", "a"], "<B>"),
        (vec!["diff", "a", "nowhere"], "cannot read the bundle nowhere"),
        (vec!["diff", "a", "broken"], "scene.json of the bundle broken was changed"),
        (vec!["diff", "a", "a", "--image", "none/difference.png"], "cannot write none/difference.png"),
    ] {
        let done = run(home.path(), &arguments);
        assert_eq!(done.status.code(), Some(2), "{arguments:?}");
        assert!(text(&done.stderr).contains(says), "{arguments:?}: {}", text(&done.stderr));
    }
}
