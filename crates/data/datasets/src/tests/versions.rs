//! Versions, filters and the output of batches.

use std::collections::BTreeMap;
use std::fs;

use serde_json::json;

use super::fixture::{MUG, ObjectSpec, Place, SceneSpec};
use crate::dataset_manifest::DatasetManifest;
use crate::filter::Filter;
use crate::freeze::{FreezeRequest, freeze};
use crate::splits::SplitPlan;
use crate::verify::verify;

#[test]
fn an_unchanged_set_is_the_same_version_and_a_changed_one_the_next() {
    let place = Place::with_scenes();
    let first = place.freeze("out");
    let again = place.freeze("out");
    assert!(again.existed);
    assert_eq!(again.manifest, first.manifest);
    SceneSpec::of_text("new", "A new text").write_folder(&place.path("bundles"));
    fs::remove_file(place.path("bundles/scene11.zip")).expect("a file");
    let second = place.freeze("out");
    assert_eq!((second.manifest.version, second.existed), (2, false));
    let changes = second.manifest.changes.expect("a change");
    assert_eq!((changes.since_version, changes.since_digest), (1, first.manifest.digest));
    assert_eq!((changes.added, changes.removed), (vec!["new".to_owned()], vec!["scene11".to_owned()]));
}

#[test]
fn scenes_keep_their_split_in_the_next_version_of_the_same_plan() {
    let place = Place::with_scenes();
    let splits = |manifest: &DatasetManifest| -> BTreeMap<String, String> {
        manifest.scenes.iter().map(|scene| (scene.id.clone(), scene.split.clone())).collect()
    };
    let first = splits(&place.freeze("out").manifest);
    for k in 0..9 {
        SceneSpec::of_text(&format!("new{k}"), &format!("New text {k}")).write_folder(&place.path("bundles"));
    }
    let second = place.freeze("out");
    let changes = second.manifest.changes.clone().expect("a change");
    assert_eq!((changes.added.len(), changes.moved.len()), (9, 0));
    let kept: BTreeMap<String, String> =
        splits(&second.manifest).into_iter().filter(|(id, _)| first.contains_key(id)).collect();
    assert_eq!(kept, first);
    assert_eq!(verify(&second.folder, &mut |_, _| {}).expect("a dataset").faults, []);
    // Another seed is another plan, which divides all scenes anew.
    let plan = SplitPlan { seed: 3, ..place.request("out").plan };
    let third = freeze(&FreezeRequest { plan, ..place.request("out") }, &mut |_| {}).expect("a dataset");
    assert!(third.manifest.scenes.iter().all(|scene| scene.earlier_split.is_none()));
    let moved = third.manifest.changes.expect("a change").moved;
    let differing =
        third.manifest.scenes.iter().filter(|scene| splits(&second.manifest)[&scene.id] != scene.split);
    assert_eq!(moved.len(), differing.count());
}

#[test]
fn a_version_never_changes() {
    let place = Place::with_scenes();
    place.freeze("out");
    fs::remove_file(place.path("bundles/scene11.zip")).expect("a file");
    let request = FreezeRequest { version: Some(1), ..place.request("out") };
    let error = freeze(&request, &mut |_| {}).expect_err("another set").to_string();
    assert!(error.contains("freeze version 2"), "{error}");
}

#[test]
fn the_number_of_a_version_that_is_gone_is_not_used_again() {
    let place = Place::with_scenes();
    place.freeze("out");
    let later = FreezeRequest { last_removed: 4, ..place.request("out") };
    let same = freeze(&later, &mut |_| {}).expect("a dataset");
    assert_eq!((same.existed, same.manifest.version), (true, 1), "the set is that of version 1");
    fs::remove_file(place.path("bundles/scene11.zip")).expect("a file");
    let another = freeze(&later, &mut |_| {}).expect("a dataset");
    assert_eq!((another.existed, another.manifest.version), (false, 5));
    assert_eq!(another.manifest.changes.expect("changes").removed.len(), 1, "since version 1");
}

#[test]
fn filters_select_by_certificate_and_content() {
    let place = Place::new();
    let bundles = place.path("bundles");
    let knife = ObjectSpec { name: "knife_1", category: "knife", ..MUG };
    let specs = [
        SceneSpec::of_text("one", "1"),
        SceneSpec { objects: vec![MUG, knife], ..SceneSpec::of_text("two", "2") },
        SceneSpec { objects: Vec::new(), ..SceneSpec::of_text("none", "3") },
        SceneSpec { reasons: vec!["collision"], ..SceneSpec::of_text("bad", "4") },
    ];
    for spec in &specs {
        spec.write_folder(&bundles);
    }
    let frozen = |filter: &str| {
        let out = place.path(&format!("out-{filter}"));
        let request = FreezeRequest { filter: filter.parse().expect("a filter"), out, ..place.undivided("") };
        let mut manifest = freeze(&request, &mut |_| {}).expect("a dataset").manifest;
        manifest.scenes.sort_by(|a, b| a.id.cmp(&b.id));
        let ids: Vec<String> = manifest.scenes.iter().map(|scene| scene.id.clone()).collect();
        (ids.join(" "), manifest.selection)
    };
    assert_eq!(frozen("").0, "none one two");
    assert_eq!(frozen("verdict=any,min_objects=1").0, "bad one two");
    assert_eq!(frozen("verdict=quarantine").0, "bad");
    assert_eq!(frozen("max_objects=1,category=mug").0, "one");
    assert_eq!(frozen("not_category=knife").0, "none one");
    let selection = frozen("min_objects=2").1;
    assert_eq!((selection.requested, selection.read, selection.passed), (4, 4, 3));
    assert_eq!(selection.left_out, [("min_objects".to_owned(), 2), ("verdict".to_owned(), 1)].into());
    assert_eq!(selection.quarantine_reasons, [("collision".to_owned(), 1)].into());
    assert_eq!(selection.yield_share(), Some(0.75));
}

