//! Tests of whole bundles: determinism, escaping, refusal of inconsistent scenes, archive and manifest.

use std::collections::BTreeMap;
use std::path::Path;

use scene::{InstanceId, Scene};

use super::specimen::{NASTY_LABEL, files, files_with, settings, specimen, text};
use crate::*;

/// Writes a bundle for each form of USD under `target/specimen/` for the validators of `make test`.
#[test]
fn specimen_bundles_are_written_for_external_validators() {
    for (name, form) in [("usda", UsdForm::Usda), ("usdc", UsdForm::Usdc), ("usdz", UsdForm::Usdz)] {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../target/specimen").join(name);
        if folder.exists() {
            std::fs::remove_dir_all(&folder).expect("target is writable");
        }
        for file in files_with(form) {
            let path = folder.join(&file.path);
            std::fs::create_dir_all(path.parent().expect("inside the folder")).expect("target is writable");
            std::fs::write(path, &file.bytes).expect("target is writable");
        }
    }
}

/// RViz and MoveIt resolve meshes by package.
#[test]
fn urdf_folder_is_a_ros_2_package_on_request() {
    let (scene, certificate, assets, images) = specimen();
    let settings = ExportSettings { urdf: UrdfPaths::Ros2, ..settings(UsdForm::Usdc) };
    let files = write_formats(&scene, &certificate, &assets, &images, Vec::new(), &settings).expect("sound");
    assert!(text(&files, "urdf/package.xml").contains("<name>scene_specimen0001</name>"));
    assert!(text(&files, "urdf/CMakeLists.txt").contains("install(DIRECTORY table mug_1 box_1 DESTINATION"));
    for path in ["urdf/scene.urdf", "urdf/mug_1/mug_1.urdf"] {
        let meshes: Vec<&str> = text(&files, path).split("filename=\"").skip(1).collect();
        let in_package = |mesh: &&str| mesh.starts_with("package://scene_specimen0001/");
        assert!(!meshes.is_empty() && meshes.iter().all(in_package), "{path}");
    }
    assert!(text(&files, "README.md").contains("## ROS 2"));
    assert!(!text(&super::specimen::files(), "README.md").contains("## ROS 2"));
    let elsewhere: Vec<BundleFile> = files
        .into_iter()
        .map(|mut file| {
            if file.path == "urdf/package.xml" {
                file.bytes = b"<package><name>other</name></package>".to_vec();
            }
            file
        })
        .collect();
    let bodies = body::bodies(&scene, &assets).expect("sound");
    assert_eq!(round_trip::read_back(&bodies, &elsewhere).expect_err("elsewhere").code(), "formats_disagree");
}

#[test]
fn bundle_bytes_do_not_depend_on_thread_count() {
    let with_threads = |count: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(count).build().expect("a pool");
        pool.install(files)
    };
    let one = with_threads(1);
    assert_eq!(one, with_threads(3));
    let zip = |files: &[BundleFile]| zip_bundle(files).expect("packs");
    assert_eq!(zip(&one), zip(&one.iter().rev().cloned().collect::<Vec<_>>()));
}

#[test]
fn labels_are_escaped_in_every_format() {
    let files = files();
    let scene: Scene = serde_json::from_str(text(&files, "scene.json")).expect("our own JSON");
    assert_eq!(scene, specimen().0);
    let as_text = files_with(UsdForm::Usda);
    let usd = text(&as_text, "usd/assets/mug_1/simready_usd/mug_1.usda");
    let escaped = "\"a \\\"red\\\" <b>mug</b> & 'co'\\n--> ]]> \\\\ {rows} | 🍎\\x07\"";
    assert!(usd.contains(&format!("displayName = {escaped}")));
    let mjcf = text(&files, "mjcf/scene.xml");
    assert!(mjcf.contains("&lt;b&gt;mug&lt;/b&gt; &amp; ") && mjcf.contains("&#10;--&gt;"));
    assert!(!text(&files, "README.md").contains("<b>"));
    let manifest: serde_json::Value =
        serde_json::from_str(text(&files, "manifest.json")).expect("our own JSON");
    assert_eq!(manifest["assets"][1]["label"], NASTY_LABEL);
}

