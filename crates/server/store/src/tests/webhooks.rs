//! Webhooks: every end has its message, each is taken by one process at a time, and no tenant sees those of another.

use super::batches::{batch_of, built, failed, feed};
use super::datasets::{freezing, frozen, submitted_dataset};
use super::*;
use crate::deletion::DeleteOutcome;
use crate::executions::{ExecutionAnswer, NewExecution, SubmitExecutionOutcome};
use crate::queue::{AttemptOutcome, Schedule};
use crate::retention::RetentionSettings;
use crate::webhooks::{
    AttemptEnd, AttemptReport, ChangeOutcome, CreateOutcome, DeliveryFilter, DeliveryRow, DeliveryState,
    DueDelivery, EventType, MAX_WEBHOOKS, NewWebhook, OrderOutcome, WebhookRow,
};
use scene::{BatchId, WebhookId};

const LEASE: Duration = Duration::from_secs(60);

fn new_webhook(tenant_id: &TenantId, events: &[EventType]) -> NewWebhook {
    NewWebhook {
        tenant_id: tenant_id.clone(),
        url: "https://example.org/hook".into(),
        description: String::new(),
        events: events.into(),
    }
}

async fn webhook_of(store: &Store, tenant_id: &TenantId, events: &[EventType]) -> WebhookRow {
    match store.create_webhook(new_webhook(tenant_id, events)).await.expect("answers").0 {
        CreateOutcome::Created(row) => row,
        CreateOutcome::TooMany => panic!("there is room"),
    }
}

async fn webhook(store: &Store) -> WebhookId {
    webhook_of(store, &DEFAULT_TENANT, &[]).await.id
}

/// Deliveries of a webhook, oldest first.
async fn deliveries(store: &Store, id: &WebhookId) -> Vec<DeliveryRow> {
    let all = DeliveryFilter { limit: 200, ..DeliveryFilter::default() };
    let mut rows = store.deliveries(&DEFAULT_TENANT, id, all).await.expect("reads");
    rows.reverse();
    rows
}

/// Event, state and code of the failure of each message, oldest first.
async fn messages(store: &Store, id: &WebhookId) -> Vec<(EventType, String, Option<String>)> {
    let rows = deliveries(store, id).await.into_iter();
    rows.map(|row| (row.event, row.message.data.state, row.message.data.failure_code)).collect()
}

async fn due(store: &Store) -> Vec<DueDelivery> {
    store.claim_deliveries(LEASE, 9).await.expect("answers")
}

fn report(end: AttemptEnd) -> AttemptReport {
    let (status, error) = match end {
        AttemptEnd::Delivered => (Some(204), None),
        _ => (Some(500), Some("the address answered 500".to_owned())),
    };
    AttemptReport { status, error, duration: Duration::from_millis(7), end }
}

async fn end(store: &Store, due: &DueDelivery, end: AttemptEnd) -> bool {
    store.end_attempt(due, report(end)).await.expect("answers")
}

async fn statement(store: &Store, sql: &'static str) {
    let done = store.writer.write("change the database", move |connection| {
        Box::pin(async move {
            sqlx::query(sql).execute(connection).await?;
            Ok(())
        })
    });
    done.await.expect("is done");
}

/// Submits a scene, and ends its job like this.
async fn scene_ends(store: &Store, outcome: AttemptOutcome) {
    submitted(store).await;
    let claim = claimed(store, "worker").await;
    store.finish(&claim.lease, outcome).await.expect("finishes");
}

