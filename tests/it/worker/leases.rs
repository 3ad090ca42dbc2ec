//! The fence: a worker whose lease expired changes nothing, even if it does not know about the expiry.

use std::collections::BTreeMap;
use std::time::Duration;

use scene::{JobId, SceneId};
use serde_json::json;
use store::artifacts::{ArchiveRow, BuiltScene, FileRow};
use store::checkpoints::{Checkpoint, StageKey};
use store::events::Event;
use store::lifecycle::{Failure, FailureClass};
use store::queue::{AttemptOutcome, Claim, Scope};
use store::scenes::NewScene;
use store::{DEFAULT_TENANT, Digest, Store, StoreError};

use crate::harness::server::opened;

const HOUR: Duration = Duration::from_secs(3600);

async fn store() -> (tempfile::TempDir, Store) {
    let directory = tempfile::tempdir().unwrap();
    let store = opened(directory.path()).await;
    let new = NewScene {
        tenant_id: DEFAULT_TENANT.clone(),
        parent_id: None,
        request: json!({ "seed": 1 }),
        labels: BTreeMap::new(),
        budget_micro_usd: 0,
        idempotency: None,
    };
    store.submit(new).await.unwrap();
    (directory, store)
}

async fn claim(store: &Store, owner: &str, lease: Duration) -> Claim {
    store.claim(owner, lease, 5, &Scope::all()).await.unwrap().expect("there is a job")
}

fn stage() -> StageKey {
    StageKey {
        tenant_id: DEFAULT_TENANT.clone(),
        stage: "alpha".into(),
        version: 1,
        instance: String::new(),
        key: Digest::of(b"key"),
    }
}

fn finished() -> Checkpoint {
    let artifact = FileRow {
        name: "alpha/zombie.txt".into(),
        digest: Digest::of(b"zombie"),
        media_type: "text/plain".into(),
        size: 6,
    };
    Checkpoint { output: Digest::of(b"output"), artifacts: vec![artifact], elapsed_ms: 1 }
}

fn built() -> AttemptOutcome {
    AttemptOutcome::Built(Box::new(BuiltScene {
        files: vec![],
        archive: ArchiveRow { digest: Digest::of(b"zip"), size: 3 },
        passed: true,
        reasons: vec![],
        summary: json!({}),
        metrics: json!({}),
    }))
}

fn retry(charged: bool) -> AttemptOutcome {
    let failure = Failure { class: FailureClass::Transient, code: "t".into(), message: "m".into() };
    AttemptOutcome::Retry { failure, delay: Duration::ZERO, charged, max_attempts: 5 }
}

#[tokio::test]
async fn every_write_of_a_zombie_is_refused() {
    let (_directory, store) = store().await;
    let zombie = claim(&store, "zombie", Duration::ZERO).await;
    let heir = claim(&store, "heir", HOUR).await;
    assert_eq!(heir.lease.epoch, zombie.lease.epoch + 1);
    let snapshot = |store: Store, job: JobId, scene: SceneId| async move {
        let events: Vec<Event> = store.events(&DEFAULT_TENANT, &job, 0, 100).await.unwrap();
        let job = store.job(&DEFAULT_TENANT, &job).await.unwrap().unwrap();
        let scene = store.scene(&DEFAULT_TENANT, &scene).await.unwrap().unwrap();
        format!("{events:?}{job:?}{scene:?}")
    };
    let shot = || {
        snapshot(store.clone(), heir.lease.job_id.clone(), heir.scene().expect("a scene").scene_id.clone())
    };
    let before = shot().await;

    let lost = |result: Result<(), StoreError>| assert!(matches!(result, Err(StoreError::LeaseLost { .. })));
    lost(store.stage_started(&zombie.lease, &stage()).await.map(|_| ()));
    lost(store.stage_finished(&zombie.lease, &stage(), &finished(), false).await);
    lost(store.stage_finished(&zombie.lease, &stage(), &finished(), true).await);
    lost(store.note(&zombie.lease, "alpha", "boo".into()).await);
    for outcome in [built(), retry(true), retry(false), AttemptOutcome::Released, AttemptOutcome::Stopped] {
        lost(store.finish(&zombie.lease, outcome).await.map(|_| ()));
    }
    let renewed = store.renew(vec![zombie.lease.clone(), heir.lease.clone()], HOUR).await.unwrap();
    assert_eq!(renewed[0].1, None);
    assert!(renewed[1].1.is_some());

    assert_eq!(shot().await, before);
    assert_eq!(store.checkpoint(&stage()).await.unwrap(), None);
    assert!(
        store.artifacts(&DEFAULT_TENANT, &heir.scene().expect("a scene").scene_id).await.unwrap().is_empty()
    );

    store.stage_finished(&heir.lease, &stage(), &finished(), false).await.unwrap();
    store.finish(&heir.lease, built()).await.unwrap();
    // Nor may it write about a job that has ended.
    lost(store.finish(&heir.lease, built()).await.map(|_| ()));
}