#[test]
fn read_back_rejects_formats_that_differ_from_the_scene() {
    let (scene, _, assets, _) = specimen();
    let bodies = body::bodies(&scene, &assets).expect("sound");
    let changes = [
        ("mjcf/scene.xml", "mass=\"0.3\"", "mass=\"0.31\""),
        ("mjcf/scene.xml", "pos=\"-0.1 0.05 0\"", "pos=\"0.1 0.05 0\""),
        ("urdf/mug_1/mug_1.urdf", "value=\"0.5\"", "value=\"0.4\""),
        ("urdf/scene.urdf", "0.15 -0.04 0", "-0.04 0.15 0"),
        ("usd/scene.usda", "physics:rigidBodyEnabled = 0", "physics:rigidBodyEnabled = 1"),
        ("usd/assets/mug_1/simready_usd/mug_1.usda", "(0.00031, ", "(0.00036, "),
        ("usd/assets/mug_1/simready_usd/mug_1.usda", "convexHull", "convexDecomposition"),
    ];
    for (path, from, to) in changes {
        let mut files = files_with(UsdForm::Usda);
        let file = files.iter_mut().find(|file| file.path == path).expect("written");
        let before = String::from_utf8(file.bytes.clone()).expect("text");
        assert!(before.contains(from), "{path} has no {from}");
        file.bytes = before.replace(from, to).into_bytes();
        let result = round_trip::read_back(&bodies, &files);
        assert!(
            matches!(result, Err(ExportError::RoundTripMismatch { .. } | ExportError::Unreadable { .. })),
            "{path} {to}"
        );
    }
}

#[test]
fn read_back_checks_binary_usd_and_usd_packages() {
    let (scene, _, assets, _) = specimen();
    let bodies = body::bodies(&scene, &assets).expect("sound");
    let little_endian = |values: &[f32]| values.iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<u8>>();
    let moments = little_endian(&[3.1e-4, 3.6e-4, 4.2e-4]);
    let other_moments = little_endian(&[3.6e-4, 3.6e-4, 4.2e-4]);
    for (form, path) in
        [(UsdForm::Usdc, "usd/assets/mug_1/simready_usd/mug_1.usdc"), (UsdForm::Usdz, "usd/scene.usdz")]
    {
        let mut files = files_with(form);
        let report = round_trip::read_back(&bodies, &files).expect("reads back");
        assert_eq!(report.usd.hulls, report.mjcf.hulls);
        let file = files.iter_mut().find(|file| file.path == path).expect("written");
        let at = file.bytes.windows(12).position(|window| window == moments).expect("stands there once");
        file.bytes[at..at + 12].copy_from_slice(&other_moments);
        assert!(round_trip::read_back(&bodies, &files).is_err(), "{form:?} with other moments");
        let file = files.iter_mut().find(|file| file.path == path).expect("written");
        file.bytes.truncate(file.bytes.len() / 2);
        assert!(round_trip::read_back(&bodies, &files).is_err(), "{form:?} cut in half");
    }
}

#[test]
fn manifest_entries_match_the_archive() {
    let files = files();
    let bytes = zip_bundle(&files).expect("packs");
    let entries = archive::manifest_entries(&bytes).expect("archive matches its manifest");
    assert_eq!(entries.len(), files.len() - 1);
    let mut archive = zip::ZipArchive::new(std::io::Cursor::new(&bytes)).expect("our own archive");
    let mut content = String::new();
    let mut entry = archive.by_name("scene-specimen0001/mjcf/scene.xml").expect("there");
    std::io::Read::read_to_string(&mut entry, &mut content).expect("text");
    assert_eq!(content, text(&files, "mjcf/scene.xml"));

    let error_after = |change: fn(&mut Vec<BundleFile>)| {
        let mut files = files.clone();
        change(&mut files);
        archive::manifest_entries(&zip_bundle(&files).expect("packs")).expect_err("differs").to_string()
    };
    let stray = BundleFile::text("notes.txt", String::new(), "notes", "text/plain");
    assert!(error_after(|files| files.retain(|file| file.path != "report.json")).contains("report.json"));
    assert!(error_after(|files| files.retain(|file| file.path != "manifest.json")).contains("manifest.json"));
    assert!(error_after(|files| files[3].bytes.push(b' ')).contains(&files[3].path));
    let mut more = files.clone();
    more.push(stray);
    let error = archive::manifest_entries(&zip_bundle(&more).expect("packs")).expect_err("differs");
    assert!(error.to_string().contains("notes.txt"), "{error}");
}

