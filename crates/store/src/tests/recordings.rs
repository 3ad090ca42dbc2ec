//! Recordings: attempts are given out once, are kept over deaths and cancellations, and become one dataset.

use std::collections::BTreeSet;

use super::*;
use crate::recordings::{
    ArchivePart, AssemblyLease, AttemptLease, Begun, CancelRecordingOutcome, MadeAttempt, NewRecording,
    RecordingArchive, RecordingFile, RecordingFilter, RecordingState, RecordingWork, SubmitRecordingOutcome,
};
use crate::retention::RetentionSettings;
use crate::{AfterSetback, Setback};
use scene::RecordingId;

const LEASE: Duration = Duration::from_secs(60);

pub(super) fn new_recording(wanted: u64, max_attempts: u64) -> NewRecording {
    NewRecording {
        tenant_id: DEFAULT_TENANT.clone(),
        scene_id: "scene".parse().expect("an id"),
        request: json!({ "version": 1 }),
        bundle: Digest::of(b"bundle"),
        wanted,
        max_attempts,
        idempotency_key: None,
        body_digest: Digest::of(b"body"),
    }
}

pub(super) async fn submitted(store: &Store, wanted: u64, max_attempts: u64) -> RecordingId {
    match store.submit_recording(new_recording(wanted, max_attempts)).await.expect("submits") {
        SubmitRecordingOutcome::Created(id) => id,
        other => panic!("{other:?}"),
    }
}

pub(super) async fn work(store: &Store, owner: &str) -> Option<RecordingWork> {
    store.claim_recording(owner, LEASE, MAX_DEATHS).await.expect("answers").map(|claim| claim.work)
}

pub(super) async fn attempt(store: &Store, owner: &str) -> AttemptLease {
    match work(store, owner).await {
        Some(RecordingWork::Attempt(lease)) => lease,
        other => panic!("{other:?}"),
    }
}

pub(super) async fn assembly(store: &Store, owner: &str) -> AssemblyLease {
    match work(store, owner).await {
        Some(RecordingWork::Assembly(lease)) => lease,
        other => panic!("{other:?}"),
    }
}

pub(super) fn made(outcome: &str) -> MadeAttempt {
    let unit = (outcome == "success").then(|| Digest::of(b"unit"));
    MadeAttempt { outcome: outcome.into(), detail: String::new(), unit }
}

/// What follows when the episode of an attempt is lost.
pub(super) fn episode_lost() -> Setback {
    let message = "the episode of attempt 0 was lost".to_owned();
    Setback { code: "episode_lost", message, delay: Duration::ZERO, charged: true, max_attempts: 3 }
}

pub(super) async fn attempts_are_given_out_once_and_the_rest_goes_on_after_a_death(place: Place) {
    let (one, other) = (place.handle(0), place.handle(1));
    let id = submitted(&one, 2, 50).await;
    let first = attempt(&one, "a").await;
    let dead =
        one.claim_recording("a", Duration::ZERO, MAX_DEATHS).await.expect("answers").expect("there is work");
    let RecordingWork::Attempt(dead) = dead.work else { panic!("an attempt") };
    assert_eq!((first.number, dead.number), (0, 1));
    one.keep_attempt(&first, made("slipped")).await.expect("keeps");
    let taken_over = attempt(&other, "a").await;
    assert_eq!(taken_over.number, 1, "what nobody makes any more comes first");
    assert!(!one.renew_attempt(&dead, LEASE).await.expect("answers"));
    let late = one.keep_attempt(&dead, made("success")).await;
    assert!(matches!(late, Err(StoreError::RecordingLeaseLost { .. })), "{late:?}");
    assert!(other.renew_attempt(&taken_over, LEASE).await.expect("answers"));
    other.keep_attempt(&taken_over, made("success")).await.expect("keeps");
    let again = other.keep_attempt(&taken_over, made("success")).await;
    assert!(matches!(again, Err(StoreError::RecordingLeaseLost { .. })), "an attempt counts once");
    // One is missing, so four at a time are made.
    let mut open = Vec::new();
    for _ in 0..4 {
        open.push(attempt(&one, "a").await);
    }
    assert_eq!(work(&other, "a").await, None);
    let given_back = open.pop().expect("four");
    one.release_attempt(&given_back).await.expect("gives back");
    assert_eq!(attempt(&other, "a").await.number, given_back.number);
    one.keep_attempt(&open[1], made("success")).await.expect("keeps");
    assert_eq!(work(&other, "a").await, None, "an attempt before that success is still being made");
    let row = one.recording(&DEFAULT_TENANT, &id).await.expect("reads").expect("is there");
    assert_eq!((row.state, row.made, row.successes), (RecordingState::Running, 3, 2));
    let progress = one.recording_progress(&row).await.expect("reads");
    assert_eq!((progress.attempts, progress.successes, progress.wanted), (3, 2, 2));
    assert!(progress.seconds_left.is_none_or(|seconds| seconds == 0.0), "nothing is missing: {progress:?}");
    let kept = other.kept_attempts(&id).await.expect("reads");
    let kept: Vec<_> = kept.iter().map(|kept| (kept.number, kept.tries, kept.made.is_success())).collect();
    assert_eq!(kept, [(0, 1, false), (1, 1, true), (3, 1, true)], "a death is no try");
}

