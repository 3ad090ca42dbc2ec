//! Datasets and recordings by the rules of jobs: pauses, deaths of processes, isolation, failed attempts.

use super::datasets::{file, submitted_dataset};
use super::recordings::{assembly, episode_lost, made, new_recording};
use super::*;
use crate::datasets::{DatasetClaim, DatasetState};
use crate::queue::BackgroundWork;
use crate::recordings::{AttemptLease, RecordingState, RecordingWork, SubmitRecordingOutcome};
use crate::{AfterSetback, Setback};
use scene::{DatasetId, RecordingId};

const LEASE: Duration = Duration::from_secs(60);

async fn ordered(store: &Store, wanted: u64) -> RecordingId {
    match store.submit_recording(new_recording(wanted, 99)).await.expect("submits") {
        SubmitRecordingOutcome::Created(id) => id,
        other => panic!("{other:?}"),
    }
}

async fn attempt(store: &Store, owner: &str, lease: Duration) -> Option<AttemptLease> {
    let claim = store.claim_recording(owner, lease, MAX_DEATHS).await.expect("answers")?;
    match claim.work {
        RecordingWork::Attempt(attempt) => Some(attempt),
        RecordingWork::Assembly(_) => panic!("attempts are missing"),
    }
}

async fn dataset(store: &Store, owner: &str, lease: Duration) -> Option<DatasetClaim> {
    store.claim_dataset(owner, lease, MAX_DEATHS).await.expect("answers")
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

/// Shared and lone deaths of a row.
async fn deaths(store: &Store, table: &'static str, id: &str) -> (i64, i64) {
    let query = format!("SELECT shared_deaths, lone_deaths FROM {table} WHERE id = $1");
    sqlx::query_as(sqlx::AssertSqlSafe(query)).bind(id).fetch_one(&store.readers).await.expect("reads")
}

async fn recording_state(store: &Store, id: &RecordingId) -> (RecordingState, Option<String>) {
    let row = store.recording(&DEFAULT_TENANT, id).await.expect("reads").expect("is there");
    (row.state, row.failure_code)
}

async fn dataset_state(store: &Store, id: &DatasetId) -> (DatasetState, Option<String>) {
    let row = store.dataset(&DEFAULT_TENANT, id).await.expect("reads").expect("is there");
    (row.state, row.failure_code)
}

pub(super) async fn a_recording_outlasts_kills_while_attempts_are_finished_between(place: Place) {
    let store = place.store();
    let id = ordered(store, 20).await;
    for kill in 0..8 {
        // The same attempt is lost again and again, and another one is finished each time.
        let owner = format!("dead_{kill}");
        let lost = attempt(store, &owner, Duration::ZERO).await.expect("there is work");
        assert_eq!(lost.number, 0, "what nobody makes any more comes first");
        let again = attempt(store, "keeper", LEASE).await.expect("goes on at once");
        assert_eq!((again.number, deaths(store, "recordings", id.as_str()).await), (0, (0, 1)));
        let next = attempt(store, "keeper", LEASE).await.expect("there is work");
        store.keep_attempt(&next, made("success")).await.expect("keeps");
        assert_eq!(deaths(store, "recordings", id.as_str()).await, (0, 0), "deaths count anew");
        store.release_attempt(&again).await.expect("gives back");
    }
    assert_eq!(recording_state(store, &id).await, (RecordingState::Running, None));
}

pub(super) async fn a_recording_that_kills_its_process_alone_waits_and_fails(place: Place) {
    let store = place.store();
    let id = ordered(store, 2).await;
    for death in 1..=i64::from(MAX_DEATHS) {
        let owner = format!("dead_{death}");
        in_time(async || attempt(store, &owner, Duration::ZERO).await).await;
        if death == 3 {
            break;
        }
        let next = attempt(store, "observer", Duration::ZERO).await;
        assert_eq!(deaths(store, "recordings", id.as_str()).await, (0, death));
        // After the first death it goes on at once, after the second it waits.
        assert_eq!(next.is_some(), death == 1);
        if let Some(next) = next {
            store.release_attempt(&next).await.expect("gives back");
        }
    }
    assert_eq!(attempt(store, "heir", LEASE).await, None);
    let failed = (RecordingState::Failed, Some("interrupted_too_often".to_owned()));
    assert_eq!(recording_state(store, &id).await, failed);
    let row = store.recording(&DEFAULT_TENANT, &id).await.expect("reads").expect("is there");
    let message = row.failure_message.expect("says why");
    assert!(message.contains("died 3 times") && message.contains("finished no attempt"), "{message}");
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
    let failed = (DatasetState::Failed, Some("interrupted_too_often".to_owned()));
    assert_eq!(dataset_state(store, &id).await, failed);
}

fn setback(charged: bool, delay: Duration) -> Setback {
    let message = "a bug stopped the work".to_owned();
    Setback { code: "internal_error", message, delay, charged, max_attempts: 3 }
}

pub(super) async fn a_freeze_that_fails_is_tried_again_after_a_delay_and_so_often(place: Place) {
    let store = place.store();
    let id = submitted_dataset(store, "mugs").await;
    let delay = Duration::from_millis(300);
    // What storage could not write burns no attempt.
    for _ in 0..4 {
        let claim = dataset(store, "a", LEASE).await.expect("there is work");
        assert_eq!(claim.attempt, 1);
        let after = store.set_dataset_back(&claim.lease, setback(false, Duration::ZERO)).await;
        assert_eq!(after.expect("answers"), AfterSetback::Again);
    }
    for attempt in 1..=3 {
        let claim = in_time(async || dataset(store, "a", LEASE).await).await;
        assert_eq!(claim.attempt, attempt);
        let after = store.set_dataset_back(&claim.lease, setback(true, delay)).await.expect("answers");
        assert_eq!(after, if attempt == 3 { AfterSetback::Ended } else { AfterSetback::Again });
        assert_eq!(dataset(store, "a", LEASE).await, None, "it waits, or is over");
    }
    let failed = (DatasetState::Failed, Some("internal_error".to_owned()));
    assert_eq!(dataset_state(store, &id).await, failed);
    let other = submitted_dataset(store, "mugs").await;
    assert_eq!(dataset(store, "a", LEASE).await.expect("there is work").lease.id, other);
}

pub(super) async fn an_attempt_that_fails_is_tried_again_after_a_delay_and_so_often(place: Place) {
    let store = place.store();
    let id = ordered(store, 20).await;
    // What storage could not write burns no try.
    for _ in 0..4 {
        let lease = attempt(store, "a", LEASE).await.expect("there is work");
        assert_eq!(lease.number, 0);
        let after = store.set_attempt_back(&lease, setback(false, Duration::ZERO)).await;
        assert_eq!(after.expect("answers"), AfterSetback::Again);
    }
    for tries in 1..=3 {
        let claim = in_time(async || {
            let claim = store.claim_recording("a", LEASE, MAX_DEATHS).await.expect("answers")?;
            let RecordingWork::Attempt(lease) = &claim.work else { panic!("attempts are missing") };
            match lease.number {
                0 => Some(claim),
                // Others go on meanwhile, which changes nothing for the one that cannot be made.
                _ => {
                    store.keep_attempt(lease, made("success")).await.expect("keeps");
                    None
                }
            }
        });
        let claim = claim.await;
        assert_eq!(claim.tries, tries);
        let RecordingWork::Attempt(lease) = claim.work else { panic!("attempts are missing") };
        let set_back = store.set_attempt_back(&lease, setback(true, Duration::from_millis(120)));
        let after = set_back.await.expect("answers");
        assert_eq!(after, if tries == 3 { AfterSetback::Ended } else { AfterSetback::Again });
        let next = attempt(store, "a", LEASE).await;
        assert_ne!(next.as_ref().map(|lease| lease.number), Some(0), "it waits, or is over");
        if let Some(next) = next {
            store.keep_attempt(&next, made("success")).await.expect("keeps");
        }
    }
    let failed = (RecordingState::Failed, Some("internal_error".to_owned()));
    assert_eq!(recording_state(store, &id).await, failed);
    assert_eq!(attempt(store, "a", LEASE).await, None);
}

pub(super) async fn assembling_that_fails_is_tried_again_after_a_delay_and_so_often(place: Place) {
    let store = place.store();
    let id = ordered(store, 1).await;
    let lease = attempt(store, "a", LEASE).await.expect("there is work");
    store.keep_attempt(&lease, made("success")).await.expect("keeps");
    // Neither what storage could not write, nor what was given back, nor a death burns a try.
    let lease = assembly(store, "a").await;
    store.set_assembly_back(&lease, setback(false, Duration::ZERO)).await.expect("answers");
    let lease = assembly(store, "a").await;
    store.release_assembly(&lease).await.expect("gives back");
    store.claim_recording("dead", Duration::ZERO, MAX_DEATHS).await.expect("answers").expect("there is work");
    for tries in 1..=3 {
        let claim = async || store.claim_recording("a", LEASE, MAX_DEATHS).await.expect("answers");
        let claimed = in_time(claim).await;
        assert_eq!(claimed.tries, tries);
        let RecordingWork::Assembly(lease) = claimed.work else { panic!("all attempts are made") };
        let set_back = store.set_assembly_back(&lease, setback(true, Duration::from_millis(200)));
        let after = set_back.await.expect("answers");
        assert_eq!(after, if tries == 3 { AfterSetback::Ended } else { AfterSetback::Again });
        assert_eq!(claim().await, None, "it waits, or is over");
        let late = store.set_assembly_back(&lease, setback(true, Duration::ZERO)).await;
        assert!(matches!(late, Err(StoreError::RecordingLeaseLost { .. })), "{late:?}");
    }
    let failed = (RecordingState::Failed, Some("internal_error".to_owned()));
    assert_eq!(recording_state(store, &id).await, failed);
}

pub(super) async fn an_episode_that_is_lost_again_and_again_ends_its_recording(place: Place) {
    let store = place.store();
    let id = ordered(store, 1).await;
    for loss in 1..=3 {
        let lease = attempt(store, "a", LEASE).await.expect("it is made again");
        assert_eq!(lease.number, 0);
        store.keep_attempt(&lease, made("success")).await.expect("keeps");
        let lease = assembly(store, "a").await;
        let after = store.forget_attempt(&lease, 0, episode_lost()).await.expect("answers");
        assert_eq!(after, if loss == 3 { AfterSetback::Ended } else { AfterSetback::Again });
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
        store.set_dataset_back(&claim.lease, setback(true, Duration::ZERO)).await.expect("answers");
    }
    let claim = dataset(store, "a", LEASE).await.expect("there is work");
    store.record_dataset_file(&claim.lease, file("one", b"one")).await.expect("records");
    store.set_dataset_back(&claim.lease, setback(true, Duration::ZERO)).await.expect("answers");
    let claim = dataset(store, "a", LEASE).await.expect("the third attempt was not the last one");
    assert_eq!(claim.attempt, 2);
    // The same file again is none.
    store.record_dataset_file(&claim.lease, file("one", b"one")).await.expect("records");
    store.set_dataset_back(&claim.lease, setback(true, Duration::ZERO)).await.expect("answers");
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
    assert!(store.claim("a", LEASE, MAX_DEATHS, None).await.expect("answers").is_none());
    // Submissions and held work go on.
    submitted_dataset(&other, "jugs").await;
    store.keep_attempt(&held, made("success")).await.expect("keeps");
    let status = store.queue_status().await.expect("answers");
    assert_eq!(status.datasets, BackgroundWork { queued: 2, active: 0 });
    assert_eq!(status.recordings, BackgroundWork { queued: 1, active: 0 });
    assert_eq!((status.queued, status.active, status.workers), (1, 0, 0));
    store.set_paused(false, "").await.expect("resumes");
    assert!(dataset(&other, "a", LEASE).await.is_some());
    assert!(attempt(&other, "a", LEASE).await.is_some());
    let status = store.queue_status().await.expect("answers");
    assert_eq!(status.datasets, BackgroundWork { queued: 1, active: 1 });
    assert_eq!(status.recordings, BackgroundWork { queued: 0, active: 1 });
    assert_eq!(status.workers, 1);
}

pub(super) async fn work_of_any_kind_beside_other_work_is_not_blamed(place: Place) {
    let store = place.store();
    let (frozen, recorded) = (submitted_dataset(store, "mugs").await, ordered(store, 2).await);
    let (_, job) = submitted(store).await;
    dataset(store, "dead", Duration::ZERO).await.expect("there is work");
    attempt(store, "dead", Duration::from_millis(300)).await.expect("there is work");
    store.claim("dead", Duration::from_millis(300), MAX_DEATHS, None).await.expect("answers").expect("a job");
    tokio::time::sleep(Duration::from_millis(400)).await;
    // Each is rescued by a claim of its own kind, one after the other.
    dataset(store, "heir", LEASE).await.expect("goes on at once");
    attempt(store, "heir", LEASE).await.expect("goes on at once");
    assert_eq!(store.rescue(MAX_DEATHS).await.expect("answers"), 1);
    assert_eq!(deaths(store, "datasets", frozen.as_str()).await, (1, 0));
    assert_eq!(deaths(store, "recordings", recorded.as_str()).await, (1, 0));
    assert_eq!(deaths(store, "jobs", job.as_str()).await, (1, 0));
}

pub(super) async fn suspects_of_any_kind_run_alone_in_their_process(place: Place) {
    let store = place.store();
    let suspect = submitted_dataset(store, "mugs").await;
    for owner in ["dead_1", "dead_2"] {
        let dead = in_time(async || dataset(store, owner, Duration::ZERO).await).await;
        assert_eq!(dead.lease.id, suspect);
    }
    let (_, job) = submitted(store).await;
    store.claim("busy", LEASE, MAX_DEATHS, Some(&job)).await.expect("answers").expect("a job");
    // The rescue sets the delay after its second death, which ends.
    assert_eq!(dataset(store, "busy", LEASE).await, None);
    tokio::time::sleep(Duration::from_millis(1_100)).await;
    ordered(store, 2).await;
    submitted(store).await;
    assert_eq!(dataset(store, "busy", LEASE).await, None, "it reserves the suspect");
    assert_eq!(attempt(store, "busy", LEASE).await, None, "and takes nothing of another kind");
    assert!(store.claim("busy", LEASE, MAX_DEATHS, None).await.expect("answers").is_none());
    let alone = dataset(store, "idle", LEASE).await.expect("an idle process takes it at once");
    assert_eq!(alone.lease.id, suspect);
    assert_eq!(attempt(store, "idle", LEASE).await, None, "nothing runs beside it");
    assert!(store.claim("idle", LEASE, MAX_DEATHS, None).await.expect("answers").is_none());
    store.record_dataset_file(&alone.lease, file("one", b"one")).await.expect("records");
    assert!(attempt(store, "idle", LEASE).await.is_some(), "progress ends the suspicion");
}
