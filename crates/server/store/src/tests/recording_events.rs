//! Events of recordings: each change has one, in order, by any process.

use serde_json::Value;

use super::recordings::{
    assembly, attempt, attempt_of, episode_lost, keep, made, new_recording, recording, submitted,
};
use super::*;
use crate::events::Event;
use crate::queue::AttemptOutcome;
use crate::recordings::{
    Begun, MadeAttempt, NewRecording, RecordingEventHead, RecordingState, SubmitRecordingOutcome,
};
use scene::RecordingId;

async fn events(store: &Store, id: &RecordingId) -> Vec<Event> {
    let events = store.recording_events(&DEFAULT_TENANT, id, 0, 200).await.expect("reads");
    let numbers: Vec<i64> = events.iter().map(|event| event.seq).collect();
    assert_eq!(numbers, (1..=events.len() as i64).collect::<Vec<_>>());
    events
}

fn kinds(events: &[Event]) -> Vec<&str> {
    events.iter().map(|event| event.kind.as_str()).collect()
}

/// Attempts and successes after an event.
fn counts(event: &Event) -> (u64, u64) {
    let count = |name: &str| event.data["progress"][name].as_u64().expect("a count");
    (count("attempts"), count("successes"))
}

pub(super) async fn every_change_has_an_event_with_the_progress_after_it(place: Place) {
    let (one, other) = (place.handle(0), place.handle(1));
    let id = submitted(&one, 1, 50).await;
    let slipped = attempt(&one, "a").await;
    let dead = one.claim("a", Duration::ZERO, MAX_DEATHS, &recording()).await.expect("answers");
    let dead = attempt_of(dead.expect("there is work"));
    let detail = "the can fell".to_owned();
    let failure = MadeAttempt { outcome: "slipped".into(), detail, unit: None };
    keep(&one, &slipped, failure).await.expect("keeps");
    let taken_over = attempt(&other, "b").await;
    keep(&one, &dead, made("success")).await.expect_err("the lease is lost, and nothing is told");
    keep(&other, &taken_over, made("success")).await.expect("keeps");
    // Assembling has one event, however often it is begun, and another one after an attempt is lost.
    let given_back = assembly(&one, "a").await;
    one.finish(&given_back, AttemptOutcome::Released).await.expect("gives back");
    let lease = assembly(&other, "b").await;
    other.finish(&lease, episode_lost(taken_over.number)).await.expect("ends");
    let again = attempt(&one, "a").await;
    keep(&one, &again, made("success")).await.expect("keeps");
    let lease = assembly(&other, "b").await;
    other.begin_assembly(&lease).await.expect("begins");
    other.finish(&lease, AttemptOutcome::Assembled(json!({ "episodes": 1 }))).await.expect("finishes");

    let all = events(&other, &id).await;
    assert_eq!(events(&one, &id).await, all);
    let expected = [
        "queued",
        "running",
        "attempt",
        "attempt",
        "assembling",
        "attempt_lost",
        "attempt",
        "assembling",
        "finished",
    ];
    assert_eq!(kinds(&all), expected);
    let progress: Vec<(u64, u64)> = all.iter().map(counts).collect();
    assert_eq!(progress, [(0, 0), (0, 0), (1, 0), (2, 1), (2, 1), (1, 0), (2, 1), (2, 1), (2, 1)]);
    let of = |index: usize, name: &str| all[index].data[name].clone();
    assert_eq!((of(2, "number"), of(2, "outcome")), (json!(0), json!("slipped")));
    assert_eq!(of(2, "detail"), json!("the can fell"));
    assert_eq!(
        (of(3, "number"), of(3, "outcome"), of(3, "detail")),
        (json!(1), json!("success"), Value::Null)
    );
    assert_eq!(of(5, "number"), json!(1));
    let after: &Value = &all[3].data["progress"];
    assert_eq!((&after["wanted"], &after["max_attempts"]), (&json!(1), &json!(50)));
    assert_eq!(after["success_rate"], json!(0.5));
    assert_eq!(all[8].data["progress"]["seconds_left"], Value::Null, "it has ended");

    let rest = one.recording_events(&DEFAULT_TENANT, &id, 7, 1).await.expect("reads");
    assert_eq!(rest, all[7..8]);
    let waiting = submitted(&one, 1, 9).await;
    let missing: RecordingId = "missing".parse().expect("an id");
    let mut heads = one
        .recording_event_heads(&DEFAULT_TENANT, &[missing, waiting.clone(), id.clone()])
        .await
        .expect("reads");
    heads.sort_by_key(|head| head.last_seq);
    let head = |id: &RecordingId, last_seq, state| RecordingEventHead { id: id.clone(), last_seq, state };
    assert_eq!(heads, [head(&waiting, 1, RecordingState::Queued), head(&id, 9, RecordingState::Finished)]);
    let stranger: TenantId = "other".parse().expect("an id");
    assert_eq!(one.recording_events(&stranger, &id, 0, 9).await.expect("reads"), []);
    assert_eq!(one.recording_event_heads(&stranger, &[id]).await.expect("reads"), []);
}

