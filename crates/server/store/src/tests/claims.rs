//! The queue: order, uniqueness, leases, attempts, cancellation.

use std::collections::BTreeSet;

use super::*;
use crate::jobs::RetryOutcome;
use crate::lifecycle::{Failure, FailureClass, JobState};
use crate::queue::{AttemptOutcome, CancelOutcome};

fn failure() -> Failure {
    Failure { class: FailureClass::Transient, code: "test".into(), message: "a test".into() }
}

fn retry(delay: Duration, charged: bool) -> AttemptOutcome {
    AttemptOutcome::Retry { failure: failure(), delay, charged, max_attempts: 2 }
}

async fn state(store: &Store, job_id: &JobId) -> JobState {
    store.job(&DEFAULT_TENANT, job_id).await.expect("reads").expect("is there").state
}

pub(super) async fn jobs_are_claimed_oldest_first_and_once_each(place: Place) {
    let mut queued = Vec::new();
    for _ in 0..24 {
        queued.push(submitted(place.store()).await.1);
    }
    let first = claimed(place.store(), "first").await;
    assert_eq!(first.lease.job_id, queued[0]);
    assert_eq!((first.lease.epoch, first.attempt), (1, 1));
    let claims: Vec<_> = (0..48)
        .map(|index| {
            let store = place.handle(index);
            let owner = format!("worker {index}");
            tokio::spawn(async move { store.claim(&owner, Duration::from_secs(60), 3, &Scope::all()).await })
        })
        .collect();
    let mut taken = BTreeSet::new();
    for claim in claims {
        if let Some(claim) = claim.await.expect("runs").expect("claims") {
            assert!(taken.insert(claim.lease.job_id.clone()), "claimed twice");
        }
    }
    // A claim that finds every free row locked by others returns nothing.
    while let Some(claim) =
        place.store().claim("last", Duration::from_secs(60), 3, &Scope::all()).await.expect("claims")
    {
        assert!(taken.insert(claim.lease.job_id.clone()), "claimed twice");
    }
    assert_eq!(taken, queued.into_iter().skip(1).collect());
}

pub(super) async fn a_claim_may_be_restricted_to_one_job(place: Place) {
    let store = place.store();
    let (first, second) = (submitted(store).await.1, submitted(store).await.1);
    let claim =
        store.claim("w", Duration::from_secs(60), 3, &Scope::Job(second.clone())).await.expect("claims");
    assert_eq!(claim.expect("a job").lease.job_id, second);
    assert_eq!(
        store.claim("w", Duration::from_secs(60), 3, &Scope::Job(second.clone())).await.expect("claims"),
        None
    );
    assert_eq!(state(store, &first).await, JobState::Queued);
}

pub(super) async fn an_expired_lease_is_claimed_again_with_the_next_epoch(place: Place) {
    let (first, second) = (place.handle(0), place.handle(1));
    submitted(&first).await;
    let dead = first.claim("dead", Duration::ZERO, 3, &Scope::all()).await.expect("claims").expect("a job");
    let heir = second
        .claim("heir", Duration::from_secs(60), 3, &Scope::all())
        .await
        .expect("claims")
        .expect("a job");
    assert_eq!(heir.lease.job_id, dead.lease.job_id);
    assert_eq!((heir.lease.epoch, heir.attempt), (2, 1), "the death of a worker is no attempt");
    let renewed =
        first.renew(vec![dead.lease, heir.lease.clone()], Duration::from_secs(60)).await.expect("answers");
    assert_eq!(renewed[0].1, None, "the dead worker has no lease");
    assert_eq!(renewed[1], (heir.lease, Some(JobState::Running)));
}

