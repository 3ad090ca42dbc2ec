//! Verification finds every planted fault.

use std::fs;
use std::path::Path;

use serde_json::{Value, json};

use super::fixture::{Place, content};
use crate::bundle::sha256;
use crate::canonical;
use crate::dataset_manifest::Layout;
use crate::freeze::{FreezeRequest, FrozenDataset, freeze};
use crate::tar::{TarReader, write_end, write_member};
use crate::verify::verify;

fn faults(folder: &Path) -> Vec<String> {
    let verification = verify(folder, &mut |_, _| {}).expect("a dataset");
    verification.faults.iter().map(ToString::to_string).collect()
}

fn assert_fault(folder: &Path, words: &str) {
    let faults = faults(folder);
    assert!(faults.iter().any(|fault| fault.contains(words)), "{words:?} is not among {faults:#?}");
}

/// Changes `dataset.json`, and makes its digest right again.
fn change_manifest(folder: &Path, change: impl FnOnce(&mut Value)) {
    let path = folder.join("dataset.json");
    let mut json: Value = serde_json::from_slice(&fs::read(&path).expect("a file")).expect("JSON");
    change(&mut json);
    json.as_object_mut().expect("an object").remove("digest");
    let digest = sha256(canonical::text(&json).as_bytes());
    json["digest"] = json!(digest);
    fs::write(path, json.to_string()).expect("a file");
}

/// Writes a shard again with other members, and lists its new size and digest.
fn rewrite_shard(dataset: &FrozenDataset, path: &str, change: impl FnOnce(&mut Vec<(String, Vec<u8>)>)) {
    let place = dataset.folder.join(path);
    let bytes = fs::read(&place).expect("a shard");
    let (mut reader, mut members) = (TarReader::new(bytes.as_slice()), Vec::new());
    while let Some(member) = reader.next_member().expect("a shard") {
        members.push((member.name.clone(), reader.content(&member).expect("a shard")));
    }
    change(&mut members);
    let mut archive = Vec::new();
    for (name, bytes) in &members {
        write_member(&mut archive, name, bytes).expect("a vector takes all bytes");
    }
    write_end(&mut archive).expect("a vector takes all bytes");
    change_manifest(&dataset.folder, |json| {
        let files = json["files"].as_array_mut().expect("files");
        let file = files.iter_mut().find(|file| file["path"] == path).expect("the shard");
        file["size"] = json!(archive.len());
        file["sha256"] = json!(sha256(&archive));
    });
    fs::write(place, archive).expect("a file");
}

const SHARD: &str = "shards/train-000000.tar";

#[test]
fn fresh_datasets_of_both_layouts_are_intact() {
    let place = Place::with_scenes();
    let dataset = place.freeze("a");
    let verification = verify(&dataset.folder, &mut |_, _| {}).expect("a dataset");
    assert_eq!(verification.faults, []);
    assert_eq!(verification.facts.len(), 12);
    let written = fs::read_to_string(dataset.folder.join("statistics.json")).expect("a file");
    assert_eq!(verification.statistics().json(), written);
    let request = FreezeRequest { layout: Layout::Scenes, ..place.request("b") };
    assert_eq!(faults(&freeze(&request, &mut |_| {}).expect("a dataset").folder), Vec::<String>::new());
}

#[test]
fn a_flipped_byte_is_found_in_every_file() {
    let place = Place::with_scenes();
    let dataset = place.freeze("a");
    for (path, bytes) in content(&dataset.folder) {
        let at = bytes.len() / 2;
        let mut flipped = bytes.clone();
        // A digit of the manifest may become another one; the digest shows it.
        flipped[at] ^= 1;
        let place = dataset.folder.join(&path);
        fs::write(&place, flipped).expect("a file");
        let found = match verify(&dataset.folder, &mut |_, _| {}) {
            Ok(verification) => verification.faults.iter().any(|fault| fault.path.starts_with(&path)),
            Err(_) => path == "dataset.json",
        };
        assert!(found, "{path}");
        fs::write(&place, bytes).expect("a file");
    }
    assert_eq!(faults(&dataset.folder), Vec::<String>::new());
}

#[test]
fn a_flipped_byte_of_a_member_is_found_where_the_shard_was_listed_anew() {
    let place = Place::with_scenes();
    let dataset = place.freeze("a");
    rewrite_shard(&dataset, SHARD, |members| members[0].1[0] ^= 1);
    assert_fault(&dataset.folder, ".hero.png: its bytes are not those of the manifest");
}

