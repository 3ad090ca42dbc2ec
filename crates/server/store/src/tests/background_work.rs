//! Jobs of all kinds by the same rules: pauses, deaths of processes, isolation, failed attempts.

use super::datasets::{dataset_of, file, freezing, frozen, submitted_dataset};
use super::recordings::{Attempt, assembly, attempt_of, episode_lost, keep, made, new_recording, recording};
use super::*;
use crate::datasets::DatasetState;
use crate::executions::{ExecutionAnswer, NewExecution, SubmitExecutionOutcome};
use crate::queue::{AttemptOutcome, BackgroundWork};
use crate::recordings::{RecordingState, SubmitRecordingOutcome};
use scene::{DatasetId, RecordingId};

const LEASE: Duration = Duration::from_secs(60);

async fn ordered(store: &Store, wanted: u64) -> RecordingId {
    match store.submit_recording(new_recording(wanted, 99)).await.expect("submits") {
        SubmitRecordingOutcome::Created(id) => id,
        other => panic!("{other:?}"),
    }
}

async fn attempt(store: &Store, owner: &str, lease: Duration) -> Option<Attempt> {
    store.claim(owner, lease, MAX_DEATHS, &recording()).await.expect("answers").map(attempt_of)
}

async fn dataset(store: &Store, owner: &str, lease: Duration) -> Option<Claim> {
    store.claim(owner, lease, MAX_DEATHS, &freezing()).await.expect("answers")
}

/// Asks until there is an answer, as after a delay.
async fn in_time<T>(mut ask: impl AsyncFnMut() -> Option<T>) -> T {
    let asked = async {
        loop {
            if let Some(answer) = ask().await {
                return answer;
            }
            tokio::time::sleep(Duration::from_millis(50)).await;
        }
    };
    tokio::time::timeout(Duration::from_secs(20), asked).await.expect("the delay ends")
}

/// Shared and lone deaths of a job.
async fn deaths(store: &Store, id: &JobId) -> (i64, i64) {
    let query = sqlx::query_as("SELECT shared_deaths, lone_deaths FROM jobs WHERE id = $1");
    query.bind(id.as_str()).fetch_one(&store.readers).await.expect("reads")
}

async fn recording_state(store: &Store, id: &RecordingId) -> (RecordingState, Option<String>) {
    let row = store.recording(&DEFAULT_TENANT, id).await.expect("reads").expect("is there");
    (row.state, row.failure_code)
}

async fn dataset_state(store: &Store, id: &DatasetId) -> (DatasetState, Option<String>) {
    let row = store.dataset(&DEFAULT_TENANT, id).await.expect("reads").expect("is there");
    (row.state, row.failure_code)
}

pub(super) async fn a_success_of_any_kind_has_an_event(place: Place) {
    let store = place.store();
    let dataset_id = submitted_dataset(store, "mugs").await;
    let freeze = dataset(store, "a", LEASE).await.expect("there is work").lease;
    store.finish(&freeze, frozen(1, &[])).await.expect("finishes");
    store.verify_dataset(&DEFAULT_TENANT, &dataset_id).await.expect("answers");
    let verification = dataset(store, "a", LEASE).await.expect("there is work").lease;
    store.finish(&verification, AttemptOutcome::Verified(json!({}))).await.expect("finishes");
    // Two episodes, so that the recording goes on, and keeps its jobs, after the first one.
    ordered(store, 2).await;
    let kept = attempt(store, "a", LEASE).await.expect("there is work");
    keep(store, &kept, made("success")).await.expect("keeps");
    let execution = NewExecution {
        tenant_id: DEFAULT_TENANT.clone(),
        scene_id: "scene".parse().expect("an id"),
        request: json!({ "version": 1 }),
        bundle: Digest::of(b"bundle"),
        idempotency: None,
    };
    let SubmitExecutionOutcome::Created(executed) = store.submit_execution(execution).await.expect("submits")
    else {
        panic!("there is no key")
    };
    let scope = Scope::Job(executed);
    let execution =
        store.claim("a", LEASE, MAX_DEATHS, &scope).await.expect("answers").expect("it waits").lease;
    let (digest, media_type) = (Digest::of(b"answer"), "application/json".to_owned());
    let answer = ExecutionAnswer { digest, media_type, size: 6 };
    store.finish(&execution, AttemptOutcome::Executed(answer)).await.expect("finishes");
    for lease in [freeze, verification, kept.lease, execution] {
        let events = store.events(&DEFAULT_TENANT, &lease.job_id, 0, 50).await.expect("reads");
        assert_eq!(events.last().map(|event| event.kind.as_str()), Some("job_succeeded"), "{events:?}");
    }
}

