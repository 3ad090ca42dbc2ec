//! Batches: every item gets one scene, however many processes feed; at most a window of them is in the queue.

use std::collections::BTreeSet;

use ::batches::{BatchState, OutputError, RequestCounts, RequestState};

use super::*;
use crate::artifacts::{ArchiveRow, BuiltScene};
use crate::batches::{
    BatchCancelOutcome, BatchFilter, BatchRetryOutcome, FeedRules, ItemContent, NewBatch, NewItem,
    OutputKind, PublishOutcome, RecipeRest, RestCounts,
};
use crate::calls::{CallEnd, Reservation};
use crate::deletion::DeleteOutcome;
use crate::jobs::{JobFilter, RetryOutcome};
use crate::lifecycle::{Failure, FailureClass};
use crate::queue::AttemptOutcome;
use crate::scenes::SceneFilter;
use scene::{BatchId, MicroUsd};

pub(super) fn rules(window: i64) -> FeedRules {
    FeedRules { queue: test_settings::section("queue"), window, counts_money: true }
}

pub(super) fn new_batch() -> NewBatch {
    NewBatch {
        tenant_id: DEFAULT_TENANT.clone(),
        name: "kitchens".into(),
        budget: None,
        idempotency_key: None,
        body_digest: Digest::of(b"body"),
    }
}

/// An item that may spend 100 millionths.
pub(super) fn item(place: u64) -> NewItem {
    let content = ItemContent::Request {
        request: json!({ "seed": place }),
        labels: BTreeMap::from([("set".to_owned(), "a".to_owned())]),
        budget: MicroUsd(100),
    };
    NewItem { place, custom_id: Some(format!("item_{place}")), content }
}

async fn published(store: &Store, new: NewBatch, items: Vec<NewItem>) -> BatchId {
    let id = store.begin_batch(new).await.expect("begins");
    store.append_items(&id, items).await.expect("stores");
    assert_eq!(store.publish_batch(&id).await.expect("publishes"), PublishOutcome::Published);
    id
}

pub(super) async fn batch_of(store: &Store, count: u64) -> BatchId {
    published(store, new_batch(), (1..=count).map(item).collect()).await
}

async fn state(store: &Store, id: &BatchId) -> BatchState {
    store.batch(&DEFAULT_TENANT, id).await.expect("reads").expect("there is a batch").state
}

async fn counts(store: &Store, id: &BatchId) -> RequestCounts {
    store.batch_counts(id).await.expect("counts")
}

/// Feeds until nothing more can be done at once.
pub(super) async fn feed(store: &Store, id: &BatchId, window: i64) {
    while store.feed_batch(id, rules(window)).await.expect("feeds").has_more {}
}

pub(super) fn built(passed: bool) -> AttemptOutcome {
    AttemptOutcome::Built(Box::new(BuiltScene {
        files: Vec::new(),
        archive: ArchiveRow { digest: Digest::of(b"zip"), size: 3 },
        passed,
        reasons: if passed { vec![] } else { vec!["mug_1 floats".into()] },
        summary: json!({}),
        metrics: json!({}),
    }))
}

pub(super) fn failed() -> AttemptOutcome {
    let failure =
        Failure { class: FailureClass::Permanent, code: "no_room".into(), message: "too full".into() };
    AttemptOutcome::Failed(failure)
}

/// Claims the next job and ends it.
async fn work(store: &Store, outcome: AttemptOutcome) -> JobId {
    let claim = claimed(store, "worker").await;
    store.finish(&claim.lease, outcome).await.expect("finishes");
    claim.lease.job_id
}

async fn results(store: &Store, id: &BatchId, kind: OutputKind) -> Vec<(u64, RequestState, String)> {
    let rows = store.batch_output(id, kind, 0, 100).await.expect("reads");
    let code = |error: Option<OutputError>| error.map(|error| error.code).unwrap_or_default();
    rows.into_iter().map(|row| (row.place, row.line.state, code(row.line.error))).collect()
}