pub(super) async fn attempts_at_once_are_numbered_without_gaps(place: Place) {
    submitted(place.store(), 100, 12).await;
    let claims: Vec<_> = (0..16)
        .map(|index| {
            let store = place.handle(index);
            tokio::spawn(async move { store.claim_recording("a", LEASE, MAX_DEATHS).await })
        })
        .collect();
    let mut numbers = BTreeSet::new();
    for claim in claims {
        match claim.await.expect("runs").expect("answers").map(|claim| claim.work) {
            Some(RecordingWork::Attempt(lease)) => assert!(numbers.insert(lease.number)),
            // On a shared database a claim may pass over a row that another one has locked.
            other => assert_eq!(other, None),
        }
    }
    while let Some(RecordingWork::Attempt(lease)) = work(place.store(), "a").await {
        assert!(numbers.insert(lease.number));
    }
    assert_eq!(numbers.into_iter().collect::<Vec<_>>(), (0..12).collect::<Vec<_>>());
}

pub(super) async fn another_identity_begins_anew_and_too_often_fails(place: Place) {
    let store = place.store();
    let id = submitted(store, 9, 50).await;
    let first = attempt(store, "a").await;
    assert_eq!(store.begin_recording(&first, "old").await.expect("answers"), Begun::Agreed);
    store.keep_attempt(&first, made("success")).await.expect("keeps");
    let second = attempt(store, "a").await;
    assert_eq!(store.begin_recording(&second, "old").await.expect("answers"), Begun::Agreed);
    for identity in ["new", "old", "new"] {
        let claimed = attempt(store, "a").await;
        assert_eq!(store.begin_recording(&claimed, identity).await.expect("answers"), Begun::Restarted);
        let row = store.recording(&DEFAULT_TENANT, &id).await.expect("reads").expect("is there");
        assert_eq!((row.identity.as_deref(), row.made, row.successes), (Some(identity), 0, 0));
    }
    let dropped = store.keep_attempt(&second, made("success")).await;
    assert!(matches!(dropped, Err(StoreError::RecordingLeaseLost { .. })), "{dropped:?}");
    let claimed = attempt(store, "a").await;
    assert_eq!(claimed.number, 0);
    assert_eq!(store.begin_recording(&claimed, "old").await.expect("answers"), Begun::Failed);
    let row = store.recording(&DEFAULT_TENANT, &id).await.expect("reads").expect("is there");
    assert_eq!((row.state, row.failure_code.as_deref()), (RecordingState::Failed, Some("versions_differ")));
}

pub(super) async fn a_cancelled_recording_takes_nothing_more(place: Place) {
    let store = place.store();
    let id = submitted(store, 2, 50).await;
    let open = attempt(store, "a").await;
    let kept = attempt(store, "a").await;
    store.keep_attempt(&kept, made("no_path")).await.expect("keeps");
    let cancelled = store.cancel_recording(&DEFAULT_TENANT, &id).await.expect("answers");
    assert_eq!(cancelled, CancelRecordingOutcome::Accepted);
    assert!(!store.renew_attempt(&open, LEASE).await.expect("answers"));
    let late = store.keep_attempt(&open, made("success")).await;
    assert!(matches!(late, Err(StoreError::RecordingLeaseLost { .. })), "{late:?}");
    assert_eq!(work(store, "a").await, None);
    let row = store.recording(&DEFAULT_TENANT, &id).await.expect("reads").expect("is there");
    assert_eq!(row.summary, Some(json!({ "attempts": { "no_path": 1 } })));
    let again = store.cancel_recording(&DEFAULT_TENANT, &id).await.expect("answers");
    assert_eq!(again, CancelRecordingOutcome::TooLate(RecordingState::Cancelled));
}