pub(super) async fn ends_and_new_beginnings_have_events(place: Place) {
    let store = place.store();
    // The same order twice is one recording.
    let keyed = || NewRecording { idempotency_key: Some("key".into()), ..new_recording(2, 50) };
    let submitted_once = store.submit_recording(keyed()).await.expect("submits");
    let SubmitRecordingOutcome::Created(id) = submitted_once else { panic!("the key is new") };
    store.submit_recording(keyed()).await.expect("submits");
    let first = attempt(store, "a").await;
    assert_eq!(store.begin_recording(&first.lease, "old").await.expect("answers"), Begun::Agreed);
    keep(store, &first, made("success")).await.expect("keeps");
    let claimed = attempt(store, "a").await;
    assert_eq!(store.begin_recording(&claimed.lease, "new").await.expect("answers"), Begun::Restarted);
    let open = attempt(store, "a").await;
    store.cancel_recording(&DEFAULT_TENANT, &id).await.expect("cancels");
    store.cancel_recording(&DEFAULT_TENANT, &id).await.expect("answers");
    keep(store, &open, made("success")).await.expect_err("it is cancelled");
    let all = events(store, &id).await;
    assert_eq!(kinds(&all), ["queued", "running", "attempt", "restarted", "cancelled"]);
    assert_eq!(all.iter().map(counts).collect::<Vec<_>>(), [(0, 0), (0, 0), (1, 1), (0, 0), (0, 0)]);

    let id = submitted(store, 1, 50).await;
    let lease = attempt(store, "a").await;
    let failed = |code: &str, message: &str| {
        let (code, message) = (code.to_owned(), message.to_owned());
        AttemptOutcome::Failed(Failure { class: FailureClass::Permanent, code, message })
    };
    store.finish(&lease.lease, failed("not_feasible", "too far")).await.expect("fails");
    let all = events(store, &id).await;
    assert_eq!(kinds(&all), ["queued", "running", "failed"]);
    assert_eq!(all[2].data["failure"], json!({ "code": "not_feasible", "message": "too far" }));

    let id = submitted(store, 9, 1).await;
    let lease = attempt(store, "a").await;
    keep(store, &lease, made("no_path")).await.expect("keeps");
    let lease = assembly(store, "a").await;
    store.finish(&lease, failed("too_few_successes", "0 of 9")).await.expect("fails");
    let all = events(store, &id).await;
    assert_eq!(kinds(&all), ["queued", "running", "attempt", "assembling", "failed"]);
    assert_eq!(counts(&all[4]), (1, 0));
}

pub(super) async fn attempts_kept_at_once_have_events_without_gaps(place: Place) {
    let id = submitted(place.store(), 100, 24).await;
    let mut leases = Vec::new();
    for _ in 0..24 {
        leases.push(attempt(place.store(), "a").await);
    }
    let kept: Vec<_> = leases
        .into_iter()
        .enumerate()
        .map(|(index, lease)| {
            let store = place.handle(index);
            let outcome = if index % 3 == 0 { "success" } else { "slipped" };
            tokio::spawn(async move { keep(&store, &lease, made(outcome)).await })
        })
        .collect();
    for kept in kept {
        kept.await.expect("runs").expect("keeps");
    }
    let all = events(place.store(), &id).await;
    assert_eq!(all.len(), 26);
    let attempts: Vec<u64> = all[2..].iter().map(|event| counts(event).0).collect();
    assert_eq!(attempts, (1..=24).collect::<Vec<_>>(), "each tells the progress right after it");
    assert_eq!(counts(&all[25]), (24, 8));
}