pub(super) async fn feeders_at_once_give_every_item_one_scene(place: Place) {
    const ITEMS: usize = 24;
    let store = place.store();
    let id = batch_of(store, ITEMS as u64).await;
    let mut built_jobs = BTreeSet::new();
    while state(store, &id).await == BatchState::Running {
        let feeders: Vec<_> = (0..6)
            .map(|index| {
                let (store, id) = (place.handle(index), id.clone());
                tokio::spawn(async move { store.feed_batch(&id, rules(5)).await })
            })
            .collect();
        for feeder in feeders {
            feeder.await.expect("runs").expect("feeds");
        }
        let counts = counts(store, &id).await;
        assert!(counts.total == ITEMS as u64, "{counts:?}");
        let jobs = store.job_counts().await.expect("counts");
        let waiting: i64 = jobs.iter().filter(|(state, _)| !state.is_final()).map(|(_, count)| count).sum();
        assert!(waiting <= 5, "at most a window is in the queue: {waiting}");
        for _ in 0..waiting {
            assert!(built_jobs.insert(work(store, built(true)).await), "a job is built once");
        }
    }
    assert_eq!(state(store, &id).await, BatchState::Finished);
    let expected = RequestCounts { total: 24, succeeded: 24, ..RequestCounts::default() };
    assert_eq!(counts(store, &id).await, expected);
    let all = SceneFilter { limit: 100, ..SceneFilter::default() };
    let scenes = store.scenes(&DEFAULT_TENANT, all).await.expect("reads");
    let seeds: BTreeSet<i64> =
        scenes.iter().map(|(scene, _)| scene.request["seed"].as_i64().expect("a seed")).collect();
    assert_eq!((scenes.len(), seeds.len(), built_jobs.len()), (ITEMS, ITEMS, ITEMS));
    let (scene, _) = scenes.first().expect("a scene");
    assert_eq!(scene.labels.get("batch").map(String::as_str), Some(id.as_str()));
    assert_eq!((scene.labels["set"].as_str(), scene.labels["custom_id"].starts_with("item_")), ("a", true));
    // The jobs are found by their batch, and not by another one.
    let of_batch = |batch| JobFilter { batch: Some(batch), limit: 100, ..JobFilter::default() };
    assert_eq!(store.jobs(&DEFAULT_TENANT, of_batch(id)).await.expect("reads").len(), ITEMS);
    let other: BatchId = "other".parse().expect("an id");
    assert_eq!(store.jobs(&DEFAULT_TENANT, of_batch(other)).await.expect("reads"), []);
}

pub(super) async fn items_settle_as_their_scenes_end(place: Place) {
    let store = place.store();
    let mut items: Vec<NewItem> = (1..=4).map(item).collect();
    let wrong = OutputError::new("malformed_json", "no JSON").on_line(517);
    items.push(NewItem { place: 517, custom_id: None, content: ItemContent::Invalid(wrong.clone()) });
    let again = OutputError::new("duplicate_request", "the same").on_line(518);
    let duplicate = ItemContent::Duplicate { of: "item_1".into(), error: again };
    items.push(NewItem { place: 518, custom_id: Some("again".into()), content: duplicate });
    let id = published(store, new_batch(), items).await;
    assert_eq!((counts(store, &id).await.pending, counts(store, &id).await.invalid), (4, 1));
    feed(store, &id, 10).await;
    work(store, built(true)).await;
    work(store, built(false)).await;
    let failing = work(store, failed()).await;
    let running = claimed(store, "worker").await;
    feed(store, &id, 10).await;
    let expected = RequestCounts {
        total: 6,
        running: 1,
        succeeded: 1,
        quarantined: 1,
        failed: 1,
        duplicate: 1,
        invalid: 1,
        ..RequestCounts::default()
    };
    assert_eq!((state(store, &id).await, counts(store, &id).await), (BatchState::Running, expected));
    use RequestState as S;
    let output = [
        (1, S::Succeeded, String::new()),
        (2, S::Quarantined, "quarantined".to_owned()),
        (518, S::Duplicate, "duplicate_request".to_owned()),
    ];
    assert_eq!(results(store, &id, OutputKind::Output).await, output);
    let errors = [(3, S::Failed, "no_room".to_owned()), (517, S::Invalid, "malformed_json".to_owned())];
    assert_eq!(results(store, &id, OutputKind::Errors).await, errors);
    let rows = store.batch_output(&id, OutputKind::Errors, 3, 100).await.expect("reads");
    assert_eq!(rows.len(), 1, "pages continue after a place");
    assert_eq!(rows[0].line.error, Some(wrong));
    // A scene that is deleted while it is made has no result, and a job that is retried on its own counts again.
    let scene =
        store.job(&DEFAULT_TENANT, &running.lease.job_id).await.expect("reads").expect("a job").scene_id;
    let deleted = store.delete_scene(&DEFAULT_TENANT, &scene.expect("a scene")).await.expect("deletes");
    assert_eq!(deleted, DeleteOutcome::Done);
    feed(store, &id, 10).await;
    assert_eq!((state(store, &id).await, counts(store, &id).await.cancelled), (BatchState::Finished, 1));
    let retried = store.retry(&DEFAULT_TENANT, &failing, None).await.expect("retries");
    assert!(matches!(retried, RetryOutcome::Created { .. }), "{retried:?}");
    assert_eq!((state(store, &id).await, counts(store, &id).await.pending), (BatchState::Running, 1));
}