pub(super) async fn every_way_to_the_end_of_a_scene_has_one_message(place: Place) {
    use EventType as E;
    let store = place.store();
    let id = webhook(store).await;
    let (mut expected, mut ways) = (Vec::new(), 0);
    let mut ended = async |event: EventType, state: &str, code: Option<&str>| {
        expected.push((event, state.to_owned(), code.map(str::to_owned)));
        ways += 1;
        assert_eq!(messages(store, &id).await, expected, "way {ways}");
    };
    scene_ends(store, built(true)).await;
    ended(E::SceneSucceeded, "succeeded", None).await;
    scene_ends(store, built(false)).await;
    ended(E::SceneQuarantined, "quarantined", Some("quarantined")).await;
    scene_ends(store, failed()).await;
    ended(E::SceneFailed, "failed", Some("no_room")).await;
    let AttemptOutcome::Failed(failure) = failed() else { panic!("it fails") };
    let retry = |max_attempts| {
        let failure = failure.clone();
        AttemptOutcome::Retry { failure, delay: Duration::ZERO, charged: true, max_attempts }
    };
    scene_ends(store, retry(2)).await;
    let claim = claimed(store, "worker").await;
    store.finish(&claim.lease, retry(2)).await.expect("finishes");
    ended(E::SceneFailed, "failed", Some("no_room")).await;

    // No worker ends these.
    let (_, waiting) = submitted(store).await;
    store.cancel(&DEFAULT_TENANT, &waiting).await.expect("answers");
    store.cancel(&DEFAULT_TENANT, &waiting).await.expect("answers");
    ended(E::SceneCancelled, "cancelled", Some("cancelled")).await;
    let (scene, _) = submitted(store).await;
    store.delete_scene(&DEFAULT_TENANT, &scene).await.expect("answers");
    ended(E::SceneCancelled, "cancelled", Some("cancelled")).await;
    let late = Schedule { deadline_ms: Some(1), ..Schedule::usual(test_settings::section("queue")) };
    store.submit_scheduled(new_scene(), late, None).await.expect("submits");
    store.rescue(MAX_DEATHS).await.expect("answers");
    ended(E::SceneFailed, "failed", Some("deadline_passed")).await;
    submitted(store).await;
    store.claim("dead", Duration::ZERO, 1, &Scope::all()).await.expect("answers").expect("there is a job");
    tokio::time::sleep(Duration::from_millis(5)).await;
    store.rescue(1).await.expect("answers");
    ended(E::SceneFailed, "failed", Some("worker_crashed")).await;

    // A cancellation is final when the worker stops, ends the work all the same, or is dead.
    for outcome in [AttemptOutcome::Stopped, built(true), failed(), retry(9), AttemptOutcome::Released] {
        let (_, job) = submitted(store).await;
        let claim = claimed(store, "worker").await;
        store.cancel(&DEFAULT_TENANT, &job).await.expect("answers");
        store.finish(&claim.lease, outcome).await.expect("finishes");
        ended(E::SceneCancelled, "cancelled", Some("cancelled")).await;
    }
    let (_, job) = submitted(store).await;
    store.claim("dead", Duration::ZERO, 9, &Scope::all()).await.expect("answers").expect("there is a job");
    store.cancel(&DEFAULT_TENANT, &job).await.expect("answers");
    tokio::time::sleep(Duration::from_millis(5)).await;
    store.rescue(9).await.expect("answers");
    ended(E::SceneCancelled, "cancelled", Some("cancelled")).await;

    // A retry ends again, with a job of its own.
    store.retry(&DEFAULT_TENANT, &waiting, None).await.expect("answers");
    let claim = claimed(store, "worker").await;
    store.finish(&claim.lease, built(true)).await.expect("finishes");
    ended(E::SceneSucceeded, "succeeded", None).await;
    let rows = deliveries(store, &id).await;
    let (first, last) = (&rows[4].message.data, &rows.last().expect("is there").message.data);
    assert_eq!((&first.id, &first.path), (&last.id, &last.path));
    assert_eq!(last.path, format!("/scenes/{}", last.id));
    assert_eq!(last.job_id.as_deref(), Some(claim.lease.job_id.as_str()));
    assert_ne!(first.job_id, last.job_id);
}