pub(super) async fn a_recording_that_kills_its_process_alone_waits_and_fails(place: Place) {
    let store = place.store();
    let id = ordered(store, 2).await;
    for death in 1..=i64::from(MAX_DEATHS) {
        let owner = format!("dead_{death}");
        let dead = in_time(async || {
            // Others are made meanwhile, which changes nothing for the one that kills.
            let claimed = attempt(store, &owner, Duration::ZERO).await?;
            if claimed.number == 0 {
                return Some(claimed);
            }
            keep(store, &claimed, made("slipped")).await.expect("keeps");
            None
        });
        let dead = dead.await;
        assert_eq!((dead.tries, deaths(store, &dead.lease.job_id).await), (1, (0, death - 1)), "no try");
    }
    assert_ne!(attempt(store, "heir", LEASE).await.map(|claimed| claimed.number), Some(0));
    let failed = (RecordingState::Failed, Some("worker_crashed".to_owned()));
    assert_eq!(recording_state(store, &id).await, failed);
    let row = store.recording(&DEFAULT_TENANT, &id).await.expect("reads").expect("is there");
    assert!(row.failure_message.expect("says why").contains("died 3 times"));
}

pub(super) async fn a_freeze_that_kills_its_process_alone_waits_and_fails(place: Place) {
    let store = place.store();
    let id = submitted_dataset(store, "mugs").await;
    for death in 1..=i64::from(MAX_DEATHS) {
        let owner = format!("dead_{death}");
        let dead = in_time(async || dataset(store, &owner, Duration::ZERO).await).await;
        assert_eq!(dead.attempt, 1, "a death is no attempt");
    }
    assert_eq!(dataset(store, "heir", LEASE).await, None);
    let failed = (DatasetState::Failed, Some("worker_crashed".to_owned()));
    assert_eq!(dataset_state(store, &id).await, failed);
}

fn retry(charged: bool, delay: Duration) -> AttemptOutcome {
    let failure =
        Failure { class: FailureClass::Crashed, code: "stage_panicked".into(), message: "a bug".into() };
    AttemptOutcome::Retry { failure, delay, charged, max_attempts: 3 }
}

pub(super) async fn a_freeze_that_fails_is_tried_again_after_a_delay_and_so_often(place: Place) {
    let store = place.store();
    let id = submitted_dataset(store, "mugs").await;
    let delay = Duration::from_millis(300);
    // What storage could not write burns no attempt.
    for _ in 0..4 {
        let claim = dataset(store, "a", LEASE).await.expect("there is work");
        assert_eq!(claim.attempt, 1);
        let state = store.finish(&claim.lease, retry(false, Duration::ZERO)).await.expect("answers");
        assert_eq!(state, JobState::Queued);
    }
    for attempt in 1..=3 {
        let claim = in_time(async || dataset(store, "a", LEASE).await).await;
        assert_eq!(claim.attempt, attempt);
        let state = store.finish(&claim.lease, retry(true, delay)).await.expect("answers");
        assert_eq!(state, if attempt == 3 { JobState::Failed } else { JobState::Queued });
        assert_eq!(dataset(store, "a", LEASE).await, None, "it waits, or is over");
    }
    let failed = (DatasetState::Failed, Some("stage_panicked".to_owned()));
    assert_eq!(dataset_state(store, &id).await, failed);
    let other = submitted_dataset(store, "mugs").await;
    assert_eq!(dataset_of(&dataset(store, "a", LEASE).await.expect("there is work")).id, other);
}

