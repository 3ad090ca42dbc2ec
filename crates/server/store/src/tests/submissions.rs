//! Submissions and lists of scenes.

use super::*;
use crate::executions::{NewExecution, SubmitExecutionOutcome};
use crate::lifecycle::SceneState;
use crate::scenes::SceneFilter;

fn with_key(key: &str, body: &str) -> NewScene {
    NewScene { idempotency: Some((key.to_owned(), body.to_owned())), ..new_scene() }
}

pub(super) async fn one_key_at_once_makes_one_scene(place: Place) {
    let submissions: Vec<_> = (0..40)
        .map(|index| {
            let store = place.handle(index);
            tokio::spawn(async move { store.submit(with_key("key", "body")).await })
        })
        .collect();
    let mut created = Vec::new();
    let mut replayed = Vec::new();
    for submission in submissions {
        match submission.await.expect("runs").expect("submits") {
            SubmitOutcome::Created { scene_id, job_id, .. } => created.push((scene_id, job_id)),
            SubmitOutcome::Replayed { scene_id, job_id } => replayed.push((scene_id, job_id)),
            other => panic!("the body is the same: {other:?}"),
        }
    }
    assert_eq!((created.len(), replayed.len()), (1, 39));
    assert!(replayed.iter().all(|ids| *ids == created[0]));
    let all = SceneFilter { limit: 10, ..SceneFilter::default() };
    assert_eq!(place.store().scenes(&DEFAULT_TENANT, all).await.expect("reads").len(), 1);
}

pub(super) async fn another_body_under_a_key_is_refused(place: Place) {
    let store = place.store();
    store.submit(with_key("key", "one body")).await.expect("submits");
    assert_eq!(store.submit(with_key("key", "another")).await.expect("answers"), SubmitOutcome::KeyReused);
    let other_key = store.submit(with_key("other", "another")).await.expect("submits");
    assert!(matches!(other_key, SubmitOutcome::Created { .. }));
}

pub(super) async fn one_key_at_once_makes_one_execution_of_each_tenant(place: Place) {
    let new = |tenant: &str, body: &[u8]| NewExecution {
        tenant_id: tenant.parse().expect("an id"),
        scene_id: "scene".parse().expect("an id"),
        request: json!({ "version": 1 }),
        bundle: Digest::of(b"bundle"),
        idempotency: Some(("key".to_owned(), Digest::of(body))),
    };
    let submissions: Vec<_> = (0..20)
        .map(|index| {
            let (store, new) = (place.handle(index), new(["a", "b"][index / 10], b"body"));
            tokio::spawn(async move { store.submit_execution(new).await })
        })
        .collect();
    let (mut created, mut replayed) = (Vec::new(), Vec::new());
    for submission in submissions {
        match submission.await.expect("runs").expect("submits") {
            SubmitExecutionOutcome::Created(job_id) => created.push(job_id),
            SubmitExecutionOutcome::Replayed(job_id) => replayed.push(job_id),
            other => panic!("the body is the same: {other:?}"),
        }
    }
    assert_eq!((created.len(), replayed.len()), (2, 18));
    assert!(replayed.iter().all(|job_id| created.contains(job_id)));
    let other = place.store().submit_execution(new("a", b"another")).await.expect("answers");
    assert_eq!(other, SubmitExecutionOutcome::KeyReused);
}

pub(super) async fn lists_filter_by_state_label_and_age_newest_first(place: Place) {
    let store = place.store();
    let mut ids = Vec::new();
    for value in ["a", "b", "a"] {
        let labels = BTreeMap::from([("set \"x\".y".to_owned(), value.to_owned())]);
        match store.submit(NewScene { labels, ..new_scene() }).await.expect("submits") {
            SubmitOutcome::Created { scene_id, .. } => ids.push(scene_id),
            other => panic!("{other:?}"),
        }
    }
    store.delete_scene(&DEFAULT_TENANT, &ids[1]).await.expect("deletes");
    let any = || SceneFilter { limit: 10, ..SceneFilter::default() };
    let label = |value: &str| Some(("set \"x\".y".to_owned(), value.to_owned()));
    let before = || Some(ids[2].clone());
    let cases = [
        (any(), vec![2, 0]),
        (SceneFilter { state: Some(SceneState::Deleted), ..any() }, vec![1]),
        (SceneFilter { label: label("a"), ..any() }, vec![2, 0]),
        (SceneFilter { label: label("b"), ..any() }, vec![]),
        (SceneFilter { before_id: before(), ..any() }, vec![0]),
        (SceneFilter { limit: 1, ..any() }, vec![2]),
        (SceneFilter { created_after_ms: Some(0), ..any() }, vec![2, 0]),
        (SceneFilter { created_after_ms: Some(i64::MAX), ..any() }, vec![]),
        (SceneFilter { parent: Some(ids[0].clone()), ..any() }, vec![]),
    ];
    for (filter, expected) in cases {
        let description = format!("{filter:?}");
        let found = store.scenes(&DEFAULT_TENANT, filter).await.expect("reads");
        let found: Vec<_> = found.into_iter().map(|(scene, _)| scene.id).collect();
        let expected: Vec<_> = expected.into_iter().map(|index: usize| ids[index].clone()).collect();
        assert_eq!(found, expected, "{description}");
    }
}

pub(super) async fn a_dropped_caller_leaves_a_whole_submission(place: Place) {
    let store = place.store();
    for _ in 0..20 {
        let mut submission = Box::pin(store.submit(new_scene()));
        // Polled once, so that it has begun, and dropped; mostly before it has ended.
        let _ = futures::poll!(&mut submission);
    }
    let all = || SceneFilter { limit: 100, ..SceneFilter::default() };
    let mut scenes = 0;
    for _ in 0..200 {
        scenes = store.scenes(&DEFAULT_TENANT, all()).await.expect("reads").len();
        if scenes == 20 {
            break;
        }
        tokio::time::sleep(Duration::from_millis(10)).await;
    }
    let queued: i64 = store.job_counts().await.expect("counts").iter().map(|(_, count)| count).sum();
    assert_eq!((scenes, queued), (20, 20));
}