pub(super) async fn a_cancelled_batch_stops_and_a_retry_makes_the_rest(place: Place) {
    let store = place.store();
    let id = batch_of(store, 5).await;
    feed(store, &id, 2).await;
    work(store, built(true)).await;
    let running = claimed(store, "worker").await;
    let cancelled = store.cancel_batch(&DEFAULT_TENANT, &id).await.expect("cancels");
    assert_eq!(cancelled, BatchCancelOutcome::Accepted);
    feed(store, &id, 2).await;
    assert_eq!(state(store, &id).await, BatchState::Cancelling);
    let early = store.retry_batch(&DEFAULT_TENANT, &id, None).await.expect("answers");
    assert_eq!(early, BatchRetryOutcome::StillCancelling);
    assert_eq!(
        store.cancel_batch(&DEFAULT_TENANT, &id).await.expect("answers"),
        BatchCancelOutcome::Accepted
    );
    store.finish(&running.lease, AttemptOutcome::Stopped).await.expect("stops");
    feed(store, &id, 2).await;
    let expected = RequestCounts { total: 5, succeeded: 1, cancelled: 4, ..RequestCounts::default() };
    assert_eq!((state(store, &id).await, counts(store, &id).await), (BatchState::Cancelled, expected));
    let late = store.cancel_batch(&DEFAULT_TENANT, &id).await.expect("answers");
    assert_eq!(late, BatchCancelOutcome::TooLate(BatchState::Cancelled));

    // The one that had begun keeps its scene; the others get one now.
    let retried = store.retry_batch(&DEFAULT_TENANT, &id, None).await.expect("retries");
    assert_eq!(retried, BatchRetryOutcome::Accepted(4));
    for _ in 0..4 {
        feed(store, &id, 2).await;
        work(store, built(true)).await;
    }
    feed(store, &id, 2).await;
    let expected = RequestCounts { total: 5, succeeded: 5, ..RequestCounts::default() };
    assert_eq!((state(store, &id).await, counts(store, &id).await), (BatchState::Finished, expected));
    let all = SceneFilter { limit: 100, ..SceneFilter::default() };
    assert_eq!(store.scenes(&DEFAULT_TENANT, all).await.expect("reads").len(), 5);
    let again = store.retry_batch(&DEFAULT_TENANT, &id, None).await.expect("answers");
    assert_eq!(again, BatchRetryOutcome::NothingToRetry);

    let account = store
        .batch_accounts(&[store.batch(&DEFAULT_TENANT, &id).await.expect("reads").expect("is there")])
        .await
        .expect("accounts");
    assert_eq!(account[0].pace.finished, 4, "of the present run: {account:?}");
}