pub(super) async fn an_attempt_that_fails_is_tried_again_after_a_delay_and_so_often(place: Place) {
    let store = place.store();
    let id = ordered(store, 20).await;
    // What storage could not write burns no try.
    for _ in 0..4 {
        let claimed = attempt(store, "a", LEASE).await.expect("there is work");
        assert_eq!(claimed.number, 0);
        store.finish(&claimed.lease, retry(false, Duration::ZERO)).await.expect("answers");
    }
    for tries in 1..=3 {
        let claimed = in_time(async || {
            let claimed = attempt(store, "a", LEASE).await?;
            if claimed.number == 0 {
                return Some(claimed);
            }
            // Others go on meanwhile, which changes nothing for the one that cannot be made.
            keep(store, &claimed, made("success")).await.expect("keeps");
            None
        });
        let claimed = claimed.await;
        assert_eq!(claimed.tries, tries);
        let state = store.finish(&claimed.lease, retry(true, Duration::from_millis(120))).await;
        assert_eq!(state.expect("answers"), if tries == 3 { JobState::Failed } else { JobState::Queued });
        let next = attempt(store, "a", LEASE).await;
        assert_ne!(next.as_ref().map(|next| next.number), Some(0), "it waits, or is over");
        if let Some(next) = next {
            keep(store, &next, made("success")).await.expect("keeps");
        }
    }
    let failed = (RecordingState::Failed, Some("stage_panicked".to_owned()));
    assert_eq!(recording_state(store, &id).await, failed);
    assert_eq!(attempt(store, "a", LEASE).await, None);
}

pub(super) async fn assembling_that_fails_is_tried_again_after_a_delay_and_so_often(place: Place) {
    let store = place.store();
    let id = ordered(store, 1).await;
    let claimed = attempt(store, "a", LEASE).await.expect("there is work");
    keep(store, &claimed, made("success")).await.expect("keeps");
    // Neither what storage could not write, nor what was given back, nor a death burns a try.
    for outcome in [retry(false, Duration::ZERO), AttemptOutcome::Released] {
        let lease = assembly(store, "a").await;
        store.finish(&lease, outcome).await.expect("answers");
    }
    store
        .claim("dead", Duration::ZERO, MAX_DEATHS, &recording())
        .await
        .expect("answers")
        .expect("there is work");
    for tries in 1..=3 {
        let claim = async || store.claim("a", LEASE, MAX_DEATHS, &recording()).await.expect("answers");
        let claimed = in_time(claim).await;
        assert_eq!((claimed.work.kind(), claimed.attempt), (JobKind::AssembleRecording, tries));
        let state = store.finish(&claimed.lease, retry(true, Duration::from_millis(200))).await;
        assert_eq!(state.expect("answers"), if tries == 3 { JobState::Failed } else { JobState::Queued });
        assert_eq!(claim().await, None, "it waits, or is over");
        let late = store.finish(&claimed.lease, retry(true, Duration::ZERO)).await;
        assert!(matches!(late, Err(StoreError::LeaseLost { .. })), "{late:?}");
    }
    let failed = (RecordingState::Failed, Some("stage_panicked".to_owned()));
    assert_eq!(recording_state(store, &id).await, failed);
}

pub(super) async fn an_episode_that_is_lost_again_and_again_ends_its_recording(place: Place) {
    let store = place.store();
    let id = ordered(store, 1).await;
    for loss in 1..=3 {
        let claimed = attempt(store, "a", LEASE).await.expect("it is made again");
        assert_eq!(claimed.number, 0);
        keep(store, &claimed, made("success")).await.expect("keeps");
        let lease = assembly(store, "a").await;
        assert_eq!(store.finish(&lease, episode_lost(0)).await.expect("answers"), JobState::Failed);
        let (state, _) = recording_state(store, &id).await;
        assert_eq!(state, if loss == 3 { RecordingState::Failed } else { RecordingState::Running });
    }
    let failed = (RecordingState::Failed, Some("episode_lost".to_owned()));
    assert_eq!(recording_state(store, &id).await, failed);
}

pub(super) async fn a_new_file_of_a_version_is_progress(place: Place) {
    let store = place.store();
    submitted_dataset(store, "mugs").await;
    for attempt in 1..=2 {
        let claim = in_time(async || dataset(store, "a", LEASE).await).await;
        assert_eq!(claim.attempt, attempt);
        store.finish(&claim.lease, retry(true, Duration::ZERO)).await.expect("answers");
    }
    let claim = dataset(store, "a", LEASE).await.expect("there is work");
    store.record_dataset_file(&claim.lease, file("one", b"one")).await.expect("records");
    store.finish(&claim.lease, retry(true, Duration::ZERO)).await.expect("answers");
    let claim = dataset(store, "a", LEASE).await.expect("the third attempt was not the last one");
    assert_eq!(claim.attempt, 2);
    // The same file again is none.
    store.record_dataset_file(&claim.lease, file("one", b"one")).await.expect("records");
    store.finish(&claim.lease, retry(true, Duration::ZERO)).await.expect("answers");
    assert_eq!(dataset(store, "a", LEASE).await.expect("there is work").attempt, 3);
}

