//! Recordings: attempts are given out once, are kept over deaths and cancellations, and become one dataset.

use std::collections::BTreeSet;

use super::*;
use crate::queue::{AttemptOutcome, ClaimedWork};
use crate::recordings::{
    ArchivePart, Begun, CancelRecordingOutcome, MadeAttempt, NewRecording, RecordingArchive, RecordingFile,
    RecordingFilter, RecordingState, SubmitRecordingOutcome,
};
use crate::retention::RetentionSettings;
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

/// Jobs of recordings.
pub(super) fn recording() -> Scope {
    Scope::Kinds(vec![JobKind::RecordAttempt, JobKind::AssembleRecording])
}

pub(super) async fn work(store: &Store, owner: &str) -> Option<Claim> {
    store.claim(owner, LEASE, MAX_DEATHS, &recording()).await.expect("answers")
}

/// A claimed attempt.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Attempt {
    pub(super) lease: Lease,
    pub(super) number: u64,
    pub(super) tries: i64,
}

pub(super) fn attempt_of(claim: Claim) -> Attempt {
    match claim.work {
        ClaimedWork::RecordAttempt(work) => {
            Attempt { lease: claim.lease, number: work.number, tries: claim.attempt }
        }
        other => panic!("{other:?}"),
    }
}

pub(super) async fn attempt(store: &Store, owner: &str) -> Attempt {
    attempt_of(work(store, owner).await.expect("there is work"))
}

/// A claim of assembling.
pub(super) async fn assembly(store: &Store, owner: &str) -> Lease {
    let claim = work(store, owner).await.expect("there is work");
    assert_eq!(claim.work.kind(), JobKind::AssembleRecording);
    claim.lease
}

/// Keeps an attempt.
pub(super) async fn keep(store: &Store, attempt: &Attempt, made: MadeAttempt) -> Result<(), StoreError> {
    store.finish(&attempt.lease, AttemptOutcome::Attempted(made)).await.map(drop)
}

pub(super) fn made(outcome: &str) -> MadeAttempt {
    let unit = (outcome == "success").then(|| Digest::of(b"unit"));
    MadeAttempt { outcome: outcome.into(), detail: String::new(), unit }
}

/// The end of assembling when the episode of an attempt is lost.
pub(super) fn episode_lost(number: u64) -> AttemptOutcome {
    let message = format!("the episode of attempt {number} was lost");
    let failure = Failure { class: FailureClass::Transient, code: "episode_lost".into(), message };
    AttemptOutcome::EpisodeLost { number, failure, max_losses: 3 }
}

async fn is_held(store: &Store, lease: &Lease) -> bool {
    let renewed = store.renew(vec![lease.clone()], LEASE).await.expect("answers");
    renewed[0].1.is_some()
}