pub(super) async fn every_end_of_other_work_has_one_message(place: Place) {
    use EventType as E;
    let store = place.store();
    let id = webhook(store).await;
    let mut expected = Vec::new();
    let mut ended = async |event: EventType, state: &str, code: Option<&str>| {
        expected.push((event, state.to_owned(), code.map(str::to_owned)));
        assert_eq!(messages(store, &id).await, expected);
    };
    let claim = async |scope: &Scope| {
        store.claim("a", LEASE, MAX_DEATHS, scope).await.expect("answers").expect("there is work").lease
    };
    let dataset = submitted_dataset(store, "mugs").await;
    let row = async || store.dataset(&DEFAULT_TENANT, &dataset).await.expect("reads").expect("is there");
    let job = row().await.job_id.expect("a job");
    store.cancel(&DEFAULT_TENANT, &job).await.expect("answers");
    ended(E::DatasetEnded, "failed", Some("cancelled")).await;
    store.retry(&DEFAULT_TENANT, &job, None).await.expect("answers");
    store.finish(&claim(&freezing()).await, failed()).await.expect("finishes");
    ended(E::DatasetEnded, "failed", Some("no_room")).await;
    store.retry(&DEFAULT_TENANT, &row().await.job_id.expect("a job"), None).await.expect("answers");
    store.finish(&claim(&freezing()).await, frozen(1, &[])).await.expect("finishes");
    ended(E::DatasetEnded, "finished", None).await;
    for (outcome, event, state, code) in [
        (AttemptOutcome::Verified(json!({})), E::JobSucceeded, "succeeded", None),
        (failed(), E::JobFailed, "failed", Some("no_room")),
    ] {
        store.verify_dataset(&DEFAULT_TENANT, &dataset).await.expect("answers");
        store.finish(&claim(&freezing()).await, outcome).await.expect("finishes");
        ended(event, state, code).await;
    }

    let answer =
        ExecutionAnswer { digest: Digest::of(b"answer"), media_type: "application/json".to_owned(), size: 6 };
    for (outcome, event, state, code) in [
        (Some(AttemptOutcome::Executed(answer)), E::JobSucceeded, "succeeded", None),
        (Some(failed()), E::JobFailed, "failed", Some("no_room")),
        (None, E::JobCancelled, "cancelled", Some("cancelled")),
    ] {
        let job = executing(store).await;
        match outcome {
            Some(outcome) => {
                store.finish(&claim(&Scope::Job(job)).await, outcome).await.expect("finishes");
            }
            None => drop(store.cancel(&DEFAULT_TENANT, &job).await.expect("answers")),
        }
        ended(event, state, code).await;
    }

    let batch: BatchId = batch_of(store, 1).await;
    feed(store, &batch, 9).await;
    let lease = claimed(store, "worker").await.lease;
    store.finish(&lease, built(true)).await.expect("finishes");
    ended(E::SceneSucceeded, "succeeded", None).await;
    feed(store, &batch, 9).await;
    feed(store, &batch, 9).await;
    ended(E::BatchEnded, "finished", None).await;
    let cancelled = batch_of(store, 1).await;
    store.cancel_batch(&DEFAULT_TENANT, &cancelled).await.expect("answers");
    feed(store, &cancelled, 9).await;
    ended(E::BatchEnded, "cancelled", None).await;
    let rows = deliveries(store, &id).await;
    assert_eq!(rows.last().expect("is there").message.data.path, format!("/batches/{cancelled}"));
}

/// A new execution.
async fn executing(store: &Store) -> JobId {
    let execution = NewExecution {
        tenant_id: DEFAULT_TENANT.clone(),
        scene_id: "scene".parse().expect("an id"),
        request: json!({ "version": 1 }),
        bundle: Digest::of(b"bundle"),
        idempotency: None,
    };
    match store.submit_execution(execution).await.expect("submits") {
        SubmitExecutionOutcome::Created(job) => job,
        other => panic!("{other:?}"),
    }
}

pub(super) async fn every_end_of_a_recording_has_one_message(place: Place) {
    use super::recordings::{assembly, attempt, keep, made, submitted};
    let store = place.store();
    let id = webhook(store).await;
    let recording = submitted(store, 1, 50).await;
    let kept = attempt(store, "a").await;
    keep(store, &kept, made("success")).await.expect("keeps");
    let lease = assembly(store, "a").await;
    store.finish(&lease, AttemptOutcome::Assembled(json!({ "episodes": 1 }))).await.expect("finishes");
    submitted(store, 1, 50).await;
    let lost = attempt(store, "a").await;
    store.finish(&lost.lease, failed()).await.expect("finishes");
    let cancelled = submitted(store, 1, 50).await;
    store.cancel_recording(&DEFAULT_TENANT, &cancelled).await.expect("answers");
    submitted(store, 1, 50).await;
    let open = attempt(store, "a").await;
    store.cancel(&DEFAULT_TENANT, &open.lease.job_id).await.expect("answers");
    store.finish(&open.lease, AttemptOutcome::Stopped).await.expect("ends");
    let deleted = submitted(store, 1, 50).await;
    store.delete_recording(&DEFAULT_TENANT, &deleted).await.expect("answers");
    let expected = [
        ("finished", None),
        ("failed", Some("no_room")),
        ("cancelled", None),
        ("cancelled", None),
        ("cancelled", None),
    ];
    let expected =
        expected.map(|(state, code)| (EventType::RecordingEnded, state.to_owned(), code.map(str::to_owned)));
    assert_eq!(messages(store, &id).await, expected);
    assert_eq!(deliveries(store, &id).await[0].message.data.path, format!("/episodes/{recording}"));
}

