//! `/episodes/{id}/events`: pages and streams of what a recorder does, which each test plays itself.

use std::sync::Arc;
use std::time::Duration;

use hyper::Method;
use scene::RecordingId;
use serde_json::{Value, json};
use store::lifecycle::{Failure, FailureClass, JobKind};
use store::queue::{AttemptOutcome, Scope};
use store::recordings::{MadeAttempt, NewRecording, SubmitRecordingOutcome};
use store::{DEFAULT_TENANT, Digest, Intent, Lease, Store};
use tabletopgen::app::App;
use tabletopgen::{app, service};

use crate::harness::event_stream::{EventStream, SentEvent};
use crate::harness::server::{Server, settings};

const SCENE: &str = "0192f3a4-5b6c-7d8e-9fa0-b1c2d3e4f5a6";

async fn server(set: &[(&str, &str)]) -> Server {
    Server::without_worker(Arc::new(tempfile::tempdir().unwrap()), set).await
}

/// A recording that waits, and the path of its events.
pub async fn ordered(store: &Store, wanted: u64) -> (RecordingId, String) {
    let new = NewRecording {
        tenant_id: DEFAULT_TENANT.clone(),
        scene_id: SCENE.parse().unwrap(),
        request: json!({ "version": 1, "order": { "task": "pick up the mug", "count": wanted } }),
        bundle: Digest::of(b"bundle"),
        wanted,
        max_attempts: 50,
        idempotency_key: None,
        body_digest: Digest::of(b"body"),
    };
    let SubmitRecordingOutcome::Created(id) = store.submit_recording(new).await.unwrap() else {
        panic!("it has no key");
    };
    let path = format!("/episodes/{}/events", id.as_str());
    (id, path)
}

/// Claims the next job of a recording.
async fn work(store: &Store, kind: JobKind) -> Lease {
    let scope = Scope::Kinds(vec![JobKind::RecordAttempt, JobKind::AssembleRecording]);
    let claim = store.claim("a", Duration::from_secs(60), 9, &scope).await.unwrap().expect("there is work");
    assert_eq!(claim.work.kind(), kind);
    claim.lease
}

async fn attempt(store: &Store) -> Lease {
    work(store, JobKind::RecordAttempt).await
}

async fn assembly(store: &Store) -> Lease {
    work(store, JobKind::AssembleRecording).await
}

/// Makes an attempt.
pub async fn made(store: &Store, outcome: &str) {
    let made = MadeAttempt { outcome: outcome.into(), detail: format!("it was {outcome}"), unit: None };
    store.finish(&attempt(store).await, AttemptOutcome::Attempted(made)).await.unwrap();
}

pub async fn finished(store: &Store) {
    let summary = AttemptOutcome::Assembled(json!({ "attempts": {}, "episodes": 1, "frames": 9 }));
    store.finish(&assembly(store).await, summary).await.unwrap();
}

fn kinds(events: &[SentEvent]) -> Vec<&str> {
    events.iter().map(|event| event.kind.as_str()).collect()
}

fn numbers(events: &[SentEvent]) -> Vec<i64> {
    events.iter().map(|event| event.seq).collect()
}

