//! Isolation of tenants.

use super::*;
use crate::artifacts::{self, ArchiveRow};
use crate::batches::{BatchCancelOutcome, BatchFilter, BatchRetryOutcome, NewBatch};
use crate::calls::{Reservation, Spending};
use crate::deletion::DeleteOutcome;
use crate::jobs::RetryOutcome;
use crate::queue::CancelOutcome;
use crate::scenes::SceneFilter;

pub(super) async fn queries_of_another_tenant_find_and_change_nothing(place: Place) {
    let store = place.store();
    let owner: &TenantId = &DEFAULT_TENANT;
    let other: TenantId = "other".parse().expect("an id");
    let (scene, job) = submitted(store).await;
    let claim = claimed(store, "worker").await;
    let file = artifacts::FileRow {
        name: "alpha/note.txt".into(),
        digest: Digest::of(b"note"),
        media_type: "text/plain".into(),
        size: 4,
    };
    let key = stage("alpha");
    let checkpoint = Checkpoint { output: Digest::of(b"output"), artifacts: vec![file], elapsed_ms: 1 };
    store.stage_finished(&claim.lease, &key, &checkpoint, false).await.expect("commits");
    assert!(matches!(store.reserve_call(&claim.lease, call(400)).await, Ok(Reservation::Granted(_))));
    let archive = ArchiveRow { digest: Digest::of(b"zip"), size: 3 };
    store.record_archive(&other, &scene, "mjcf", archive.clone()).await.expect("answers");
    store.record_archive(owner, &scene, "urdf", archive.clone()).await.expect("records");
    let batch = NewBatch {
        tenant_id: owner.clone(),
        name: String::new(),
        budget: None,
        idempotency_key: Some("key".into()),
        body_digest: Digest::of(b"body"),
    };
    let batch = store.begin_batch(batch).await.expect("begins");
    store.publish_batch(&batch).await.expect("publishes");

    for (tenant, count) in [(owner, 1), (&other, 0)] {
        let all = SceneFilter { limit: 10, ..SceneFilter::default() };
        assert_eq!(store.scenes(tenant, all).await.expect("reads").len(), count);
        assert_eq!(store.scene(tenant, &scene).await.expect("reads").iter().count(), count);
        assert_eq!(store.job(tenant, &job).await.expect("reads").iter().count(), count);
        assert_eq!(store.batch(tenant, &batch).await.expect("reads").iter().count(), count);
        let all = BatchFilter { limit: 10, ..BatchFilter::default() };
        assert_eq!(store.batches(tenant, all).await.expect("reads").len(), count);
        assert_eq!(store.batch_by_key(tenant, "key").await.expect("reads").iter().count(), count);
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
    assert_eq!(store.cancel_batch(&other, &batch).await.expect("answers"), BatchCancelOutcome::NotFound);
    assert_eq!(store.retry_batch(&other, &batch, None).await.expect("answers"), BatchRetryOutcome::NotFound);
    assert_eq!(store.cancel(&other, &job).await.expect("answers"), CancelOutcome::NotFound);
    assert_eq!(store.retry(&other, &job, None).await.expect("answers"), RetryOutcome::NotFound);
    assert_eq!(store.delete_scene(&other, &scene).await.expect("answers"), DeleteOutcome::NotFound);
}
