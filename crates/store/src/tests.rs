//! Tests of the whole store.

use std::collections::BTreeMap;
use std::time::Duration;

use serde_json::json;

use super::artifacts::ArchiveRow;
use super::calls::{NewCall, Reservation, Spending};
use super::checkpoints::{Checkpoint, StageKey};
use super::jobs::RetryOutcome;
use super::queue::CancelOutcome;
use super::scenes::{DeleteOutcome, NewScene, SceneFilter, SubmitOutcome};
use super::*;

async fn opened() -> (tempfile::TempDir, Store) {
    let directory = tempfile::tempdir().expect("temporary directory");
    let settings = Settings { fsync: false, blobs: BlobPlace::Memory, readers: 1, busy_timeout_ms: 1000 };
    let store = Store::open(directory.path(), &settings).await.expect("opens");
    (directory, store)
}

#[tokio::test]
async fn queries_of_another_tenant_find_and_change_nothing() {
    let (_directory, store) = opened().await;
    let owner: &TenantId = &DEFAULT_TENANT;
    let other: TenantId = "other".parse().expect("an id");
    let new = NewScene {
        tenant_id: owner.clone(),
        request: json!({}),
        labels: BTreeMap::new(),
        budget_micro_usd: 1_000,
        idempotency: None,
    };
    let SubmitOutcome::Created { scene_id: scene, job_id: job } = store.submit(new).await.expect("submits")
    else {
        panic!("the submission has no key")
    };
    let claim =
        store.claim("worker", Duration::from_secs(60), 3, None).await.expect("claims").expect("a job");
    let file = artifacts::FileRow {
        name: "alpha/note.txt".into(),
        digest: Digest::of(b"note"),
        media_type: "text/plain".into(),
        size: 4,
    };
    let key = StageKey {
        tenant_id: owner.clone(),
        stage: "alpha".into(),
        version: 1,
        instance: String::new(),
        key: Digest::of(b"key"),
    };
    let checkpoint = Checkpoint { output: Digest::of(b"output"), artifacts: vec![file], elapsed_ms: 1 };
    store.stage_finished(&claim.lease, &key, &checkpoint, false).await.expect("commits");
    let call = NewCall {
        stage: "alpha".into(),
        instance: String::new(),
        port: "analyst".into(),
        provider: "p".into(),
        model: "m".into(),
        endpoint: "e".into(),
        operation: "o".into(),
        request_digest: "d".into(),
        idempotency_key: "k".into(),
        attempt: 1,
        reserved_micro_usd: 400,
        sent_bytes: 1,
        refuse_after_unknown: false,
    };
    assert!(matches!(store.reserve_call(&claim.lease, call).await, Ok(Reservation::Granted(_))));
    let archive = ArchiveRow { digest: Digest::of(b"zip"), size: 3 };
    store.record_archive(&other, &scene, "mjcf", archive.clone()).await.expect("answers");
    store.record_archive(owner, &scene, "urdf", archive.clone()).await.expect("records");

    for (tenant, count) in [(owner, 1), (&other, 0)] {
        let all = SceneFilter { limit: 10, ..SceneFilter::default() };
        assert_eq!(store.scenes(tenant, all).await.expect("reads").len(), count);
        assert_eq!(store.scene(tenant, &scene).await.expect("reads").iter().count(), count);
        assert_eq!(store.job(tenant, &job).await.expect("reads").iter().count(), count);
        assert_eq!(store.latest_job(tenant, &scene).await.expect("reads").iter().count(), count);
        assert_eq!(store.stages(tenant, &job).await.expect("reads").len(), count);
        assert_eq!(store.events(tenant, &job, 0, 1).await.expect("reads").len(), count);
        assert_eq!(store.artifacts(tenant, &scene).await.expect("reads").len(), count);
        let artifact = store.artifact(tenant, &scene, "alpha/note.txt").await.expect("reads");
        assert_eq!(artifact.iter().count(), count);
        assert_eq!(store.archive(tenant, &scene, "urdf").await.expect("reads").iter().count(), count);
        assert_eq!(store.archive(tenant, &scene, "mjcf").await.expect("reads"), None);
        assert_eq!(store.calls(tenant, &scene).await.expect("reads").len(), count);
        let spending = Spending { budget: 1_000 * count as i64, spent: 0, reserved: 400 * count as i64 };
        assert_eq!(store.spending(tenant, &scene).await.expect("reads"), spending);
    }
    assert_eq!(store.cancel(&other, &job).await.expect("answers"), CancelOutcome::NotFound);
    assert_eq!(store.retry(&other, &job, None).await.expect("answers"), RetryOutcome::NotFound);
    assert_eq!(store.delete_scene(&other, &scene).await.expect("answers"), DeleteOutcome::NotFound);
}
