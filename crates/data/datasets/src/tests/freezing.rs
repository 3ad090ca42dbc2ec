//! Freezing: equal bytes, resumption, the form of shards.

use std::collections::BTreeSet;
use std::fs;

use super::fixture::{Place, SceneSpec, content};
use crate::dataset_manifest::Layout;
use crate::error::DatasetError;
use crate::freeze::{FreezeRequest, freeze};
use crate::tar::{self, TarReader};

#[test]
fn equal_inputs_give_equal_bytes() {
    let place = Place::with_scenes();
    let (first, second) = (place.freeze("a"), place.freeze("b"));
    let bytes = content(&first.folder);
    assert_eq!(bytes, content(&second.folder));
    let shards = bytes.keys().filter(|path| path.starts_with("shards/")).count();
    assert!(shards >= 4, "{:?}", bytes.keys());
    assert!(!first.existed && first.kept == 0);
}

#[test]
fn shards_hold_the_files_of_each_scene_in_order_and_keep_their_bound() {
    let place = Place::with_scenes();
    let dataset = place.freeze("a");
    let mut ids = BTreeSet::new();
    for file in dataset.manifest.files.iter().filter(|file| file.path.ends_with(".tar")) {
        let bytes = fs::read(dataset.folder.join(&file.path)).expect("a shard");
        let mut reader = TarReader::new(bytes.as_slice());
        let mut names = Vec::new();
        while let Some(member) = reader.next_member().expect("a shard") {
            reader.skip(&member).expect("a shard");
            names.push(member.name);
        }
        assert!(names.is_sorted() && names.len() % 4 == 0 && names.len() <= 12, "{names:?}");
        for scene in names.chunks(4) {
            let extensions: Vec<&str> =
                scene.iter().filter_map(|name| name.split_once('.')).map(|(_, rest)| rest).collect();
            assert_eq!(extensions, ["hero.png", "json", "top.png", "zip"]);
            ids.insert(scene[0].split('.').next().unwrap_or_default().to_owned());
        }
    }
    assert_eq!(ids.len(), 12);
}

#[test]
fn a_bound_in_bytes_starts_a_new_shard_and_a_larger_scene_has_its_own() {
    let place = Place::with_scenes();
    let sizes = |max_bytes| {
        let layout = Layout::Shards { max_bytes, max_scenes: None };
        let out = place.path(&format!("out{max_bytes}"));
        let dataset =
            freeze(&FreezeRequest { layout, out, ..place.request("") }, &mut |_| {}).expect("a dataset");
        let shards = dataset.manifest.files.into_iter().filter(|file| file.path.ends_with(".tar"));
        shards.map(|file| file.size).collect::<Vec<u64>>()
    };
    assert_eq!(sizes(1).len(), 12);
    let whole = sizes(u64::MAX);
    assert_eq!(whole.len(), 2);
    let bound = whole[0] / 2;
    let halves = sizes(bound);
    assert!(halves.len() > 2 && halves.iter().all(|size| *size <= bound), "{halves:?} with bound {bound}");
}

#[test]
fn a_resumed_freeze_keeps_whole_shards_and_equals_a_fresh_one() {
    let place = Place::with_scenes();
    let fresh = content(&place.freeze("fresh").folder);
    // One damaged bundle stops the freeze after some shards.
    let request = place.request("resumed");
    let last = place.freeze("other").manifest.scenes.last().expect("a scene").id.clone();
    let number: usize = last.trim_start_matches("scene").parse().expect("a number");
    let damaged = match number % 2 {
        0 => place.path(&format!("bundles/{last}/preview/top.png")),
        _ => place.path(&format!("bundles/{last}.zip")),
    };
    let whole = fs::read(&damaged).expect("a file");
    let mut flipped = whole.clone();
    let at = flipped.windows(6).position(|window| window == b"top of").expect("the image");
    flipped[at] ^= 1;
    fs::write(&damaged, flipped).expect("a file");
    assert!(matches!(freeze(&request, &mut |_| {}), Err(DatasetError::Bundle { .. })));
    let folder = place.path("resumed/mugs/v1");
    assert!(!folder.join("dataset.json").exists());
    // What a stopped process may leave: a half-written shard, and one of another set.
    fs::write(folder.join(".freeze/shards-test-000001.tar.partial"), b"half").expect("a file");
    fs::write(folder.join("shards/train-000099.tar"), b"stray").expect("a file");
    fs::write(&damaged, whole).expect("a file");
    let resumed = freeze(&request, &mut |_| {}).expect("a dataset");
    assert!(resumed.kept >= 2, "{}", resumed.kept);
    assert_eq!(content(&resumed.folder), fresh);
}