#[test]
fn missing_and_additional_members_are_found() {
    let place = Place::with_scenes();
    let dataset = place.freeze("a");
    rewrite_shard(&dataset, SHARD, |members| drop(members.remove(1)));
    assert_fault(&dataset.folder, ".json: is missing");
    let dataset = place.freeze("b");
    rewrite_shard(&dataset, SHARD, |members| members.push(("x.json".to_owned(), b"{}".to_vec())));
    assert_fault(&dataset.folder, "x.json: is no member of the shard");
}

#[test]
fn missing_and_additional_files_are_found() {
    let place = Place::with_scenes();
    let dataset = place.freeze("a");
    fs::write(dataset.folder.join("shards/notes.txt"), b"x").expect("a file");
    fs::remove_file(dataset.folder.join("LICENSES.md")).expect("a file");
    assert_fault(&dataset.folder, "shards/notes.txt: is no file of the dataset");
    assert_fault(&dataset.folder, "LICENSES.md: is missing");
    fs::remove_file(dataset.folder.join(SHARD)).expect("a file");
    assert_fault(&dataset.folder, &format!("{SHARD}: is missing"));
}

#[test]
fn an_edited_manifest_is_found_by_its_digest() {
    let place = Place::with_scenes();
    let dataset = place.freeze("a");
    let path = dataset.folder.join("dataset.json");
    let text = fs::read_to_string(&path).expect("a file");
    fs::write(&path, text.replace("\"name\": \"mugs\"", "\"name\": \"cups\"")).expect("a file");
    assert_fault(&dataset.folder, "its digest is not that of its content");
}

#[test]
fn a_wrong_split_is_found_as_leakage_and_as_a_wrong_assignment() {
    let place = Place::with_scenes();
    let dataset = place.freeze("a");
    // Scenes 3 and 9 share a text.
    let index = dataset.manifest.scenes.iter().position(|scene| scene.id == "scene03").expect("the scene");
    let other = if dataset.manifest.scenes[index].split == "train" { "test" } else { "train" };
    change_manifest(&dataset.folder, |json| json["scenes"][index]["split"] = json!(other));
    assert_fault(&dataset.folder, "share text:");
    assert_fault(&dataset.folder, "seed and ratios give");
    assert_fault(&dataset.folder, "of the split");
    assert_fault(&dataset.folder, "counts/splits");
}

#[test]
fn hidden_sharing_is_found_in_the_bundles() {
    let place = Place::with_scenes();
    let dataset = place.freeze("a");
    let index = dataset.manifest.scenes.iter().position(|scene| scene.id == "scene03").expect("the scene");
    change_manifest(&dataset.folder, |json| json["scenes"][index]["text_sha256"] = json!("0".repeat(64)));
    assert_fault(&dataset.folder, "the bundle is not what dataset.json states as parent, text_sha256");
}

#[test]
fn wrong_claims_and_counts_are_found() {
    let place = Place::with_scenes();
    let claims = [
        ("/scenes/0/objects", json!(7), "states as objects"),
        ("/scenes/0/verdict", json!("quarantine"), "states as verdict"),
        ("/scenes/0/sha256", json!("0".repeat(64)), "states as size or sha256"),
        ("/scenes/0/categories/mug", json!(2), "states as categories"),
        ("/counts/scenes", json!(13), "counts/scenes"),
        ("/counts/objects", json!(13), "counts/objects"),
        ("/scenes/0/group", json!("x"), "is in the group x"),
    ];
    for (index, (pointer, value, words)) in claims.into_iter().enumerate() {
        let dataset = place.freeze(&format!("out{index}"));
        change_manifest(&dataset.folder, |json| *json.pointer_mut(pointer).expect(pointer) = value);
        assert_fault(&dataset.folder, words);
    }
}

#[test]
fn a_manifest_that_leaves_its_folder_is_refused() {
    let place = Place::with_scenes();
    let dataset = place.freeze("a");
    change_manifest(&dataset.folder, |json| json["files"][0]["path"] = json!("../x"));
    let error = verify(&dataset.folder, &mut |_, _| {}).expect_err("a path outside").to_string();
    assert!(error.contains("outside its folder"), "{error}");
}