pub(super) async fn items_together_stay_within_the_budget_of_their_batch(place: Place) {
    let store = place.store();
    let new = NewBatch { budget: Some(MicroUsd(250)), ..new_batch() };
    let id = published(store, new, (1..=5).map(item).collect()).await;
    let spend = async |amount: i64| {
        let claim = claimed(store, "worker").await;
        let reserved = store.reserve_call(&claim.lease, call(amount)).await.expect("answers");
        let Reservation::Granted(row) = reserved else { panic!("{reserved:?}") };
        let end = CallEnd {
            settled_micro_usd: Some(amount),
            outcome: "answered".into(),
            received_bytes: 1,
            input_tokens: None,
            output_tokens: None,
            task: None,
            answer: None,
        };
        store.settle_call(&claim.lease, row, end).await.expect("settles");
        claim
    };
    feed(store, &id, 10).await;
    assert_eq!(store.job_counts().await.expect("counts")[0].1, 2, "two shares of 100 are free of 250");
    let claim = spend(100).await;
    store.finish(&claim.lease, built(true)).await.expect("finishes");
    feed(store, &id, 10).await;
    let claim = spend(100).await;
    store.finish(&claim.lease, built(true)).await.expect("finishes");
    feed(store, &id, 10).await;
    // The last share is what is left: a call of more is refused.
    let claim = claimed(store, "worker").await;
    let refused = store.reserve_call(&claim.lease, call(51)).await.expect("answers");
    assert!(matches!(refused, Reservation::OverBudget { budget: 50, .. }), "{refused:?}");
    let granted = store.reserve_call(&claim.lease, call(50)).await.expect("answers");
    assert!(matches!(granted, Reservation::Granted(_)), "{granted:?}");
    // Its worker stops without an answer, so the reserved amount counts.
    store.finish(&claim.lease, failed()).await.expect("finishes");
    feed(store, &id, 10).await;
    let expected = RequestCounts { total: 5, succeeded: 2, failed: 3, ..RequestCounts::default() };
    assert_eq!((state(store, &id).await, counts(store, &id).await), (BatchState::Finished, expected));
    let batch = store.batch(&DEFAULT_TENANT, &id).await.expect("reads").expect("is there");
    assert_eq!(batch.settled, MicroUsd(250));
    let codes: Vec<String> =
        results(store, &id, OutputKind::Errors).await.into_iter().map(|(_, _, code)| code).collect();
    assert_eq!(codes, ["no_room", "batch_budget_spent", "batch_budget_spent"]);
    // More money makes the rest.
    let retried = store.retry_batch(&DEFAULT_TENANT, &id, Some(MicroUsd(500))).await.expect("retries");
    assert_eq!(retried, BatchRetryOutcome::Accepted(3));
    feed(store, &id, 10).await;
    assert_eq!(counts(store, &id).await.pending, 3);
    let waiting = store.job_counts().await.expect("counts")[0].1;
    assert_eq!(waiting, 3, "250 are free, and 50, 100 and 100 are asked for");
}

pub(super) async fn a_key_makes_one_batch_which_appears_whole(place: Place) {
    let store = place.store();
    let keyed = |body: &[u8]| NewBatch {
        idempotency_key: Some("key".into()),
        body_digest: Digest::of(body),
        ..new_batch()
    };
    // One process dies while it receives; two others receive the same batch at once.
    let broken = store.begin_batch(keyed(b"body")).await.expect("begins");
    store.append_items(&broken, vec![item(1)]).await.expect("stores");
    assert_eq!(store.batch(&DEFAULT_TENANT, &broken).await.expect("reads"), None);
    assert_eq!(
        store
            .batches(&DEFAULT_TENANT, BatchFilter { limit: 10, ..BatchFilter::default() })
            .await
            .expect("reads"),
        []
    );
    let mut outcomes = Vec::new();
    for index in 0..2 {
        let store = place.handle(index);
        let id = store.begin_batch(keyed(b"body")).await.expect("begins");
        store.append_items(&id, vec![item(1), item(2)]).await.expect("stores");
        outcomes.push(tokio::spawn(async move { (id.clone(), store.publish_batch(&id).await) }));
    }
    let mut ids = Vec::new();
    let mut replayed = Vec::new();
    for outcome in outcomes {
        match outcome.await.expect("runs") {
            (id, Ok(PublishOutcome::Published)) => ids.push(id),
            (_, Ok(PublishOutcome::Replayed(id))) => replayed.push(id),
            other => panic!("{other:?}"),
        }
    }
    assert_eq!((ids.len(), &ids), (1, &replayed));
    let other = store.begin_batch(keyed(b"another")).await.expect("begins");
    assert_eq!(store.publish_batch(&other).await.expect("answers"), PublishOutcome::KeyReused);
    let known = store.batch_by_key(&DEFAULT_TENANT, "key").await.expect("reads");
    assert_eq!(known, Some((ids[0].clone(), Digest::of(b"body").to_string())));
    let list = store
        .batches(&DEFAULT_TENANT, BatchFilter { limit: 10, ..BatchFilter::default() })
        .await
        .expect("reads");
    assert_eq!(list.iter().map(|batch| &batch.id).collect::<Vec<_>>(), [&ids[0]]);
    assert_eq!(counts(store, &ids[0]).await.total, 2);
    assert_eq!(store.active_batches().await.expect("reads"), ids);
}