#[tokio::test]
async fn a_lease_that_lasts_is_not_taken() {
    let (_directory, store) = store().await;
    let held = claim(&store, "worker", HOUR).await;
    assert_eq!(store.claim("other", HOUR, 5, &Scope::all()).await.unwrap(), None);
    assert_eq!(store.expire_leases_of_others("worker").await.unwrap(), 0);
    assert_eq!(store.expire_leases_of_others("other").await.unwrap(), 1);
    assert_eq!(claim(&store, "other", HOUR).await.lease.job_id, held.lease.job_id);
}

#[tokio::test]
async fn only_what_is_charged_counts() {
    let (_directory, store) = store().await;
    for (outcome, next_attempt) in [
        (retry(false), 1),
        (AttemptOutcome::Released, 1),
        (retry(true), 2),
        (retry(false), 2),
        (retry(true), 3),
    ] {
        let held = claim(&store, "worker", HOUR).await;
        store.finish(&held.lease, outcome).await.unwrap();
        let held = claim(&store, "worker", HOUR).await;
        assert_eq!(held.attempt, next_attempt);
        store.finish(&held.lease, AttemptOutcome::Released).await.unwrap();
    }
    // A new checkpoint starts the count again.
    let held = claim(&store, "worker", HOUR).await;
    store.stage_finished(&held.lease, &stage(), &finished(), false).await.unwrap();
    store.finish(&held.lease, retry(true)).await.unwrap();
    assert_eq!(claim(&store, "worker", HOUR).await.attempt, 2);
}

#[tokio::test]
async fn success_after_a_cancellation_is_a_cancellation() {
    let (_directory, store) = store().await;
    let held = claim(&store, "worker", HOUR).await;
    store.cancel(&DEFAULT_TENANT, &held.lease.job_id).await.unwrap();
    assert_eq!(store.finish(&held.lease, built()).await.unwrap().as_str(), "cancelled");
    assert!(
        store
            .archive(&DEFAULT_TENANT, &held.scene().expect("a scene").scene_id, "all")
            .await
            .unwrap()
            .is_none()
    );
}

#[tokio::test]
async fn a_worker_for_one_job_leaves_the_others_alone() {
    let (_directory, store) = store().await;
    let another: JobId = "another".parse().unwrap();
    assert_eq!(store.claim("worker", HOUR, 5, &Scope::Job(another.clone())).await.unwrap(), None);
    let job = store.scenes(&DEFAULT_TENANT, store::scenes::SceneFilter { limit: 1, ..Default::default() });
    let job = store.latest_job(&DEFAULT_TENANT, &job.await.unwrap()[0].0.id).await.unwrap().unwrap();
    assert!(store.claim("worker", HOUR, 5, &Scope::Job(job.id.clone())).await.unwrap().is_some());
}

#[tokio::test]
async fn a_job_that_changes_its_state_meanwhile_is_counted_once() {
    let (_directory, store) = store().await;
    let changing = tokio::spawn({
        let store = store.clone();
        async move {
            for _ in 0..200 {
                let claim = claim(&store, "worker", HOUR).await;
                store.finish(&claim.lease, retry(false)).await.unwrap();
            }
        }
    });
    let (mut counted, mut states) = (0, BTreeMap::new());
    while !changing.is_finished() {
        let counts = store.job_counts().await.unwrap();
        assert_eq!(counts.iter().map(|(_, count)| count).sum::<i64>(), 1, "{counts:?}");
        counts.iter().filter(|(_, count)| *count > 0).for_each(|(state, _)| {
            states.insert(state.as_str(), ());
        });
        counted += 1;
    }
    changing.await.unwrap();
    assert!(counted > 20 && states.len() > 1, "{counted} {states:?}");
}