pub(super) async fn a_job_whose_workers_died_too_often_fails(place: Place) {
    let store = place.store();
    let job = submitted(store).await.1;
    for _ in 0..2 {
        store.claim("dead", Duration::ZERO, 2, &Scope::all()).await.expect("claims").expect("a job");
    }
    assert_eq!(store.claim("next", Duration::from_secs(60), 2, &Scope::all()).await.expect("claims"), None);
    let job = store.job(&DEFAULT_TENANT, &job).await.expect("reads").expect("is there");
    assert_eq!((job.state, job.failure_code.as_deref()), (JobState::Failed, Some("worker_crashed")));
}

pub(super) async fn only_charged_attempts_count(place: Place) {
    let store = place.store();
    let job = submitted(store).await.1;
    for outcome in [AttemptOutcome::Released, retry(Duration::ZERO, false)] {
        let claim = claimed(store, "w").await;
        assert_eq!(claim.attempt, 1);
        assert_eq!(store.finish(&claim.lease, outcome).await.expect("finishes"), JobState::Queued);
    }
    let claim = claimed(store, "w").await;
    store.finish(&claim.lease, retry(Duration::ZERO, true)).await.expect("finishes");
    let claim = claimed(store, "w").await;
    assert_eq!(claim.attempt, 2);
    // A new checkpoint starts the count again.
    store.stage_finished(&claim.lease, &stage("alpha"), &checkpoint(), false).await.expect("commits");
    store.finish(&claim.lease, retry(Duration::ZERO, true)).await.expect("finishes");
    assert_eq!(state(store, &job).await, JobState::Queued);
    let claim = claimed(store, "w").await;
    let end = store.finish(&claim.lease, retry(Duration::ZERO, true)).await.expect("finishes");
    assert_eq!(end, JobState::Failed, "the second charged attempt since the checkpoint is the last");
}

pub(super) async fn a_delayed_job_waits(place: Place) {
    let store = place.store();
    submitted(store).await;
    let claim = claimed(store, "w").await;
    store.finish(&claim.lease, retry(Duration::from_millis(300), true)).await.expect("finishes");
    assert_eq!(store.claim("w", Duration::from_secs(60), 3, &Scope::all()).await.expect("claims"), None);
    tokio::time::sleep(Duration::from_millis(320)).await;
    assert_eq!(claimed(store, "w").await.lease.job_id, claim.lease.job_id);
}

pub(super) async fn a_scene_is_retried_once_at_a_time(place: Place) {
    let store = place.store();
    let job = submitted(store).await.1;
    let claim = claimed(store, "w").await;
    store.finish(&claim.lease, AttemptOutcome::Failed(failure())).await.expect("finishes");
    let retries: Vec<_> = (0..12)
        .map(|index| {
            let (store, job) = (place.handle(index), job.clone());
            tokio::spawn(async move { store.retry(&DEFAULT_TENANT, &job, None).await })
        })
        .collect();
    let mut created = 0;
    for retry in retries {
        match retry.await.expect("runs").expect("answers") {
            RetryOutcome::Created { .. } => created += 1,
            RetryOutcome::StillActive => {}
            other => panic!("{other:?}"),
        }
    }
    assert_eq!(created, 1);
}

pub(super) async fn a_cancellation_and_an_end_at_once_leave_one_final_state(place: Place) {
    for _ in 0..10 {
        let job = submitted(place.store()).await.1;
        let claim = claimed(place.store(), "w").await;
        let (one, other) = (place.handle(0), place.handle(1));
        let (ended, cancelled) = tokio::join!(
            one.finish(&claim.lease, AttemptOutcome::Failed(failure())),
            other.cancel(&DEFAULT_TENANT, &job)
        );
        let (ended, cancelled) = (ended.expect("finishes"), cancelled.expect("answers"));
        let expected = match cancelled {
            CancelOutcome::TooLate(JobState::Failed) => JobState::Failed,
            CancelOutcome::Accepted(JobState::Cancelling) => JobState::Cancelled,
            other => panic!("{other:?}"),
        };
        assert_eq!((ended, state(place.store(), &job).await), (expected, expected));
    }
}