#[test]
fn a_damaged_shard_of_an_interrupted_freeze_is_written_again() {
    let place = Place::with_scenes();
    let fresh = content(&place.freeze("a").folder);
    let broken = place.path("bundles/scene99");
    SceneSpec::of_text("scene99", "Another text").write_folder(&place.path("bundles"));
    fs::remove_file(broken.join("glb/table.glb")).expect("a file");
    assert!(freeze(&place.request("b"), &mut |_| {}).is_err());
    fs::remove_dir_all(broken).expect("a folder");
    let shard = place.path("b/mugs/v1/shards/train-000000.tar");
    let mut bytes = fs::read(&shard).expect("a shard");
    bytes[700] ^= 1;
    fs::write(&shard, bytes).expect("a shard");
    assert_eq!(content(&freeze(&place.request("b"), &mut |_| {}).expect("a dataset").folder), fresh);
}

#[test]
fn scenes_may_be_archives_of_their_own() {
    let place = Place::with_scenes();
    let request = FreezeRequest { layout: Layout::Scenes, ..place.request("a") };
    let dataset = freeze(&request, &mut |_| {}).expect("a dataset");
    let source = fs::read(place.path("bundles/scene01.zip")).expect("an archive");
    assert_eq!(fs::read(dataset.folder.join("scenes/scene01.zip")).expect("an archive"), source);
    let paths: Vec<String> = content(&dataset.folder).into_keys().collect();
    assert_eq!(paths.iter().filter(|path| path.starts_with("scenes/")).count(), 12);
    assert_eq!(paths.len(), 16);
}

#[test]
fn splits_that_would_be_empty_are_refused_before_anything_is_written() {
    let place = Place::new();
    // Scenes of one text are one group: three groups of twenty.
    for k in 0..60 {
        let spec = SceneSpec::of_text(&format!("scene{k:02}"), &format!("A mug, number {}", k % 3));
        spec.write_archive(&place.path("bundles"));
    }
    let with_plan = |text: &str| {
        let plan = text.parse().expect("a plan");
        freeze(&FreezeRequest { plan, ..place.request("a") }, &mut |_| {})
    };
    let refused =
        with_plan("train=0.8,validation=0.1,test=0.1,spare=0").expect_err("two splits would be empty");
    assert!(matches!(refused, DatasetError::EmptySplits(_)), "{refused}");
    let message = refused.to_string();
    for part in ["for the splits validation, test:", "scenes: 60, groups: 3, largest group: 20", "all=1"] {
        assert!(message.contains(part), "{message}");
    }
    assert!(!place.path("a/mugs/v1").exists());
    let counts = with_plan("train=0.4,validation=0.3,test=0.3").expect("a dataset").manifest.counts;
    assert!(counts.splits.values().all(|scenes| *scenes == 20), "{counts:?}");
    let whole = with_plan("none").expect("a dataset").manifest;
    assert_eq!(whole.counts.splits, [("all".to_owned(), 60)].into());
}

#[test]
fn files_of_others_in_the_folder_of_a_version_stay() {
    let place = Place::with_scenes();
    let own = place.path("a/mugs/v1/scenes/notes.txt");
    fs::create_dir_all(own.parent().expect("a folder")).expect("made");
    fs::write(&own, "years of work").expect("written");
    let refused =
        freeze(&place.request("a"), &mut |_| {}).expect_err("the folder is not its own").to_string();
    assert!(refused.contains("no freeze left") && own.exists(), "{refused}");
}

#[test]
fn damaged_bundles_are_refused_by_name() {
    let place = Place::new();
    let folder = SceneSpec::of_text("a", "A mug").write_folder(&place.path("bundles"));
    let cases =
        [("scene.json", "scene.json"), ("preview/hero.png", "hero.png"), ("glb/mug_1.glb", "mug_1.glb")];
    for (path, named) in cases {
        let whole = fs::read(folder.join(path)).expect("a file");
        fs::write(folder.join(path), [whole.as_slice(), b" "].concat()).expect("a file");
        let error = freeze(&place.undivided("a"), &mut |_| {}).expect_err(path).to_string();
        assert!(error.contains(named), "{error}");
        fs::write(folder.join(path), whole).expect("a file");
    }
    freeze(&place.undivided("a"), &mut |_| {}).expect("a dataset");
}

#[test]
fn a_manifest_that_leaves_its_bundle_is_refused() {
    let place = Place::new();
    let folder = SceneSpec::of_text("a", "A mug").write_folder(&place.path("bundles"));
    let manifest = fs::read_to_string(folder.join("manifest.json")).expect("a file");
    fs::write(folder.join("manifest.json"), manifest.replace("preview/top.png", "../../top.png"))
        .expect("a file");
    let error = freeze(&place.request("a"), &mut |_| {}).expect_err("a path outside").to_string();
    assert!(error.contains("no path inside"), "{error}");
}

/// `tests/fixtures/datasets/shard.tar` was written by Python's `tarfile` (ustar), and its test reads it.
#[test]
fn archives_are_those_of_another_writer() {
    let mut archive = Vec::new();
    for (name, bytes) in [("scene00.json", &b"{}\n"[..]), ("scene00.zip", &[80; 600])] {
        tar::write_member(&mut archive, name, bytes).expect("a vector takes all bytes");
    }
    tar::write_end(&mut archive).expect("a vector takes all bytes");
    assert_eq!(archive, include_bytes!("../../../../../tests/fixtures/datasets/shard.tar"));
}
