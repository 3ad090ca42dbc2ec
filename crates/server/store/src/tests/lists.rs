//! Lists of jobs, and the outlook of jobs that have not ended.

use super::*;
use crate::artifacts::{ArchiveRow, BuiltScene};
use crate::jobs::{JobFilter, JobRow};
use crate::lifecycle::{JobKind, JobState};
use crate::outlook::Outlook;
use crate::queue::AttemptOutcome;
use crate::scenes::SceneFilter;

fn all_jobs() -> JobFilter {
    JobFilter { limit: 10, ..JobFilter::default() }
}

async fn listed(store: &Store, filter: JobFilter) -> Vec<JobId> {
    let jobs = store.jobs(&DEFAULT_TENANT, filter).await.expect("reads");
    jobs.into_iter().map(|job| job.id).collect()
}

pub(super) async fn jobs_are_listed_by_state_kind_scene_and_age_newest_first(place: Place) {
    let store = place.store();
    let (scene, first) = submitted(store).await;
    let (_, second) = submitted(store).await;
    store.cancel(&DEFAULT_TENANT, &first).await.expect("cancels");
    store.retry(&DEFAULT_TENANT, &first, None).await.expect("retries");
    let everything = listed(store, all_jobs()).await;
    let third = everything[0].clone();
    let cases = [
        (all_jobs(), vec![&third, &second, &first]),
        (JobFilter { state: Some(JobState::Queued), ..all_jobs() }, vec![&third, &second]),
        (JobFilter { state: Some(JobState::Cancelled), ..all_jobs() }, vec![&first]),
        (JobFilter { state: Some(JobState::Running), ..all_jobs() }, vec![]),
        (JobFilter { kind: Some(JobKind::Retry), ..all_jobs() }, vec![&third]),
        (JobFilter { scene: Some(scene.clone()), ..all_jobs() }, vec![&third, &first]),
        (
            JobFilter { scene: Some(scene.clone()), before_id: Some(third.clone()), ..all_jobs() },
            vec![&first],
        ),
        (
            JobFilter { created_after_ms: Some(0), before_id: Some(second.clone()), ..all_jobs() },
            vec![&first],
        ),
        (JobFilter { created_after_ms: Some(i64::MAX), ..all_jobs() }, vec![]),
        (JobFilter { limit: 1, ..all_jobs() }, vec![&third]),
    ];
    for (filter, expected) in cases {
        let description = format!("{filter:?}");
        assert_eq!(listed(store, filter).await.iter().collect::<Vec<_>>(), expected, "{description}");
    }
    let other: TenantId = "other".parse().expect("an id");
    assert_eq!(store.jobs(&other, all_jobs()).await.expect("reads"), []);

    // Each scene of a list has its newest job.
    let scenes = store.scenes(&DEFAULT_TENANT, SceneFilter { limit: 10, ..SceneFilter::default() }).await;
    let jobs: Vec<_> = scenes.expect("reads").into_iter().map(|(_, job)| job.map(|job| job.id)).collect();
    assert_eq!(jobs, [Some(second), Some(third)]);
}

pub(super) async fn places_follow_rank_and_age_and_ends_the_durations_so_far(place: Place) {
    let store = place.store();
    let mut ids = Vec::new();
    for _ in 0..5 {
        ids.push(submitted(store).await.1);
    }
    move_to_the_front(store, &ids[3]).await;
    assert_eq!(places(store, &ids).await, [Some(2), Some(3), Some(4), Some(1), Some(5)]);
    // Nothing has ended, so nothing is known.
    assert!(outlooks(store, &ids).await.iter().all(|outlook| outlook.finish_at_ms.is_none()));

    let claim = claimed(store, "worker").await;
    assert_eq!(claim.lease.job_id, ids[3]);
    assert_eq!(places(store, &ids).await, [Some(1), Some(2), Some(3), None, Some(4)]);
    tokio::time::sleep(Duration::from_millis(20)).await;
    let built = BuiltScene {
        files: Vec::new(),
        archive: ArchiveRow { digest: Digest::of(b"zip"), size: 3 },
        passed: true,
        reasons: Vec::new(),
        summary: json!({}),
        metrics: json!({}),
    };
    store.finish(&claim.lease, AttemptOutcome::Built(Box::new(built))).await.expect("finishes");
    // A duration is known, but no job runs that could end.
    assert!(outlooks(store, &ids).await.iter().all(|outlook| outlook.finish_at_ms.is_none()));

    let claim = claimed(store, "worker").await;
    assert_eq!(claim.lease.job_id, ids[0]);
    let ends: Vec<_> = outlooks(store, &ids).await.iter().map(|outlook| outlook.finish_at_ms).collect();
    assert!(ends[0].is_some() && ends[0] < ends[1] && ends[1] < ends[2] && ends[2] < ends[4], "{ends:?}");
    assert_eq!(ends[3], None);
    // The order of the question is that of the answer, and a part of the queue has the same places.
    let some = [ids[4].clone(), ids[3].clone(), ids[1].clone()];
    assert_eq!(places(store, &some).await, [Some(3), None, Some(1)]);
}

async fn outlooks(store: &Store, ids: &[JobId]) -> Vec<Outlook> {
    let mut jobs: Vec<JobRow> = Vec::new();
    for id in ids {
        jobs.push(store.job(&DEFAULT_TENANT, id).await.expect("reads").expect("a job"));
    }
    let jobs: Vec<&JobRow> = jobs.iter().collect();
    store.outlooks(&DEFAULT_TENANT, &jobs).await.expect("reads")
}

async fn places(store: &Store, ids: &[JobId]) -> Vec<Option<i64>> {
    outlooks(store, ids).await.iter().map(|outlook| outlook.queue_position).collect()
}

async fn move_to_the_front(store: &Store, id: &JobId) {
    let id = id.clone();
    let raised = store.writer.write("move a job to the front", move |connection| {
        Box::pin(async move {
            sqlx::query("UPDATE jobs SET priority = 1, rank_at = created_at - 600000 WHERE id = $1")
                .bind(id.as_str())
                .execute(connection)
                .await?;
            Ok(())
        })
    });
    raised.await.expect("raises");
}
