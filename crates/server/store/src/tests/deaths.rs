//! Jobs whose processes died: who is blamed, who runs alone, and what is said about a job that kills its workers.

use std::collections::BTreeSet;

use super::*;
use crate::lifecycle::JobState;

async fn queued(store: &Store) -> JobId {
    submitted(store).await.1
}

/// A claim whose lease has run out already.
async fn doomed(store: &Store, owner: &str) -> Claim {
    let claim = async {
        loop {
            if let Some(claim) =
                store.claim(owner, Duration::ZERO, MAX_DEATHS, &Scope::all()).await.expect("answers")
            {
                return claim;
            }
            tokio::time::sleep(Duration::from_millis(50)).await;
        }
    };
    tokio::time::timeout(Duration::from_secs(20), claim).await.expect("its delay ends")
}

async fn kinds(store: &Store, job: &JobId) -> Vec<String> {
    store
        .events(&DEFAULT_TENANT, job, 0, 100)
        .await
        .expect("answers")
        .into_iter()
        .map(|event| event.kind)
        .collect()
}

fn beta() -> StageKey {
    StageKey { instance: "mug_1".into(), ..stage("beta") }
}

async fn claim(store: &Store, owner: &str) -> Option<Claim> {
    store.claim(owner, Duration::from_secs(60), MAX_DEATHS, &Scope::all()).await.expect("claims")
}

pub(super) async fn no_job_is_charged_for_a_shared_death(place: Place) {
    let store = place.handle(0);
    let jobs: BTreeSet<JobId> = [queued(&store).await, queued(&store).await].into();
    // The leases of both run out, one after the other, as a claim is later than the other.
    let first = store
        .claim("dead", Duration::ZERO, MAX_DEATHS, &Scope::all())
        .await
        .expect("answers")
        .expect("answers");
    let not_first = other(&jobs, &first);
    let scope = Scope::Job(not_first.clone());
    let second = store.claim("dead", Duration::from_millis(300), MAX_DEATHS, &scope);
    let second = second.await.expect("answers").expect("answers");
    assert_eq!(store.rescue(MAX_DEATHS).await.expect("answers"), 1);
    tokio::time::sleep(Duration::from_millis(400)).await;
    assert_eq!(store.rescue(MAX_DEATHS).await.expect("answers"), 1);
    for claim in [&first, &second] {
        let events = store.events(&DEFAULT_TENANT, &claim.lease.job_id, 0, 10).await.expect("answers");
        let orphaned = events.iter().find(|event| event.kind == "job_orphaned").expect("is noted");
        assert_eq!(orphaned.data["alone"], false, "{orphaned:?}");
        assert_eq!(orphaned.data["shared_deaths"], 1);
        assert_eq!(orphaned.data["lone_deaths"], 0);
    }
    // Both go on at once, side by side, and the death is no attempt.
    let again: BTreeSet<JobId> = [claimed(&store, "heir").await, claimed(&store, "heir").await]
        .map(|claim| {
            assert_eq!(claim.attempt, 1);
            claim.lease.job_id
        })
        .into();
    assert_eq!(again, jobs);
}

fn other(jobs: &BTreeSet<JobId>, claim: &Claim) -> JobId {
    jobs.iter().find(|job| **job != claim.lease.job_id).expect("there are two").clone()
}

/// Two jobs of one process die together twice. From then on each runs alone, and only the one that kills its process
/// alone is blamed.
pub(super) async fn after_two_deaths_a_job_runs_alone_until_its_next_checkpoint(place: Place) {
    let store = place.handle(0);
    let (a, b) = (queued(&store).await, queued(&store).await);
    for owner in ["dead_1", "dead_2"] {
        for job in [&a, &b] {
            store
                .claim(owner, Duration::from_millis(50), MAX_DEATHS, &Scope::Job(job.clone()))
                .await
                .expect("answers")
                .expect("answers");
        }
        tokio::time::sleep(Duration::from_millis(100)).await;
        assert_eq!(store.rescue(MAX_DEATHS).await.expect("answers"), 2);
    }
    let bystander = queued(&store).await;
    let alone = claimed(&store, "heir").await;
    assert_eq!(alone.lease.job_id, a);
    assert_eq!(claim(&store, "heir").await, None, "it holds a job that has to be alone");
    // Another process takes the second suspect, and nothing beside it either.
    assert_eq!(claimed(&store, "neighbor").await.lease.job_id, b);
    assert_eq!(claim(&store, "neighbor").await, None);
    assert_eq!(claimed(&store, "third").await.lease.job_id, bystander);
    // A new checkpoint clears the suspicion.
    queued(&store).await;
    store.stage_finished(&alone.lease, &beta(), &checkpoint(), false).await.expect("answers");
    assert!(claim(&store, "heir").await.is_some());
}

