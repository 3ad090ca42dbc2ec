//! Checkpoints, stages, events and files.

use super::*;
use crate::artifacts::{ArchiveRow, BuiltScene, FileRow};
use crate::queue::AttemptOutcome;

fn file(name: &str) -> FileRow {
    FileRow {
        name: name.into(),
        digest: Digest::of(name.as_bytes()),
        media_type: "text/plain".into(),
        size: 1 << 40,
    }
}

pub(super) async fn a_checkpoint_reads_back_and_can_be_forgotten(place: Place) {
    submitted(place.store()).await;
    let lease = claimed(place.store(), "w").await.lease;
    let key = stage("alpha");
    let written = Checkpoint { artifacts: vec![file("alpha/b"), file("alpha/a")], ..checkpoint() };
    place.store().stage_finished(&lease, &key, &written, false).await.expect("commits");
    let other = place.handle(1);
    assert_eq!(other.checkpoint(&key).await.expect("reads"), Some(written));
    let of_other_tenant = StageKey { tenant_id: "other".parse().expect("an id"), ..key.clone() };
    assert_eq!(other.checkpoint(&of_other_tenant).await.expect("reads"), None);
    other.forget_checkpoint(&key).await.expect("forgets");
    assert_eq!(place.store().checkpoint(&key).await.expect("reads"), None);
}

pub(super) async fn stages_tell_whether_they_were_reused_and_how_often_they_ran(place: Place) {
    let store = place.store();
    let job = submitted(store).await.1;
    let lease = claimed(store, "w").await.lease;
    let key = stage("alpha");
    store.stage_started(&lease, &key).await.expect("starts");
    store.stage_started(&lease, &key).await.expect("starts again");
    store.stage_finished(&lease, &key, &checkpoint(), false).await.expect("commits");
    let row = |cached, runs| (cached, runs, "finished".to_owned(), Some(1));
    for (reused, expected) in [(false, row(false, 2)), (true, row(true, 2))] {
        if reused {
            store.stage_finished(&lease, &key, &checkpoint(), true).await.expect("commits");
        }
        let stages = store.stages(&DEFAULT_TENANT, &job).await.expect("reads");
        assert_eq!(stages.len(), 1);
        let stage = stages[0].clone();
        assert_eq!((stage.cached, stage.runs, stage.state, stage.elapsed_ms), expected);
    }
}

pub(super) async fn events_are_numbered_without_gaps(place: Place) {
    let job = submitted(place.store()).await.1;
    let lease = claimed(place.store(), "w").await.lease;
    let notes: Vec<_> = (0..40)
        .map(|index| {
            let (store, lease) = (place.handle(index), lease.clone());
            tokio::spawn(async move { store.note(&lease, "alpha", format!("{index}")).await })
        })
        .collect();
    for note in notes {
        note.await.expect("runs").expect("notes");
    }
    let events = place.store().events(&DEFAULT_TENANT, &job, 0, 100).await.expect("reads");
    // The job was queued and started before.
    assert_eq!(events.iter().map(|event| event.seq).collect::<Vec<_>>(), (1..=42).collect::<Vec<_>>());
    let rest = place.store().events(&DEFAULT_TENANT, &job, 40, 1).await.expect("reads");
    assert_eq!(rest, events[40..41]);
}

pub(super) async fn files_of_a_scene_are_listed_in_byte_order(place: Place) {
    let store = place.store();
    let scene = submitted(store).await.0;
    let lease = claimed(store, "w").await.lease;
    let names = ["Z.txt", "a-b.txt", "a.txt", "a/b.txt", "a_b.txt", "b.txt", "\u{e9}.txt"];
    let written =
        Checkpoint { artifacts: names.iter().rev().map(|name| file(name)).collect(), ..checkpoint() };
    store.stage_finished(&lease, &stage("alpha"), &written, false).await.expect("commits");
    let built = BuiltScene {
        files: written.artifacts,
        archive: ArchiveRow { digest: Digest::of(b"zip"), size: 3 },
        passed: true,
        reasons: Vec::new(),
        summary: json!({ "objects": 1 }),
        metrics: json!({}),
    };
    store.finish(&lease, AttemptOutcome::Built(Box::new(built))).await.expect("finishes");
    let artifacts = store.artifacts(&DEFAULT_TENANT, &scene).await.expect("reads");
    assert_eq!(artifacts.iter().map(|row| row.file.name.as_str()).collect::<Vec<_>>(), names);
    let files = store.bundle_files(&DEFAULT_TENANT, &scene).await.expect("reads");
    assert_eq!(files, names.map(file));
    let row = store.scene(&DEFAULT_TENANT, &scene).await.expect("reads").expect("is there");
    assert_eq!((row.verdict.as_deref(), row.summary), (Some("pass"), Some(json!({ "objects": 1 }))));
}