pub(super) async fn a_change_and_its_message_are_one(place: Place) {
    let store = place.store();
    let id = webhook(store).await;
    let (scene, _) = submitted(store).await;
    let lease = claimed(store, "worker").await.lease;
    statement(store, "ALTER TABLE deliveries RENAME TO hidden").await;
    assert!(store.finish(&lease, built(true)).await.is_err(), "the message cannot be written");
    statement(store, "ALTER TABLE hidden RENAME TO deliveries").await;
    let row = store.scene(&DEFAULT_TENANT, &scene).await.expect("reads").expect("is there");
    assert_eq!(row.state, crate::lifecycle::SceneState::Pending);
    assert_eq!(messages(store, &id).await, []);
    let stale = Lease { epoch: lease.epoch - 1, ..lease.clone() };
    assert!(matches!(store.finish(&stale, built(true)).await, Err(StoreError::LeaseLost { .. })));
    assert_eq!(messages(store, &id).await, []);
    store.finish(&lease, built(true)).await.expect("finishes");
    assert_eq!(messages(store, &id).await.len(), 1);
}

pub(super) async fn only_enabled_webhooks_that_want_an_event_get_it(place: Place) {
    let store = place.store();
    let all = webhook(store).await;
    let failures = webhook_of(store, &DEFAULT_TENANT, &[EventType::SceneFailed]).await.id;
    let disabled = webhook_of(store, &DEFAULT_TENANT, &[]).await;
    let off =
        store.change_webhook(&DEFAULT_TENANT, disabled.clone(), new_webhook(&DEFAULT_TENANT, &[]), false);
    let ChangeOutcome::Changed(disabled) = off.await.expect("answers") else { panic!("no other changes it") };
    assert_eq!(disabled.disabled_reason.as_deref(), Some("it was disabled by a request"));
    let other = webhook_of(store, &"other".parse().expect("an id"), &[]).await;
    scene_ends(store, built(true)).await;
    scene_ends(store, failed()).await;
    let mut counts = Vec::new();
    for id in [&all, &failures, &disabled.id, &other.id] {
        counts.push(messages(store, id).await.len());
    }
    assert_eq!(counts, [2, 1, 0, 0]);
    let [succeeded, failed] = deliveries(store, &all).await.try_into().expect("two");
    assert_ne!(succeeded.id, failed.id);
    assert!(succeeded.id.as_str().starts_with("msg_"), "{}", succeeded.id);
    // A page behind the newest one.
    let before_uuid = Some(failed.uuid().to_owned());
    let filter = DeliveryFilter { before_uuid, limit: 9, state: Some(DeliveryState::Waiting) };
    assert_eq!(store.deliveries(&DEFAULT_TENANT, &all, filter).await.expect("reads"), [succeeded]);
}

pub(super) async fn each_delivery_is_taken_by_one_process_and_given_again_after_a_death(place: Place) {
    let (one, other) = (place.handle(0), place.handle(1));
    let (first, second) = (webhook(&one).await, webhook(&one).await);
    scene_ends(&one, built(true)).await;
    scene_ends(&one, failed()).await;
    let taken = due(&one).await;
    let webhooks: Vec<&WebhookId> = taken.iter().map(|due| &due.webhook_id).collect();
    assert_eq!(webhooks, [&first, &second], "one of each");
    assert_eq!(due(&other).await.len(), 0, "a webhook has one message under way");
    // The first webhook answers; it goes on while the other one hangs.
    assert!(end(&one, &taken[0], AttemptEnd::Delivered).await);
    let next = other.claim_deliveries(Duration::ZERO, 9).await.expect("answers");
    assert_eq!(next.len(), 1);
    assert_eq!((&next[0].webhook_id, next[0].attempt), (&first, 1));
    // That process dies, or is paused past its time, and another one takes the message over.
    tokio::time::sleep(Duration::from_millis(5)).await;
    let again = due(&one).await;
    assert_eq!((again.len(), &again[0].id, again[0].attempt), (1, &next[0].id, 2));
    assert!(!end(&other, &next[0], AttemptEnd::Delivered).await, "it has no say any more");
    assert!(end(&one, &again[0], AttemptEnd::RetryAfter(Duration::from_secs(60))).await);
    let rows = deliveries(&one, &first).await;
    assert_eq!(
        rows.iter().map(|row| row.state).collect::<Vec<_>>(),
        [DeliveryState::Delivered, DeliveryState::Waiting]
    );
    let last = &rows[1];
    assert_eq!((last.status, last.duration_ms, last.attempts), (Some(500), Some(7), 2));
    assert!(last.next_at_ms > last.tried_at_ms.expect("was tried") + 59_000);
    assert_eq!(due(&other).await.len(), 0, "its pause lasts");
    let replayed = one.replay_delivery(&DEFAULT_TENANT, &first, &last.id).await.expect("answers");
    assert!(matches!(replayed, OrderOutcome::Ordered(_)), "{replayed:?}");
    assert_eq!(due(&other).await.len(), 1, "one that waits is sent at once when it is replayed");
}