pub(super) async fn a_batch_leaves_half_of_the_queue_to_others(place: Place) {
    let store = place.store();
    let id = batch_of(store, 20).await;
    let mut narrow = rules(100);
    narrow.queue.max_jobs = 10;
    store.feed_batch(&id, narrow.clone()).await.expect("feeds");
    assert_eq!(store.job_counts().await.expect("counts")[0].1, 5);
    work(store, built(true)).await;
    store.feed_batch(&id, narrow).await.expect("feeds");
    assert_eq!(store.job_counts().await.expect("counts")[0].1, 5, "one more for the one that ended");
}

pub(super) async fn requests_of_a_recipe_get_their_items_once_and_stop_with_their_batch(place: Place) {
    let store = place.store();
    let id = store.begin_batch(new_batch()).await.expect("begins");
    store.append_items(&id, (1..=4).map(item).collect()).await.expect("stores");
    let rest_counts = RestCounts { pending: 5, duplicate: 1, invalid: 0 };
    let rest = RecipeRest { recipe: "{}".into(), first_place: 5, counts: rest_counts };
    store.keep_recipe(&id, rest.clone()).await.expect("stores");
    assert_eq!(store.recipe_to_expand(&id, 9).await.expect("reads"), None, "it is being received");
    assert_eq!(store.publish_batch(&id).await.expect("publishes"), PublishOutcome::Published);
    let expected = RequestCounts { total: 10, pending: 9, duplicate: 1, ..RequestCounts::default() };
    assert_eq!(counts(store, &id).await, expected, "requests without rows count as well");

    assert_eq!(store.recipe_to_expand(&id, 4).await.expect("reads"), None, "enough items wait");
    assert_eq!(store.recipe_to_expand(&id, 5).await.expect("reads"), Some(rest.clone()));
    let again = OutputError::new("duplicate_request", "the same").on_line(6);
    let duplicate = ItemContent::Duplicate { of: "item_1".into(), error: again };
    let group =
        vec![item(5), NewItem { place: 6, custom_id: Some("again".into()), content: duplicate }, item(7)];
    // Processes expand the same recipe at once: one of them gives the rows.
    let expansions: Vec<_> = (0..6)
        .map(|index| {
            let (store, id, rest, group) = (place.handle(index), id.clone(), rest.clone(), group.clone());
            tokio::spawn(async move { store.expand_recipe(&id, rest, group, false).await })
        })
        .collect();
    let mut won = 0;
    for expansion in expansions {
        won += u32::from(expansion.await.expect("runs").expect("expands"));
    }
    assert_eq!((won, counts(store, &id).await), (1, expected));
    let rest = store.recipe_to_expand(&id, 9).await.expect("reads").expect("three are left");
    assert_eq!(rest.first_place, 8);
    assert_eq!(rest.counts, RestCounts { pending: 3, duplicate: 0, invalid: 0 });

    // The items have ended, and requests without rows keep the batch running.
    feed(store, &id, 9).await;
    for _ in 0..6 {
        work(store, built(true)).await;
    }
    feed(store, &id, 9).await;
    assert_eq!(state(store, &id).await, BatchState::Running);
    store.cancel_batch(&DEFAULT_TENANT, &id).await.expect("cancels");
    feed(store, &id, 9).await;
    assert_eq!(state(store, &id).await, BatchState::Cancelled);
    let stopped =
        RequestCounts { total: 10, succeeded: 6, duplicate: 1, cancelled: 3, ..RequestCounts::default() };
    assert_eq!(counts(store, &id).await, stopped);
    assert_eq!(store.recipe_to_expand(&id, 9).await.expect("reads"), None);
    assert!(!store.expand_recipe(&id, rest.clone(), vec![item(8)], false).await.expect("answers"));

    let retried = store.retry_batch(&DEFAULT_TENANT, &id, None).await.expect("retries");
    assert_eq!(retried, BatchRetryOutcome::Accepted(3));
    assert!(store.expand_recipe(&id, rest, (8..=10).map(item).collect(), true).await.expect("expands"));
    assert_eq!(store.recipe_to_expand(&id, 9).await.expect("reads"), None, "nothing is left");
    feed(store, &id, 9).await;
    for _ in 0..3 {
        work(store, built(true)).await;
    }
    feed(store, &id, 9).await;
    assert_eq!(state(store, &id).await, BatchState::Finished);
    let done = RequestCounts { total: 10, succeeded: 9, duplicate: 1, ..RequestCounts::default() };
    assert_eq!(counts(store, &id).await, done);
}