#[test]
fn manifest_itself_describes_the_manifest_of_an_archive() {
    let files = files();
    let (path, entry) = archive::manifest_itself(&zip_bundle(&files).expect("packs")).expect("has one");
    let bytes = text(&files, &path).as_bytes();
    assert_eq!(path, "manifest.json");
    assert_eq!(entry, manifest::entry_of(bytes, "application/json"));
    assert_eq!((entry.size, entry.sha256.len()), (bytes.len() as u64, 64));
    let without: Vec<BundleFile> = files.into_iter().filter(|file| file.path != path).collect();
    assert!(archive::manifest_itself(&zip_bundle(&without).expect("packs")).is_err());
}

#[test]
fn export_errors_name_the_invalid_body() {
    let error = |change: fn(&mut Scene, &mut Assets)| {
        let (mut scene, certificate, mut assets, images) = specimen();
        change(&mut scene, &mut assets);
        write_formats(&scene, &certificate, &assets, &images, Vec::new(), &settings(UsdForm::Usdc))
            .expect_err("unsound")
            .to_string()
    };
    assert!(error(|scene, _| scene.instances[0].mass.mass_kg = -1.0).contains("mug_1"));
    assert!(error(|scene, _| scene.instances[0].mass.inertia_diagonal_kg_m2.x = 1.0).contains("triangle"));
    assert!(error(|scene, _| scene.instances[1].hulls = 2).contains("box_1"));
    assert!(
        error(|scene, _| scene.instances[1].name = InstanceId::new("mug_1").expect("ok")).contains("mug_1")
    );
    assert!(
        error(|_, assets| assets.instances[1].hulls[0].triangles.iter_mut().for_each(|t| t.swap(0, 1)))
            .contains("inside out")
    );
    assert!(error(|_, assets| assets.instances.truncate(1)).contains("1 assets"));
}

#[test]
fn manifest_lists_every_file() {
    let files = files();
    let manifest: serde_json::Value =
        serde_json::from_str(text(&files, "manifest.json")).expect("our own JSON");
    let sizes: BTreeMap<&str, u64> = manifest["files"]
        .as_array()
        .expect("a list")
        .iter()
        .map(|file| (file["path"].as_str().expect("a path"), file["size"].as_u64().expect("a size")))
        .collect();
    assert_eq!(sizes.len(), files.len() - 1);
    for file in files.iter().filter(|file| file.path != "manifest.json") {
        assert_eq!(sizes.get(file.path.as_str()), Some(&(file.bytes.len() as u64)), "{}", file.path);
    }
}

#[test]
fn a_derived_bundle_is_packed_to_the_same_bytes_whatever_its_parent_has() {
    let files = files();
    let whole = zip_bundle(&files).expect("packs");
    assert_eq!(archive::zip_derived_bundle(&files, &whole).expect("packs"), whole);
    // A parent with other bytes, of the same length, in one file, and without another.
    let mut other: Vec<BundleFile> = files.iter().filter(|file| file.path != "README.md").cloned().collect();
    let changed = other.iter_mut().find(|file| file.path.ends_with(".obj")).expect("a mesh");
    changed.bytes[0] ^= 1;
    let parent = zip_bundle(&other).expect("packs");
    assert_eq!(archive::zip_derived_bundle(&files, &parent).expect("packs"), whole);
    assert_eq!(archive::zip_derived_bundle(&files, b"no archive").expect("packs"), whole);
}