pub(super) async fn a_dataset_is_assembled_by_one_process_and_outlives_sweeps(place: Place) {
    let store = place.store();
    let id = submitted(store, 1, 50).await;
    let lease = attempt(store, "a").await;
    for blob in [&b"bundle"[..], b"unit", b"nothing refers to it"] {
        store.blobs().put(blob).await.expect("puts");
    }
    store.keep_attempt(&lease, made("success")).await.expect("keeps");
    let retention = RetentionSettings { grace_secs: 0, ..test_settings::section("store.retention") };
    let sweep = async || {
        tokio::time::sleep(Duration::from_millis(20)).await;
        let report = store.sweep(&retention, false).await.expect("sweeps").expect("no backup is under way");
        (report.removed.blobs, report.kept.blobs)
    };
    assert_eq!(sweep().await, (1, 2), "bundle and episodes stay while they are needed");

    let dead = store
        .claim_recording("a", Duration::ZERO, MAX_DEATHS)
        .await
        .expect("answers")
        .expect("there is work");
    let RecordingWork::Assembly(dead) = dead.work else { panic!("all attempts are made") };
    let alive = assembly(store, "b").await;
    let archive = |complete: bool| RecordingArchive {
        format: "robomimic".into(),
        digest: complete.then(|| Digest::of(b"part")),
        size: 4,
        files: 1,
        parts: vec![ArchivePart { digest: Digest::of(b"part"), size: 4 }],
    };
    store.blobs().put(&b"part"[..]).await.expect("puts");
    let late = store.record_recording_archive(&dead, archive(false)).await;
    assert!(matches!(late, Err(StoreError::RecordingLeaseLost { .. })), "{late:?}");
    store.begin_assembly(&alive).await.expect("begins");
    store.record_recording_archive(&alive, archive(false)).await.expect("records");
    // A lost episode is made again.
    assert_eq!(store.forget_attempt(&alive, 0, episode_lost()).await.expect("forgets"), AfterSetback::Again);
    assert!(!store.renew_assembly(&alive, LEASE).await.expect("answers"));
    let lease = attempt(store, "b").await;
    assert_eq!(lease.number, 0);
    store.keep_attempt(&lease, made("success")).await.expect("keeps");

    let alive = assembly(store, "b").await;
    store.begin_assembly(&alive).await.expect("begins");
    store.record_recording_archive(&alive, archive(true)).await.expect("records");
    let path = "robomimic/dataset.hdf5".to_owned();
    let file = RecordingFile { path, digest: Digest::of(b"ar"), start: 1, size: 2 };
    store.record_recording_files(&alive, 0, vec![file.clone()]).await.expect("records");
    store.finish_recording(&alive, json!({ "episodes": 1 })).await.expect("finishes");
    let row = store.recording(&DEFAULT_TENANT, &id).await.expect("reads").expect("is there");
    assert_eq!((row.state, row.summary), (RecordingState::Finished, Some(json!({ "episodes": 1 }))));
    assert_eq!(store.recording_archives(&id).await.expect("reads"), [archive(true)]);
    assert_eq!(store.recording_file(&id, &file.path).await.expect("reads"), Some(file.clone()));
    assert_eq!(store.recording_files(&id, None, 9).await.expect("reads"), [(0, file)]);
    assert_eq!(store.recording_files(&id, Some(0), 9).await.expect("reads"), []);
    assert_eq!(sweep().await, (2, 1), "the dataset stays");
    assert_eq!(work(store, "a").await, None);
}

pub(super) async fn keys_and_lists_belong_to_their_tenant(place: Place) {
    let store = place.store();
    let keyed = |body: &[u8]| NewRecording {
        idempotency_key: Some("key".into()),
        body_digest: Digest::of(body),
        ..new_recording(1, 9)
    };
    let SubmitRecordingOutcome::Created(id) = store.submit_recording(keyed(b"body")).await.expect("submits")
    else {
        panic!("the key is new");
    };
    let again = store.submit_recording(keyed(b"body")).await.expect("answers");
    assert_eq!(again, SubmitRecordingOutcome::Replayed(id.clone()));
    let other = store.submit_recording(keyed(b"another")).await.expect("answers");
    assert_eq!(other, SubmitRecordingOutcome::KeyReused);
    let filter = |scene: &str, state| RecordingFilter {
        scene_id: Some(scene.parse().expect("an id")),
        state,
        limit: 9,
        ..RecordingFilter::default()
    };
    for (filter, count) in [
        (filter("scene", None), 1),
        (filter("scene", Some(RecordingState::Queued)), 1),
        (filter("scene", Some(RecordingState::Failed)), 0),
        (filter("other", None), 0),
        (RecordingFilter { before_id: Some(id.clone()), limit: 9, ..RecordingFilter::default() }, 0),
    ] {
        assert_eq!(store.recordings(&DEFAULT_TENANT, filter).await.expect("reads").len(), count);
    }
    let stranger: TenantId = "other".parse().expect("an id");
    assert_eq!(store.recording(&stranger, &id).await.expect("reads"), None);
    assert_eq!(
        store.cancel_recording(&stranger, &id).await.expect("answers"),
        CancelRecordingOutcome::NotFound
    );
}