pub(super) async fn claims_at_once_give_each_delivery_out_once(place: Place) {
    let store = place.store();
    for _ in 0..MAX_WEBHOOKS {
        webhook(store).await;
    }
    let refused = store.create_webhook(new_webhook(&DEFAULT_TENANT, &[])).await.expect("answers").0;
    assert_eq!(refused, CreateOutcome::TooMany);
    scene_ends(store, built(true)).await;
    let claims = (0..8).map(|index| {
        let store = place.handle(index);
        tokio::spawn(async move { store.claim_deliveries(LEASE, 4).await.expect("answers") })
    });
    let mut ids = Vec::new();
    for claim in claims.collect::<Vec<_>>() {
        ids.extend(claim.await.expect("ends").into_iter().map(|due| due.id));
    }
    loop {
        let more = store.claim_deliveries(LEASE, 4).await.expect("answers");
        if more.is_empty() {
            break;
        }
        ids.extend(more.into_iter().map(|due| due.id));
    }
    let count = ids.len();
    ids.sort();
    ids.dedup();
    assert_eq!((ids.len(), count), (MAX_WEBHOOKS, MAX_WEBHOOKS));
}

pub(super) async fn failures_to_the_end_disable_a_webhook(place: Place) {
    let store = place.store();
    let id = webhook(store).await;
    for _ in 0..6 {
        scene_ends(store, built(true)).await;
    }
    let next = async |ended: AttemptEnd| {
        let due = due(store).await.pop().expect("is due");
        assert!(end(store, &due, ended).await);
        store.webhook(&DEFAULT_TENANT, &id).await.expect("reads").expect("is there")
    };
    let failed = AttemptEnd::Failed { max_failures: 2 };
    assert_eq!(next(failed).await.disabled_reason, None);
    assert_eq!(next(AttemptEnd::Delivered).await.disabled_reason, None, "a success counts anew");
    assert_eq!(next(failed).await.disabled_reason, None);
    let disabled = next(failed).await;
    let reason = disabled.disabled_reason.clone().expect("is disabled");
    assert!(reason.contains("2 deliveries in a row") && reason.contains("answered 500"), "{reason}");
    scene_ends(store, built(true)).await;
    assert_eq!(deliveries(store, &id).await.len(), 6, "nothing new is kept for it");
    assert_eq!(due(store).await.len(), 0);
    assert_eq!(store.test_webhook(&DEFAULT_TENANT, &id).await.expect("answers"), OrderOutcome::Disabled);
    let ordered = &deliveries(store, &id).await[0].id;
    let replayed = store.replay_delivery(&DEFAULT_TENANT, &id, ordered).await.expect("answers");
    assert_eq!(replayed, OrderOutcome::Disabled);

    // Enabled again, it gets what waited, and may fail as often again.
    let on = store.change_webhook(&DEFAULT_TENANT, disabled.clone(), new_webhook(&DEFAULT_TENANT, &[]), true);
    assert!(
        matches!(on.await.expect("answers"), ChangeOutcome::Changed(row) if row.disabled_reason.is_none())
    );
    let late = store.change_webhook(&DEFAULT_TENANT, disabled, new_webhook(&DEFAULT_TENANT, &[]), false);
    assert_eq!(late.await.expect("answers"), ChangeOutcome::Differs);
    assert_eq!(next(failed).await.disabled_reason, None);
    let gone = next(AttemptEnd::Gone).await.disabled_reason.expect("is disabled");
    assert!(gone.contains("410"), "{gone}");
}

