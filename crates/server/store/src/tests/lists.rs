//! Lists of jobs, and the outlook of jobs that have not ended.

use super::*;
use crate::artifacts::{ArchiveRow, BuiltScene};
use crate::jobs::{JobFilter, JobRow};
use crate::lifecycle::{JobKind, JobState, SceneState};
use crate::outlook::Outlook;
use crate::queue::AttemptOutcome;
use crate::scenes::{SceneCounts, SceneFilter, SceneKind};

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

/// Ends the oldest job with a certified scene of these categories.
async fn build(store: &Store, passed: bool, categories: &[&str]) {
    let claim = claimed(store, "worker").await;
    let built = BuiltScene {
        files: Vec::new(),
        archive: ArchiveRow { digest: Digest::of(b"zip"), size: 3 },
        passed,
        reasons: Vec::new(),
        summary: json!({ "objects": categories.len(), "categories": categories }),
        metrics: json!({}),
    };
    store.finish(&claim.lease, AttemptOutcome::Built(Box::new(built))).await.expect("finishes");
}

pub(super) async fn scenes_are_filtered_and_counted_by_what_they_are(place: Place) {
    let store = place.store();
    let requests = [
        (json!({ "input": { "kind": "text", "text": "Two red MUGS, 100% wool_" } }), "a"),
        (json!({ "input": { "kind": "image", "sha256": "0" } }), "b"),
        (json!({ "input": { "kind": "text", "text": "A blue bowl beside two mugs" } }), "a"),
        (json!({ "input": { "kind": "edit", "text": "add a spoon" } }), "a"),
    ];
    let mut ids = Vec::new();
    for (request, value) in requests {
        let labels = BTreeMap::from([("set".to_owned(), value.to_owned())]);
        match store.submit(NewScene { request, labels, ..new_scene() }).await.expect("submits") {
            SubmitOutcome::Created { scene_id, .. } => ids.push(scene_id),
            other => panic!("{other:?}"),
        }
    }
    build(store, true, &["mug"]).await;
    build(store, false, &["bowl", "mug", "spoon"]).await;
    build(store, true, &["bowl", "mug"]).await;
    let any = || SceneFilter { limit: 10, ..SceneFilter::default() };
    let words = |words: &[&str]| words.iter().map(|word| (*word).to_owned()).collect();
    let category = |name: &str| Some(name.to_owned());
    let label = || Some(("set".to_owned(), "a".to_owned()));
    let cases = [
        (any(), vec![3, 2, 1, 0]),
        (SceneFilter { oldest_first: true, ..any() }, vec![0, 1, 2, 3]),
        (SceneFilter { oldest_first: true, before_id: Some(ids[1].clone()), ..any() }, vec![2, 3]),
        (SceneFilter { passed: Some(true), ..any() }, vec![2, 0]),
        (SceneFilter { passed: Some(false), ..any() }, vec![1]),
        (SceneFilter { state: Some(SceneState::Ready), kind: Some(SceneKind::Text), ..any() }, vec![2, 0]),
        (SceneFilter { kind: Some(SceneKind::Image), ..any() }, vec![1]),
        (SceneFilter { kind: Some(SceneKind::Variant), ..any() }, vec![]),
        (SceneFilter { words: words(&["mugs"]), ..any() }, vec![2, 0]),
        (SceneFilter { words: words(&["BLUE", "mugs"]), ..any() }, vec![2]),
        (SceneFilter { words: words(&["%", "wool_"]), ..any() }, vec![0]),
        (SceneFilter { words: words(&["red_"]), ..any() }, vec![]),
        (SceneFilter { min_objects: Some(2), ..any() }, vec![2, 1]),
        (SceneFilter { min_objects: Some(2), max_objects: Some(2), ..any() }, vec![2]),
        (SceneFilter { category: category("bowl"), ..any() }, vec![2, 1]),
        (SceneFilter { category: category("bowl"), before_id: Some(ids[2].clone()), ..any() }, vec![1]),
        (SceneFilter { category: category("mug"), label: label(), ..any() }, vec![2, 0]),
        (SceneFilter { category: category("cup"), ..any() }, vec![]),
    ];
    for (filter, expected) in cases {
        let description = format!("{filter:?}");
        let count = expected.len() as i64;
        let is_page = filter.before_id.is_some();
        let found = store.scenes(&DEFAULT_TENANT, filter.clone()).await.expect("reads");
        let found: Vec<_> = found.into_iter().map(|(scene, _)| scene.id).collect();
        let expected: Vec<_> = expected.into_iter().map(|index: usize| ids[index].clone()).collect();
        assert_eq!(found, expected, "{description}");
        if !is_page {
            let counts = store.scene_counts(&DEFAULT_TENANT, filter).await.expect("counts");
            assert_eq!(counts.total, count, "{description}");
        }
    }

    let counts = store.scene_counts(&DEFAULT_TENANT, any()).await.expect("counts");
    let count = |word: &str, scenes: i64| (word.to_owned(), scenes);
    assert_eq!(counts.states, [count("ready", 2), count("failed", 1), count("pending", 1)]);
    assert_eq!(counts.verdicts, [count("pass", 2), count("quarantine", 1)]);
    assert_eq!(counts.kinds, [count("text", 2), count("edit", 1), count("image", 1)]);
    assert_eq!(counts.categories, [count("mug", 3), count("bowl", 2), count("spoon", 1)]);
    let label = |value: &str, scenes: i64| (("set".to_owned(), value.to_owned()), scenes);
    assert_eq!(counts.labels, [label("a", 3), label("b", 1)]);
    let quarantined = SceneFilter { passed: Some(false), ..any() };
    let counts = store.scene_counts(&DEFAULT_TENANT, quarantined).await.expect("counts");
    assert_eq!((counts.total, counts.labels), (1, vec![label("b", 1)]));
    let other: TenantId = "other".parse().expect("an id");
    assert_eq!(store.scene_counts(&other, any()).await.expect("counts"), SceneCounts::default());
    // Deleted scenes are in no count.
    store.delete_scene(&DEFAULT_TENANT, &ids[1]).await.expect("deletes");
    assert_eq!(store.scene_counts(&DEFAULT_TENANT, any()).await.expect("counts").total, 3);
}