pub(super) async fn attempts_are_given_out_once_and_the_rest_goes_on_after_a_death(place: Place) {
    let (one, other) = (place.handle(0), place.handle(1));
    let id = submitted(&one, 2, 50).await;
    let first = attempt(&one, "a").await;
    let dead = one.claim("a", Duration::ZERO, MAX_DEATHS, &recording()).await.expect("answers");
    let dead = attempt_of(dead.expect("there is work"));
    assert_eq!((first.number, dead.number), (0, 1));
    keep(&one, &first, made("slipped")).await.expect("keeps");
    let taken_over = attempt(&other, "a").await;
    assert_eq!(taken_over.number, 1, "what nobody makes any more comes first");
    assert!(!is_held(&one, &dead.lease).await);
    let late = keep(&one, &dead, made("success")).await;
    assert!(matches!(late, Err(StoreError::LeaseLost { .. })), "{late:?}");
    assert!(is_held(&other, &taken_over.lease).await);
    keep(&other, &taken_over, made("success")).await.expect("keeps");
    let again = keep(&other, &taken_over, made("success")).await;
    assert!(matches!(again, Err(StoreError::LeaseLost { .. })), "an attempt counts once");
    // Two were missing, so eight were enqueued at once; now one is missing.
    let mut open = Vec::new();
    for number in 2..7 {
        open.push(attempt(&one, "a").await);
        assert_eq!(open.last().expect("one").number, number);
    }
    let given_back = open.pop().expect("five");
    one.finish(&given_back.lease, AttemptOutcome::Released).await.expect("gives back");
    let again = attempt(&other, "a").await;
    assert_eq!((again.number, again.tries), (given_back.number, 1), "that was no try");
    keep(&one, &open[1], made("success")).await.expect("keeps");
    assert_eq!(
        work(&other, "a").await,
        None,
        "attempts before that success are still being made, and 7 is dropped"
    );
    let row = one.recording(&DEFAULT_TENANT, &id).await.expect("reads").expect("is there");
    assert_eq!((row.state, row.begun, row.made, row.successes), (RecordingState::Running, 7, 3, 2));
    let progress = one.recording_progress(&row).await.expect("reads");
    assert_eq!((progress.attempts, progress.successes, progress.wanted), (3, 2, 2));
    assert!(progress.seconds_left.is_none_or(|seconds| seconds == 0.0), "nothing is missing: {progress:?}");
    let kept = other.kept_attempts(&id).await.expect("reads");
    let kept: Vec<_> = kept.iter().map(|kept| (kept.number, kept.made.is_success())).collect();
    assert_eq!(kept, [(0, false), (1, true), (3, true)]);
    for open in [&open[0], &open[2], &open[3], &again] {
        assert_eq!(work(&other, "a").await, None);
        keep(&one, open, made("slipped")).await.expect("keeps");
    }
    assembly(&other, "a").await;
}

pub(super) async fn attempts_at_once_are_numbered_without_gaps(place: Place) {
    submitted(place.store(), 100, 12).await;
    let claims: Vec<_> = (0..16)
        .map(|index| {
            let store = place.handle(index);
            tokio::spawn(async move { store.claim("a", LEASE, MAX_DEATHS, &recording()).await })
        })
        .collect();
    let mut numbers = BTreeSet::new();
    for claim in claims {
        // On a shared database a claim may pass over a row that another one has locked.
        if let Some(claim) = claim.await.expect("runs").expect("answers") {
            assert!(numbers.insert(attempt_of(claim).number));
        }
    }
    while let Some(claim) = work(place.store(), "a").await {
        assert!(numbers.insert(attempt_of(claim).number));
    }
    assert_eq!(numbers.into_iter().collect::<Vec<_>>(), (0..12).collect::<Vec<_>>());
}

pub(super) async fn another_identity_begins_anew_and_too_often_fails(place: Place) {
    let store = place.store();
    let id = submitted(store, 9, 50).await;
    let first = attempt(store, "a").await;
    let begin = async |attempt: &Attempt, identity: &str| {
        store.begin_recording(&attempt.lease, identity).await.expect("answers")
    };
    assert_eq!(begin(&first, "old").await, Begun::Agreed);
    keep(store, &first, made("success")).await.expect("keeps");
    let second = attempt(store, "a").await;
    assert_eq!(begin(&second, "old").await, Begun::Agreed);
    for (number, identity) in [(2, "new"), (0, "old"), (1, "new")] {
        let claimed = attempt(store, "a").await;
        assert_eq!(claimed.number, number, "all attempts but that of the newcomer are enqueued again");
        assert_eq!(begin(&claimed, identity).await, Begun::Restarted);
        let row = store.recording(&DEFAULT_TENANT, &id).await.expect("reads").expect("is there");
        assert_eq!((row.identity.as_deref(), row.made, row.successes), (Some(identity), 0, 0));
        if number == 2 {
            keep(store, &claimed, made("success")).await.expect("the newcomer goes on");
        }
    }
    let dropped = keep(store, &second, made("success")).await;
    assert!(matches!(dropped, Err(StoreError::LeaseLost { .. })), "{dropped:?}");
    let claimed = attempt(store, "a").await;
    assert_eq!(begin(&claimed, "old").await, Begun::Disputed);
    let message = "update all of them".into();
    let failure = Failure { class: FailureClass::Permanent, code: "versions_differ".into(), message };
    store.finish(&claimed.lease, AttemptOutcome::Failed(failure)).await.expect("fails");
    let row = store.recording(&DEFAULT_TENANT, &id).await.expect("reads").expect("is there");
    assert_eq!((row.state, row.failure_code.as_deref()), (RecordingState::Failed, Some("versions_differ")));
    assert_eq!(work(store, "a").await, None);
}

