//! Whole documents of the API, with ids, times, durations and digests redacted.

use hyper::Method;
use insta::assert_json_snapshot;
use serde_json::{Value, json};

use crate::harness::script::{Act, Script};
use crate::harness::server::Server;

/// The document without what differs from run to run.
pub fn redacted(document: Value) -> Value {
    let redact = |(name, value): (String, Value)| {
        let replacement = match name.as_str() {
            "created_at"
            | "updated_at"
            | "started_at"
            | "finished_at"
            | "estimated_finish_at"
            | "at"
            | "finish_at"
            | "not_before" => "[time]",
            "elapsed_ms" | "stages_s" | "scenes_per_hour" | "time_left_s" => "[duration]",
            "sha256" | "bundle_sha256" | "digest" | "inputs_digest" => "[digest]",
            "next_page_token" => "[token]",
            _ => return (name, redacted(value)),
        };
        let value = if value.is_null() { value } else { replacement.into() };
        (name, value)
    };
    match document {
        Value::Object(fields) => fields.into_iter().map(redact).collect(),
        Value::Array(items) => {
            let mut items: Vec<Value> = items.into_iter().map(redacted).collect();
            // Instances of one stage start in any order.
            if items.iter().all(|item| item["stage"].is_string()) {
                items.sort_by_key(|item| (item["stage"].to_string(), item["instance"].to_string()));
            }
            items.into()
        }
        Value::String(text) => {
            let ends = |c: char| !c.is_ascii_alphanumeric() && c != '-';
            let ids: Vec<&str> = text.split(ends).filter(|part| is_id(part)).collect();
            ids.iter().fold(text.clone(), |text, id| text.replace(id, "[id]")).into()
        }
        other => other,
    }
}

/// Puts a mark in place of the value at a pointer, in which `*` stands for every item of a list.
pub fn marked(mut document: Value, pointer: &str, mark: &str) -> Value {
    fn mark_at(value: &mut Value, path: &[&str], mark: &str) {
        match (path, value) {
            ([], value) if !value.is_null() => *value = mark.into(),
            (["*", rest @ ..], Value::Array(items)) => {
                items.iter_mut().for_each(|item| mark_at(item, rest, mark));
            }
            ([name, rest @ ..], Value::Object(fields)) => {
                fields.get_mut(*name).into_iter().for_each(|field| mark_at(field, rest, mark));
            }
            _ => {}
        }
    }
    let path: Vec<&str> = pointer.split('/').skip(1).collect();
    mark_at(&mut document, &path, mark);
    document
}

/// Whether a part of a path is the id of a scene or a job.
fn is_id(part: &str) -> bool {
    part.len() == 36 && part.bytes().all(|byte| byte.is_ascii_hexdigit() || byte == b'-')
}

/// A server that has made one scene.
async fn with_a_scene() -> (Server, String, String) {
    let server = Server::start(&Script::new(&[])).await;
    let body = json!({
        "text": "two mugs on a round table", "seed": 7, "labels": { "set": "a1" },
        "options": { "max_objects": 4, "budget_usd": 0.5 },
    });
    let headers = [("content-type", "application/json"), ("prefer", "wait=30")];
    let scene = server.call(Method::POST, "/scenes", &headers, body.to_string()).await.json();
    let text = |pointer: &str| scene.pointer(pointer).and_then(Value::as_str).unwrap_or_default().to_owned();
    let (id, job) = (text("/id"), text("/job/id"));
    (server, id, job)
}

#[tokio::test]
async fn a_finished_scene_and_its_job_have_these_documents() {
    let (server, scene, job) = with_a_scene().await;
    let documents = [
        ("scene", format!("/scenes/{scene}")),
        ("scenes", "/scenes".to_owned()),
        ("artifacts", format!("/scenes/{scene}/artifacts")),
        ("job", format!("/jobs/{job}")),
        ("stages", format!("/jobs/{job}/stages")),
        // Instances end in any order, so only the events before them.
        ("events", format!("/jobs/{job}/events?page_size=4")),
    ];
    for (name, path) in documents {
        assert_json_snapshot!(name, redacted(server.get(&path).await.json()));
    }
}

#[tokio::test]
async fn a_failed_scene_has_this_document() {
    let server = Server::start(&Script::new(&[("alpha", &[Act::Permanent])])).await;
    let headers = [("content-type", "application/json"), ("prefer", "wait=30")];
    let body = json!({ "text": "a mug", "seed": 7 }).to_string();
    let scene = server.call(Method::POST, "/scenes", &headers, body).await.json();
    assert_json_snapshot!("failed_scene", redacted(scene));
}

#[tokio::test]
async fn a_validated_request_has_this_document() {
    let server = Server::start(&Script::new(&[])).await;
    let valid = server.post("/scenes/validate", json!({ "text": "a mug", "seed": 7 })).await;
    assert_json_snapshot!("validated", redacted(valid.json()));
}

#[tokio::test]
async fn refused_requests_have_these_documents() {
    let server = Server::start(&Script::new(&[])).await;
    let invalid = json!({ "text": "", "seed": 1u64 << 60, "options": { "max_objects": 0 } });
    assert_json_snapshot!("invalid_request", redacted(server.post("/scenes", invalid).await.json()));
    assert_json_snapshot!("invalid_parameter", redacted(server.get("/scenes?page_size=0").await.json()));
    assert_json_snapshot!("unknown_scene", redacted(server.get("/scenes/none").await.json()));
}

/// A refusal of every type that a single request can cause; `problem_documents` has the others.
#[tokio::test]
async fn each_type_of_problem_has_a_document() {
    let server = Server::start(&Script::new(&[])).await;
    let (scene, job) = server.submit("a mug").await;
    server.job_is(&job, "succeeded").await;
    let json = ("content-type", "application/json");
    let (bundle, cancel) = (format!("/scenes/{scene}/bundle"), format!("/jobs/{job}/cancel"));
    type Headers<'a> = &'a [(&'a str, &'a str)];
    let requests: [(&str, Method, &str, Headers<'_>, &str); 9] = [
        ("malformed_request", Method::POST, "/scenes", &[json], "{"),
        ("unknown_field", Method::POST, "/scenes", &[json], r#"{"text": "a mug", "colour": 1}"#),
        ("forbidden", Method::POST, "/scenes", &[json, ("origin", "https://other.example")], "{}"),
        ("not_found", Method::GET, "/jobs/0190a3b0-0000-7000-8000-000000000001", &[], ""),
        ("method_not_allowed", Method::DELETE, "/jobs", &[], ""),
        ("conflict", Method::POST, &cancel, &[], ""),
        ("unsupported_media_type", Method::POST, "/scenes", &[("content-type", "text/plain")], "a mug"),
        ("range_not_satisfiable", Method::GET, &bundle, &[("range", "bytes=99999999-")], ""),
        ("misdirected", Method::GET, "/healthz", &[("host", "rebound.example")], ""),
    ];
    for (name, method, path, headers, body) in requests {
        assert_json_snapshot!(name, redacted(server.call(method, path, headers, body).await.json()));
    }
    let too_large =
        server.post(&cancel.replace("cancel", "retry"), json!({ "from_stage": "a".repeat(1 << 17) })).await;
    assert_json_snapshot!("payload_too_large", redacted(too_large.json()));
    server.call(Method::DELETE, &format!("/scenes/{scene}"), &[], "").await;
    assert_json_snapshot!("gone", redacted(server.get(&bundle).await.json()));
    server.service.shutdown.cancel();
    assert_json_snapshot!("unavailable", redacted(server.get("/readyz").await.json()));
}