pub(super) async fn a_pause_holds_datasets_and_recordings(place: Place) {
    let (store, other) = (place.handle(0), place.handle(1));
    submitted_dataset(&store, "mugs").await;
    ordered(&store, 2).await;
    submitted(&store).await;
    let held = attempt(&store, "a", LEASE).await.expect("there is work");
    store.set_paused(true, "vendor is down").await.expect("pauses");
    assert_eq!(dataset(&other, "a", LEASE).await, None);
    assert_eq!(attempt(&other, "a", LEASE).await, None);
    assert!(store.claim("a", LEASE, MAX_DEATHS, &Scope::all()).await.expect("answers").is_none());
    // Submissions and held work go on.
    submitted_dataset(&other, "jugs").await;
    keep(&store, &held, made("success")).await.expect("keeps");
    let status = store.queue_status().await.expect("answers");
    assert_eq!(status.datasets, BackgroundWork { queued: 2, active: 0 });
    assert_eq!(status.recordings, BackgroundWork { queued: 7, active: 0 });
    assert_eq!((status.queued, status.active, status.workers), (10, 0, 0));
    store.set_paused(false, "").await.expect("resumes");
    assert!(dataset(&other, "a", LEASE).await.is_some());
    assert!(attempt(&other, "a", LEASE).await.is_some());
    let status = store.queue_status().await.expect("answers");
    assert_eq!(status.datasets, BackgroundWork { queued: 1, active: 1 });
    assert_eq!(status.recordings, BackgroundWork { queued: 6, active: 1 });
    assert_eq!(status.workers, 1);
}

pub(super) async fn work_of_any_kind_beside_other_work_is_not_blamed(place: Place) {
    let store = place.store();
    submitted_dataset(store, "mugs").await;
    ordered(store, 2).await;
    let (_, job) = submitted(store).await;
    let lease = Duration::from_millis(300);
    let freeze = dataset(store, "dead", lease).await.expect("there is work").lease.job_id;
    let attempted = attempt(store, "dead", lease).await.expect("there is work").lease.job_id;
    store.claim("dead", lease, MAX_DEATHS, &Scope::Job(job.clone())).await.expect("answers").expect("a job");
    tokio::time::sleep(Duration::from_millis(400)).await;
    assert_eq!(store.rescue(MAX_DEATHS).await.expect("answers"), 3);
    for job in [&freeze, &attempted, &job] {
        assert_eq!(deaths(store, job).await, (1, 0));
    }
}

pub(super) async fn suspects_of_any_kind_run_alone_in_their_process(place: Place) {
    let store = place.store();
    let suspect = submitted_dataset(store, "mugs").await;
    for owner in ["dead_1", "dead_2"] {
        let dead = in_time(async || dataset(store, owner, Duration::ZERO).await).await;
        assert_eq!(dataset_of(&dead).id, suspect);
    }
    let (_, job) = submitted(store).await;
    store.claim("busy", LEASE, MAX_DEATHS, &Scope::Job(job.clone())).await.expect("answers").expect("a job");
    // The rescue sets the delay after its second death, which ends.
    assert_eq!(dataset(store, "busy", LEASE).await, None);
    tokio::time::sleep(Duration::from_millis(1_100)).await;
    ordered(store, 2).await;
    submitted(store).await;
    assert_eq!(dataset(store, "busy", LEASE).await, None, "it reserves the suspect");
    assert_eq!(attempt(store, "busy", LEASE).await, None, "and takes nothing of another kind");
    assert!(store.claim("busy", LEASE, MAX_DEATHS, &Scope::all()).await.expect("answers").is_none());
    let alone = dataset(store, "idle", LEASE).await.expect("an idle process takes it at once");
    assert_eq!(dataset_of(&alone).id, suspect);
    assert_eq!(attempt(store, "idle", LEASE).await, None, "nothing runs beside it");
    assert!(store.claim("idle", LEASE, MAX_DEATHS, &Scope::all()).await.expect("answers").is_none());
    store.record_dataset_file(&alone.lease, file("one", b"one")).await.expect("records");
    assert!(attempt(store, "idle", LEASE).await.is_some(), "progress ends the suspicion");
}