pub(super) async fn a_recording_ends_with_any_of_its_jobs(place: Place) {
    let store = place.store();
    let id = submitted(store, 1, 50).await;
    let (open, other) = (attempt(store, "a").await, attempt(store, "a").await);
    store.cancel(&DEFAULT_TENANT, &open.lease.job_id).await.expect("answers");
    keep(store, &open, made("success")).await.expect("ends as cancelled");
    let row = store.recording(&DEFAULT_TENANT, &id).await.expect("reads").expect("is there");
    assert_eq!((row.state, row.made), (RecordingState::Cancelled, 0));
    assert!(!is_held(store, &other.lease).await);
    let job = store.job(&DEFAULT_TENANT, &open.lease.job_id).await.expect("reads").expect("is there");
    assert_eq!((job.state, job.recording_id, job.attempt_number), (JobState::Cancelled, Some(id), Some(0)));
    assert_eq!(work(store, "a").await, None);
}

pub(super) async fn a_cancelled_recording_takes_nothing_more(place: Place) {
    let store = place.store();
    let id = submitted(store, 2, 50).await;
    let open = attempt(store, "a").await;
    let kept = attempt(store, "a").await;
    keep(store, &kept, made("no_path")).await.expect("keeps");
    let cancelled = store.cancel_recording(&DEFAULT_TENANT, &id).await.expect("answers");
    assert_eq!(cancelled, CancelRecordingOutcome::Accepted);
    assert!(!is_held(store, &open.lease).await);
    let late = keep(store, &open, made("success")).await;
    assert!(matches!(late, Err(StoreError::LeaseLost { .. })), "{late:?}");
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
    keep(store, &lease, made("success")).await.expect("keeps");
    let retention = RetentionSettings { grace_secs: 0, ..test_settings::section("store.retention") };
    let sweep = async || {
        tokio::time::sleep(Duration::from_millis(20)).await;
        let report = store.sweep(&retention, false).await.expect("sweeps").expect("no backup is under way");
        (report.removed.blobs, report.kept.blobs)
    };
    assert_eq!(sweep().await, (1, 2), "bundle and episodes stay while they are needed");

    let dead = store.claim("a", Duration::ZERO, MAX_DEATHS, &recording()).await.expect("answers");
    let dead = dead.expect("there is work").lease;
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
    assert!(matches!(late, Err(StoreError::LeaseLost { .. })), "{late:?}");
    store.begin_assembly(&alive).await.expect("begins");
    store.record_recording_archive(&alive, archive(false)).await.expect("records");
    // A lost episode is made again.
    store.finish(&alive, episode_lost(0)).await.expect("ends");
    assert!(!is_held(store, &alive).await);
    let lease = attempt(store, "b").await;
    assert_eq!(lease.number, 0);
    keep(store, &lease, made("success")).await.expect("keeps");

    let alive = assembly(store, "b").await;
    store.begin_assembly(&alive).await.expect("begins");
    store.record_recording_archive(&alive, archive(true)).await.expect("records");
    let path = "robomimic/dataset.hdf5".to_owned();
    let file = RecordingFile { path, digest: Digest::of(b"ar"), start: 1, size: 2 };
    store.record_recording_files(&alive, 0, vec![file.clone()]).await.expect("records");
    let summary = AttemptOutcome::Assembled(json!({ "episodes": 1 }));
    store.finish(&alive, summary).await.expect("finishes");
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