#[test]
fn malformed_filters_are_refused_with_the_correction() {
    for (text, words) in
        [("mug", "KEY=VALUE"), ("color=red", "no condition"), ("min_objects=x", "whole number")]
    {
        let error = text.parse::<Filter>().expect_err(text).to_string();
        assert!(error.contains(words), "{error}");
    }
    let place = Place::with_scenes();
    let filter: Filter = "category=sofa".parse().expect("a filter");
    let error =
        freeze(&FreezeRequest { filter, ..place.request("a") }, &mut |_| {}).expect_err("none").to_string();
    assert!(error.contains("none of 12 scenes"), "{error}");
}

#[test]
fn the_output_of_a_batch_names_bundles_labels_and_failures() {
    let place = Place::new();
    let batch = place.path("batch");
    SceneSpec::of_text("aaa", "1").write_folder(&batch);
    SceneSpec::of_text("bbb", "2").write_archive(&batch);
    let records = [
        json!({ "custom_id": "x-1", "state": "failed", "verdict": null }),
        json!({ "custom_id": "x-1", "scene_id": "aaa", "state": "succeeded", "bundle": "aaa", "labels": { "room": "k" } }),
        json!({ "custom_id": "x-2", "scene_id": "bbb", "state": "succeeded", "bundle": "bbb.zip", "labels": { "room": "o" } }),
        json!({ "custom_id": "x-3", "state": "failed" }),
    ];
    let lines: Vec<String> = records.iter().map(ToString::to_string).collect();
    let output = batch.join("output.jsonl");
    fs::write(&output, lines.join("\n")).expect("a file");
    let request = FreezeRequest {
        sources: Vec::new(),
        batch_output: Some(output.clone()),
        filter: "label.room=k".parse().expect("a filter"),
        ..place.undivided("out")
    };
    let manifest = freeze(&request, &mut |_| {}).expect("a dataset").manifest;
    let ids: Vec<Option<&str>> = manifest.scenes.iter().map(|scene| scene.custom_id.as_deref()).collect();
    assert_eq!(ids, [Some("x-1")]);
    assert_eq!((manifest.selection.requested, manifest.selection.read), (3, 2));
    assert_eq!(manifest.selection.without_bundle, [("failed".to_owned(), 1)].into());
    assert_eq!(manifest.selection.left_out, [("label".to_owned(), 1)].into());
    fs::write(&output, format!("{}\n{{\"custom_id\": 7}}\n", lines[0])).expect("a file");
    let error = freeze(&request, &mut |_| {}).expect_err("line 2").to_string();
    assert!(error.contains("output.jsonl, line 2"), "{error}");
}

#[test]
fn records_find_their_bundles_by_place_where_they_name_scenes_of_a_store() {
    let place = Place::new();
    let batch = place.path("batch");
    SceneSpec::of_text("aaa", "1").write_folder(&batch);
    let record = json!({
        "custom_id": "x-1", "scene_id": "01a216d3-878a-719e-a363-dd669da309aa", "state": "succeeded", "bundle": "aaa",
    });
    let output = batch.join("output.jsonl");
    fs::write(&output, record.to_string()).expect("a file");
    let request = FreezeRequest { sources: Vec::new(), batch_output: Some(output), ..place.undivided("out") };
    let manifest = freeze(&request, &mut |_| {}).expect("a dataset").manifest;
    assert_eq!(manifest.scenes[0].custom_id.as_deref(), Some("x-1"));
    assert!(manifest.selection.without_bundle.is_empty());
}

#[test]
fn copies_count_once_and_different_bundles_of_one_scene_are_refused() {
    let place = Place::new();
    let bundles = place.path("bundles");
    SceneSpec::of_text("aaa", "1").write_folder(&bundles);
    SceneSpec::of_text("aaa", "1").write_folder(&bundles.join("copy"));
    assert_eq!(freeze(&place.undivided("out"), &mut |_| {}).expect("a dataset").manifest.selection.copies, 1);
    SceneSpec::of_text("aaa", "another text").write_folder(&bundles.join("copy"));
    let error = freeze(&place.undivided("out"), &mut |_| {}).expect_err("a conflict").to_string();
    assert!(error.contains("different bundles of the scene aaa"), "{error}");
}
