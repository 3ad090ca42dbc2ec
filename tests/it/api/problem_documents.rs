//! Refusals of slow and busy clients, of a full store, and of faults of the program, as whole documents.

use hyper::Method;
use insta::assert_json_snapshot;
use serde_json::{Value, json};
use tabletopgen::problem::{FieldError, Problem, ProblemType};

use super::damage::{damage, file_of, newest_job};
use super::documents::{marked, redacted};
use super::slow_clients::stall;
use crate::harness::event_stream::EventStream;
use crate::harness::script::{Act, Script};
use crate::harness::server::Server;

#[tokio::test]
async fn a_body_that_takes_too_long_has_this_document() {
    let server = Server::with(&Script::new(&[]), &[("server.body_timeout_secs", "1")]).await;
    let sent = "POST /scenes HTTP/1.1\r\nhost: localhost\r\ncontent-type: application/json\r\n\
                content-length: 100\r\nconnection: close\r\n\r\n{\"text\":";
    let (answer, _) = stall(&server, sent).await;
    let (_, body) = answer.split_once("\r\n\r\n").expect("an answer with a body");
    assert_json_snapshot!("request_timeout", redacted(serde_json::from_str(body).expect("JSON")));
}

#[tokio::test]
async fn a_full_queue_has_this_document() {
    let script = Script::new(&[("alpha", &[Act::Wait])]);
    let server = Server::with(
        &script,
        &[("queue.max_jobs", "1"), ("store.limits.waiting_jobs", "1"), ("worker.concurrency", "1")],
    )
    .await;
    server.submit("a mug").await;
    script.reaches("alpha").await;
    server.submit("a bowl").await;
    let refused = server.post("/scenes", json!({ "text": "a plate" })).await;
    assert_json_snapshot!("queue_full", marked(redacted(refused.json()), "/detail", "[limit and seconds]"));
    script.open_gate();
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn too_many_streams_have_this_document() {
    let script = Script::new(&[("alpha", &[Act::Wait])]);
    let server = Server::with(&script, &[("server.max_event_streams_per_address", "1")]).await;
    let (_, job) = server.submit("a mug").await;
    let path = format!("/jobs/{job}/events");
    let (address, open) = (server.service.address, path.clone());
    let stream = tokio::task::spawn_blocking(move || EventStream::open(address, &open, None)).await;
    let refused = server.call(Method::GET, &path, &[("accept", "text/event-stream")], "").await;
    assert_json_snapshot!("too_many_streams", redacted(refused.json()));
    drop(stream);
    script.open_gate();
}

#[tokio::test]
async fn a_full_quota_has_this_document() {
    let server = Server::start(&Script::new(&[])).await;
    let (_, job) = server.submit("a mug").await;
    server.job_is(&job, "succeeded").await;
    let directory = server.stop().await;
    let quota = [("store.limits.bytes", "1")];
    let server = Server::on(directory, &Script::new(&[]), &quota).await;
    let refused = server.post("/scenes", json!({ "text": "a bowl" })).await;
    let mut document = redacted(refused.json());
    let used = document["limit"]["used"].to_string().replace(".0", "");
    let detail = document["detail"].as_str().expect("words").replace(&used, "[bytes]");
    document["detail"] = detail.into();
    document["limit"]["used"] = "[bytes]".into();
    assert_json_snapshot!("insufficient_storage", document);
}

#[tokio::test]
async fn lost_bytes_have_these_documents() {
    let script = Script::new(&[]);
    let server = Server::start(&script).await;
    let (scene, job) = server.submit("a mug").await;
    server.job_is(&job, "succeeded").await;
    let path = format!("/scenes/{scene}/bundle");
    let whole = server.get(&path).await;
    script.next("omega", Act::Permanent);
    damage(&file_of(server.directory.path(), &whole));
    assert_json_snapshot!("being_rebuilt", redacted(server.get(&path).await.json()));
    let rebuild = newest_job(&server, &scene).await;
    server.job_is(&rebuild, "failed").await;
    assert_json_snapshot!("internal", redacted(server.get(&path).await.json()));
}

/// Refusals that the code for all requests can make, and one of each type.
#[test]
fn each_refusal_has_its_document() {
    let invalid = Problem::invalid(vec![
        FieldError::new("/seed", "must be at most 9007199254740991"),
        FieldError::new("", "needs a text or an image"),
    ]);
    let refusals = [
        ("invalid_body", invalid),
        ("storage_full", Problem::storage_full()),
        ("idempotency_key_reused", Problem::key_reused("scene")),
        ("no_such_resource", Problem::not_found("scene", "scn_1")),
    ];
    for (name, problem) in refusals {
        assert_json_snapshot!(name, problem.document("req-1"));
    }
    let types = ProblemType::ALL.map(|kind| Problem::new(kind, "a_code", "what to change").document("req-1"));
    assert_json_snapshot!("all_types", Value::from(types.to_vec()));
}
