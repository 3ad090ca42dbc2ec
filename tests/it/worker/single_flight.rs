//! Two workers on one database: a stage is computed once, and jobs of dead workers are found while workers are busy.

use std::sync::Arc;
use std::time::Duration;

use scene::JobId;
use serde_json::json;
use store::lifecycle::JobState;
use store::queue::Scope;
use store::scenes::{NewScene, SubmitOutcome};
use store::{DEFAULT_TENANT, Store};
use tabletopgen::app;
use tokio_util::sync::CancellationToken;

use crate::harness::databases::on_each_database;
use crate::harness::script::{Act, Script};
use crate::harness::server::settings;

async fn submit(store: &Store) -> JobId {
    let new = NewScene {
        tenant_id: DEFAULT_TENANT.clone(),
        parent_id: None,
        request: json!({ "version": 1, "input": { "kind": "text", "text": "a mug" }, "seed": 7, "options": {} }),
        labels: Default::default(),
        budget_micro_usd: 0,
        idempotency: None,
    };
    match store.submit(new).await.unwrap() {
        SubmitOutcome::Created { job_id, .. } => job_id,
        other => panic!("{other:?}"),
    }
}

/// A worker with its own locks, as in a process of its own.
fn start_worker(store: &Store, script: &Arc<Script>, stop: &CancellationToken) {
    let mut config = settings(&[("worker.concurrency", "1")]).config;
    config.worker.drain_grace_secs = 0;
    let worker = app::worker(store, &config, &app::cpu_pool(&config).unwrap(), script.build());
    tokio::spawn(worker.run(stop.clone()));
}

async fn ends(store: &Store, job: &JobId) -> JobState {
    let ended = async {
        loop {
            let state = store.job(&DEFAULT_TENANT, job).await.unwrap().unwrap().state;
            if state.is_final() {
                return state;
            }
            tokio::time::sleep(Duration::from_millis(20)).await;
        }
    };
    tokio::time::timeout(Duration::from_secs(30), ended).await.expect("the job ends")
}

/// Waits until the job says that it waits for another one's stage.
async fn waits(store: &Store, jobs: [&JobId; 2]) {
    let waits = async {
        loop {
            for job in jobs {
                let events = store.events(&DEFAULT_TENANT, job, 0, 100).await.unwrap();
                let says = |text: &str| text.contains("computes the same");
                if events.iter().any(|event| event.data["message"].as_str().is_some_and(says)) {
                    return;
                }
            }
            tokio::time::sleep(Duration::from_millis(20)).await;
        }
    };
    tokio::time::timeout(Duration::from_secs(20), waits).await.expect("one job waits for the other");
}

#[tokio::test]
async fn two_workers_compute_the_same_stages_once() {
    on_each_database(async |store: Store| {
        let (script, stop) = (Script::new(&[("alpha", &[Act::Wait])]), CancellationToken::new());
        for _ in 0..2 {
            start_worker(&store, &script, &stop);
        }
        let jobs = [submit(&store).await, submit(&store).await];
        waits(&store, [&jobs[0], &jobs[1]]).await;
        // A job waits from the moment another one holds the stage, which may be before that one has begun it.
        script.reaches("alpha").await;
        assert_eq!(script.runs(), ["alpha"]);
        script.open_gate();
        for job in &jobs {
            assert_eq!(ends(&store, job).await, JobState::Succeeded);
        }
        assert_eq!(script.runs().len(), 4, "{:?}", script.runs());
        stop.cancel();
    })
    .await;
}

#[tokio::test]
async fn a_failed_stage_is_passed_on_to_the_job_that_waits_for_it() {
    on_each_database(async |store: Store| {
        let plan: [(&'static str, &[Act]); 1] = [("alpha", &[Act::Wait, Act::Wait])];
        let (script, stop) = (Script::new(&plan), CancellationToken::new());
        for _ in 0..2 {
            start_worker(&store, &script, &stop);
        }
        let jobs = [submit(&store).await, submit(&store).await];
        waits(&store, [&jobs[0], &jobs[1]]).await;
        // The job that computes is cancelled; the other one computes in its place.
        let mut states = Vec::new();
        for job in &jobs {
            let stages = store.stages(&DEFAULT_TENANT, job).await.unwrap();
            states.push(stages.iter().any(|stage| stage.state == "running"));
        }
        let computing = states.iter().position(|computes| *computes).expect("one computes");
        store.cancel(&DEFAULT_TENANT, &jobs[computing]).await.unwrap();
        assert_eq!(ends(&store, &jobs[computing]).await, JobState::Cancelled);
        script.open_gate();
        assert_eq!(ends(&store, &jobs[1 - computing]).await, JobState::Succeeded);
        assert_eq!(script.runs().iter().filter(|run| *run == "alpha").count(), 2);
        stop.cancel();
    })
    .await;
}

/// A job may wait, in the last free slot of all workers, for a stage of a job whose worker has died.
#[tokio::test]
async fn a_worker_without_a_free_slot_rescues_the_jobs_of_dead_workers() {
    on_each_database(async |store: Store| {
        let (script, stop) = (Script::new(&[("alpha", &[Act::Wait])]), CancellationToken::new());
        start_worker(&store, &script, &stop);
        let busy = submit(&store).await;
        script.reaches("alpha").await;
        let orphan = submit(&store).await;
        let dead = store
            .claim("dead", Duration::from_millis(200), 9, &Scope::Job(orphan.clone()))
            .await
            .unwrap()
            .unwrap();
        let rescued = async {
            while store.job(&DEFAULT_TENANT, &orphan).await.unwrap().unwrap().state != JobState::Queued {
                tokio::time::sleep(Duration::from_millis(20)).await;
            }
        };
        tokio::time::timeout(Duration::from_secs(20), rescued).await.expect("it is back in the queue");
        assert!(store.note(&dead.lease, "alpha", "late".into()).await.is_err());
        script.open_gate();
        for job in [&busy, &orphan] {
            assert_eq!(ends(&store, job).await, JobState::Succeeded);
        }
        stop.cancel();
    })
    .await;
}