pub(super) async fn a_busy_worker_makes_room_for_a_suspect_while_others_go_on(place: Place) {
    let store = place.handle(0);
    let suspect = queued(&store).await;
    for owner in ["dead_1", "dead_2"] {
        store
            .claim(owner, Duration::ZERO, 9, &Scope::Job(suspect.clone()))
            .await
            .expect("answers")
            .expect("answers");
        store.rescue(9).await.expect("answers");
    }
    let (one, two) = (queued(&store).await, queued(&store).await);
    for (owner, job) in [("busy", &one), ("also_busy", &two)] {
        store
            .claim(owner, Duration::from_secs(60), 9, &Scope::Job(job.clone()))
            .await
            .expect("answers")
            .expect("answers");
    }
    // The suspect's delay after its second lone death ends.
    let three = queued(&store).await;
    tokio::time::sleep(Duration::from_millis(1100)).await;
    assert_eq!(claim(&store, "busy").await, None, "it reserves the suspect and waits to be idle");
    assert_eq!(claimed(&store, "also_busy").await.lease.job_id, three);
    assert_eq!(claimed(&store, "idle").await.lease.job_id, suspect);
    let four = queued(&store).await;
    assert_eq!(claimed(&store, "busy").await.lease.job_id, four);
}

pub(super) async fn a_job_that_kills_its_process_alone_is_failed_with_a_diagnosis(place: Place) {
    let store = place.handle(0);
    let poison = queued(&store).await;
    for death in 1..=MAX_DEATHS {
        let claim = doomed(&store, &format!("dead_{death}")).await;
        assert_eq!((&claim.lease.job_id, claim.attempt), (&poison, 1));
        store.stage_started(&claim.lease, &beta()).await.expect("answers");
        assert_eq!(store.rescue(MAX_DEATHS).await.expect("answers"), 1);
    }
    let row = store.job(&DEFAULT_TENANT, &poison).await.expect("answers").expect("answers");
    assert_eq!((row.state, row.failure_code.as_deref()), (JobState::Failed, Some("worker_crashed")));
    assert_eq!(row.failure_class.as_deref(), Some("crashed"));
    let message = row.failure_message.expect("answers");
    assert!(message.contains("died 3 times") && message.contains("last in beta"), "{message}");
    let events = store.events(&DEFAULT_TENANT, &poison, 0, 100).await.expect("answers");
    let failed = events.last().expect("answers");
    assert_eq!(failed.kind, "job_failed");
    let diagnosis = &failed.data["diagnosis"];
    assert_eq!((&diagnosis["lone_deaths"], &diagnosis["alone"]), (&3.into(), &true.into()));
    assert_eq!(diagnosis["stages"][0]["stage"], "beta");
    assert_eq!(diagnosis["stages"][0]["instance"], "mug_1");
    assert_eq!(diagnosis["stages"][0]["runs"], 3);
    assert_eq!(diagnosis["events"][0]["kind"], "stage_started");
    let delays: Vec<i64> = events
        .iter()
        .filter(|event| event.kind == "job_orphaned")
        .map(|event| event.data["delay_ms"].as_i64().expect("answers"))
        .collect();
    assert_eq!(delays, [0, 1000]);
    let status = store.queue_status().await.expect("answers");
    assert_eq!(status.poisoned, [poison.to_string()]);
}

pub(super) async fn a_job_that_is_cancelled_while_its_worker_is_dead_needs_no_worker(place: Place) {
    let store = place.handle(0);
    let job = queued(&store).await;
    store
        .claim("dead", Duration::from_millis(50), MAX_DEATHS, &Scope::all())
        .await
        .expect("answers")
        .expect("answers");
    store.cancel(&DEFAULT_TENANT, &job).await.expect("answers");
    tokio::time::sleep(Duration::from_millis(100)).await;
    assert_eq!(store.rescue(MAX_DEATHS).await.expect("answers"), 1);
    let row = store.job(&DEFAULT_TENANT, &job).await.expect("answers").expect("answers");
    assert_eq!(row.state, JobState::Cancelled);
    assert_eq!(kinds(&store, &job).await.last().map(String::as_str), Some("job_cancelled"));
}