#[tokio::test]
async fn pages_tell_of_every_attempt_with_the_progress_after_it() {
    let server = server(&[]).await;
    let (id, path) = ordered(server.store(), 1).await;
    made(server.store(), "slipped").await;
    made(server.store(), "success").await;
    let recording = server.get(&format!("/episodes/{}", id.as_str())).await.json();
    assert_eq!(recording["links"]["events"], path);
    finished(server.store()).await;
    let (mut seen, mut after): (Vec<Value>, _) = (Vec::new(), 0);
    loop {
        let page = server.get(&format!("{path}?after={after}&page_size=4")).await.json();
        let events = page["events"].as_array().unwrap().clone();
        after = page["next_after"].as_i64().unwrap();
        if events.is_empty() {
            break;
        }
        seen.extend(events);
    }
    assert_eq!(after, 6, "a client can ask again for what follows");
    let kinds: Vec<&str> = seen.iter().map(|event| event["kind"].as_str().unwrap()).collect();
    assert_eq!(kinds, ["queued", "running", "attempt", "attempt", "assembling", "finished"]);
    let failure = &seen[2]["data"];
    assert_eq!((&failure["number"], &failure["outcome"]), (&json!(0), &json!("slipped")));
    assert_eq!(failure["detail"], "it was slipped");
    let success = &seen[3]["data"];
    assert!(success["detail"].is_null());
    let progress = &success["progress"];
    assert_eq!(progress, &recording["progress"], "the same as that of the recording then");
    assert_eq!((&progress["attempts"], &progress["success_rate"]), (&json!(2), &json!(0.5)));
    assert_eq!(server.get(&format!("{path}?after=-1")).await.problem().0, 400);
    assert_eq!(server.get(&format!("{path}?kind=attempt")).await.problem().0, 400);
    let unknown = server.get(&format!("/episodes/{SCENE}/events")).await;
    assert_eq!(unknown.problem(), (404, "not_found".into()));
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_stream_follows_the_recording_and_ends_with_it() {
    let server = server(&[]).await;
    let (_, path) = ordered(server.store(), 2).await;
    let open = EventStream::open(server.service.address, &path, None);
    let (seen, open) = open.read(1).await;
    assert_eq!(kinds(&seen), ["queued"]);
    made(server.store(), "slipped").await;
    // They come at once, not with the next poll.
    let soon = tokio::time::timeout(Duration::from_secs(3), open.read(2));
    let (seen, open) = soon.await.expect("the stream is awake");
    assert_eq!(kinds(&seen), ["running", "attempt"]);
    made(server.store(), "success").await;
    made(server.store(), "success").await;
    finished(server.store()).await;
    let rest = open.until(usize::MAX).await;
    assert_eq!(kinds(&rest), ["attempt", "attempt", "assembling", "finished"]);
    assert_eq!(numbers(&rest), [4, 5, 6, 7]);
    let page = server.get(&format!("{path}?after=3")).await.json();
    let sent: Vec<&Value> = rest.iter().map(|event| &event.data).collect();
    assert_eq!(sent, page["events"].as_array().unwrap().iter().collect::<Vec<_>>());

    let again = EventStream::open(server.service.address, &path, Some(5)).until(usize::MAX).await;
    assert_eq!(again, rest[2..]);
    let answer = async |last: &str| {
        let headers = [("accept", "text/event-stream"), ("last-event-id", last)];
        server.call(Method::GET, &path, &headers, "").await
    };
    assert_eq!(answer("7").await.status, 204, "there is nothing to come back for");
    assert_eq!(answer("x").await.problem(), (400, "invalid_last_event_id".into()));

    // Failures and cancellations are ends, too.
    let (id, path) = ordered(server.store(), 1).await;
    let open = EventStream::open(server.service.address, &path, None);
    let lease = attempt(server.store()).await;
    let failure = Failure {
        class: FailureClass::Permanent,
        code: "not_feasible".into(),
        message: "the arm is too short".into(),
    };
    server.store().finish(&lease, AttemptOutcome::Failed(failure)).await.unwrap();
    let all = open.until(usize::MAX).await;
    assert_eq!(kinds(&all), ["queued", "running", "failed"]);
    assert_eq!(all[2].data["data"]["failure"]["code"], "not_feasible");
    assert_eq!(server.get(&format!("/episodes/{}", id.as_str())).await.json()["state"], "failed");
    let (id, path) = ordered(server.store(), 1).await;
    let open = EventStream::open(server.service.address, &path, None);
    server.call(Method::POST, &format!("/episodes/{}/cancel", id.as_str()), &[], "").await;
    assert_eq!(kinds(&open.until(usize::MAX).await), ["queued", "cancelled"]);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_stream_goes_on_after_a_restart_where_it_broke_off() {
    let server = server(&[]).await;
    let (_, path) = ordered(server.store(), 2).await;
    made(server.store(), "slipped").await;
    let open = EventStream::open(server.service.address, &path, None);
    let (before, open) = open.read(2).await;
    let directory = server.stop().await;
    let sent = [before, open.until(usize::MAX).await].concat();
    assert!(sent.iter().all(|event| event.kind != "finished"));

    let server = Server::without_worker(directory, &[]).await;
    let last = sent.last().unwrap().seq;
    let open = EventStream::open(server.service.address, &path, Some(last));
    made(server.store(), "success").await;
    made(server.store(), "success").await;
    finished(server.store()).await;
    let all = [sent, open.until(usize::MAX).await].concat();
    assert_eq!(numbers(&all), (1..=7).collect::<Vec<_>>());
    assert_eq!(all[6].kind, "finished");
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn streams_are_limited_in_age_and_number() {
    let set = [("server.max_event_stream_secs", "1"), ("server.max_event_streams_per_address", "2")];
    let server = server(&set).await;
    let (_, path) = ordered(server.store(), 1).await;
    let (_, other) = ordered(server.store(), 1).await;
    let one = EventStream::open(server.service.address, &path, None);
    let _two = EventStream::open(server.service.address, &other, None);
    let headers = [("accept", "text/event-stream")];
    let refused = server.call(Method::GET, &path, &headers, "").await;
    assert_eq!(refused.problem(), (429, "too_many_streams".into()));
    assert_eq!(server.get(&path).await.status, 200, "pages are no streams");
    assert_eq!(kinds(&one.until(usize::MAX).await), ["queued"], "it ends, as it is old");
    made(server.store(), "success").await;
    let next = EventStream::open(server.service.address, &path, Some(1)).until(2).await;
    assert_eq!((kinds(&next), numbers(&next)), (vec!["running", "attempt"], vec![2, 3]));
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_stream_tells_what_other_processes_do() {
    let url = test_postgres::database().await;
    let resolved = settings(&[("store.database", &url), ("store.blobs", "memory")]);
    let directories = [(); 2].map(|()| tempfile::tempdir().unwrap());
    let [one, other] = directories;
    let service = service::start_api(&App::new(&resolved), one.path()).await.unwrap();
    let server = Server::serving(Arc::new(one), service);
    let worker = app::open(other.path(), &resolved.config, Intent::Create).await.unwrap();
    let (_, path) = ordered(server.store(), 1).await;
    let open = EventStream::open(server.service.address, &path, None);
    let (seen, open) = open.read(1).await;
    assert_eq!(kinds(&seen), ["queued"]);
    made(&worker, "success").await;
    finished(&worker).await;
    let rest = open.until(usize::MAX).await;
    assert_eq!(kinds(&rest), ["running", "attempt", "assembling", "finished"]);
}