pub(super) async fn a_new_secret_signs_beside_the_previous_one_for_a_day(place: Place) {
    let store = place.store();
    let (CreateOutcome::Created(row), first) =
        store.create_webhook(new_webhook(&DEFAULT_TENANT, &[])).await.expect("answers")
    else {
        panic!("there is room")
    };
    let renewed = async || {
        store.renew_webhook_secret(&DEFAULT_TENANT, &row.id).await.expect("answers").expect("is there").1
    };
    let secrets = async || {
        store.test_webhook(&DEFAULT_TENANT, &row.id).await.expect("answers");
        let due = due(store).await.pop().expect("is due");
        assert!(end(store, &due, AttemptEnd::Delivered).await);
        assert!(!format!("{due:?}").contains("whsec_"), "{due:?}");
        due.secrets
    };
    assert_eq!(secrets().await, std::slice::from_ref(&first));
    let second = renewed().await;
    assert_eq!(secrets().await, [second.clone(), first]);
    let third = renewed().await;
    assert_eq!(secrets().await, [third.clone(), second]);
    statement(store, "UPDATE webhooks SET previous_secret_until = previous_secret_until - 86400000").await;
    assert_eq!(secrets().await, [third]);
}

pub(super) async fn webhooks_belong_to_their_tenant(place: Place) {
    let store = place.store();
    let other: TenantId = "other".parse().expect("an id");
    let row = webhook_of(store, &DEFAULT_TENANT, &[]).await;
    let id = &row.id;
    store.test_webhook(&DEFAULT_TENANT, id).await.expect("answers");
    let delivery = deliveries(store, id).await.pop().expect("is there").id;
    for (tenant, count) in [(&*DEFAULT_TENANT, 1), (&other, 0)] {
        let all = DeliveryFilter { limit: 9, ..DeliveryFilter::default() };
        assert_eq!(store.webhooks(tenant).await.expect("reads").len(), count);
        assert_eq!(store.webhook(tenant, id).await.expect("reads").iter().count(), count);
        assert_eq!(store.deliveries(tenant, id, all).await.expect("reads").len(), count);
    }
    let change = store.change_webhook(&other, row.clone(), new_webhook(&other, &[]), false);
    assert_eq!(change.await.expect("answers"), ChangeOutcome::Differs);
    assert!(store.renew_webhook_secret(&other, id).await.expect("answers").is_none());
    assert_eq!(store.test_webhook(&other, id).await.expect("answers"), OrderOutcome::NoWebhook);
    let replayed = store.replay_delivery(&other, id, &delivery).await.expect("answers");
    assert_eq!(replayed, OrderOutcome::NoWebhook);
    let foreign = webhook_of(store, &other, &[]).await.id;
    let replayed = store.replay_delivery(&other, &foreign, &delivery).await.expect("answers");
    assert_eq!(replayed, OrderOutcome::NoDelivery);
    assert_eq!(store.delete_webhook(&other, id).await.expect("answers"), DeleteOutcome::NotFound);
    assert_eq!(store.webhook(&DEFAULT_TENANT, id).await.expect("reads"), Some(row));
    assert_eq!(due(store).await.len(), 1);
}

pub(super) async fn deliveries_go_after_their_time(place: Place) {
    let store = place.store();
    let settings =
        RetentionSettings { delivery_hours: 2, grace_secs: 0, ..test_settings::section("store.retention") };
    let swept = async || store.sweep(&settings, false).await.expect("sweeps").expect("no backup").deliveries;
    let (kept, deleted) = (webhook(store).await, webhook(store).await);
    for _ in 0..2 {
        scene_ends(store, built(true)).await;
    }
    let mut taken = due(store).await;
    taken.retain(|due| due.webhook_id == kept);
    assert!(end(store, &taken[0], AttemptEnd::Delivered).await);
    assert_eq!(store.delete_webhook(&DEFAULT_TENANT, &deleted).await.expect("answers"), DeleteOutcome::Done);
    assert_eq!(swept().await, 0, "all are young");
    statement(store, "UPDATE deliveries SET created_at = created_at - 10800000").await;
    let dry = store.sweep(&settings, true).await.expect("sweeps").expect("no backup").deliveries;
    assert_eq!(dry, 3);
    assert_eq!(swept().await, 3, "one that was delivered, and those of the deleted webhook");
    let rows = deliveries(store, &kept).await;
    assert_eq!(rows.iter().map(|row| row.state).collect::<Vec<_>>(), [DeliveryState::Waiting]);
    assert_eq!(due(store).await.len(), 1);
}
