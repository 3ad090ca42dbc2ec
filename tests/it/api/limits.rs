//! Limits of a tenant over HTTP: every refusal names the limit, its value and what is used, and when to ask again.

use std::collections::BTreeMap;
use std::sync::Arc;

use hyper::Method;
use serde_json::{Value, json};

use crate::harness::script::Script;
use crate::harness::server::{Reply, Server};
use scene::TenantId;
use store::scenes::NewScene;

/// A server whose jobs all wait.
async fn without_worker(set: &[(&str, &str)]) -> Server {
    Server::without_worker(Arc::new(tempfile::tempdir().unwrap()), set).await
}

/// Puts work of another tenant into the queue.
async fn submit_as(server: &Server, tenant: &str) {
    let new = NewScene {
        tenant_id: tenant.parse::<TenantId>().unwrap(),
        parent_id: None,
        request: json!({ "seed": 1, "version": 1 }),
        labels: BTreeMap::new(),
        budget_micro_usd: 0,
        idempotency: None,
    };
    server.store().submit(new).await.unwrap();
}

fn assert_refused(reply: &Reply, expected: (u16, &str), limit: Value) {
    assert_eq!(reply.problem(), (expected.0, expected.1.to_owned()), "{reply:?}");
    let document = reply.json();
    assert_eq!(document["limit"], limit, "{document}");
    let (max, detail) = (&limit["max"], document["detail"].as_str().unwrap());
    assert!(detail.contains(&max.as_f64().unwrap().to_string()), "{detail} names {max}");
    let seconds: u64 = reply.header("retry-after").parse().unwrap();
    assert!((1..=60).contains(&seconds), "{seconds}");
}

#[tokio::test]
async fn waiting_work_of_every_kind_is_limited_for_its_tenant_alone() {
    let server = without_worker(&[("store.limits.waiting_jobs", "3")]).await;
    for _ in 0..5 {
        submit_as(&server, "other").await;
    }
    let (_, job) = server.submit("a mug").await;
    server.submit("a bowl").await;
    let dataset = json!({ "name": "mugs", "label": "set:a" });
    assert_eq!(server.post("/datasets", dataset.clone()).await.status, 202);
    let limit = json!({ "name": "store.limits.waiting_jobs", "max": 3.0, "used": 3.0 });
    let scene = server.post("/scenes", json!({ "text": "a plate" })).await;
    assert_refused(&scene, (429, "queue_full"), limit.clone());
    assert_refused(&server.post("/datasets", dataset).await, (429, "queue_full"), limit);
    // A cancelled job makes room, which its retry takes; then there is none for others.
    let cancelled = server.call(Method::POST, &format!("/jobs/{job}/cancel"), &[], "").await;
    assert_eq!(cancelled.status, 202);
    assert_eq!(server.post(&format!("/jobs/{job}/retry"), json!({})).await.status, 202);
    assert_eq!(server.post("/scenes", json!({ "text": "a plate" })).await.status, 429);
    let metrics = server.get("/metrics").await;
    let metrics = std::str::from_utf8(&metrics.body).unwrap();
    assert!(
        metrics.contains(r#"tabletopgen_limits_refused_total{limit="store.limits.waiting_jobs"}"#),
        "{metrics}"
    );
}

#[tokio::test]
async fn submissions_of_a_minute_are_limited_and_repeated_keys_are_answered() {
    let server = without_worker(&[("store.limits.submissions_per_minute", "3")]).await;
    let send = async |key: &str| {
        let headers = [("content-type", "application/json"), ("idempotency-key", key)];
        server.call(Method::POST, "/scenes", &headers, json!({ "text": "a mug" }).to_string()).await
    };
    let first = send("k1").await.json();
    for key in ["k2", "k3"] {
        assert_eq!(send(key).await.status, 202);
    }
    let limit = json!({ "name": "store.limits.submissions_per_minute", "max": 3.0, "used": 3.0 });
    assert_refused(&send("k4").await, (429, "rate_limit"), limit.clone());
    let again = send("k1").await;
    assert_eq!((again.status.as_u16(), &again.json()["id"]), (202, &first["id"]));
    let headers = [("content-type", "application/jsonl")];
    let line = json!({ "custom_id": "a", "body": { "text": "a mug" } }).to_string();
    let batch = server.call(Method::POST, "/batches", &headers, line).await;
    assert_refused(&batch, (429, "rate_limit"), limit);
    assert_eq!(server.get("/batches").await.json()["batches"], json!([]), "nothing of it stays");
}

#[tokio::test]
async fn requests_of_batches_are_limited_before_they_have_rows() {
    let server = without_worker(&[("store.limits.batch_requests", "2500")]).await;
    let recipe = |count: u64| json!({ "templates": ["a mug"], "seeds": { "first": 0, "count": count } });
    assert_eq!(server.post("/batches", recipe(2000)).await.status, 202);
    let limit = json!({ "name": "store.limits.batch_requests", "max": 2500.0, "used": 2000.0 });
    assert_refused(&server.post("/batches", recipe(501)).await, (429, "batch_requests_limit"), limit);
    assert_eq!(server.post("/batches", recipe(500)).await.status, 202);
    assert_eq!(server.get("/batches").await.json()["batches"].as_array().unwrap().len(), 2);
}

#[tokio::test]
async fn a_tenant_runs_as_many_jobs_as_it_may_whatever_the_slots() {
    use crate::harness::script::Act;

    let script = Script::new(&[]);
    for _ in 0..4 {
        script.next("omega", Act::Wait);
    }
    let limits = [("store.limits.running_jobs", "2"), ("worker.concurrency", "4")];
    let server = Server::with(&script, &limits).await;
    for _ in 0..4 {
        server.submit("a mug").await;
    }
    let count = async |state: &str| {
        server.get(&format!("/jobs?state={state}")).await.json()["jobs"].as_array().unwrap().len()
    };
    for _ in 0..200 {
        if count("running").await == 2 {
            break;
        }
        tokio::time::sleep(std::time::Duration::from_millis(10)).await;
    }
    tokio::time::sleep(std::time::Duration::from_millis(200)).await;
    assert_eq!((count("running").await, count("queued").await), (2, 2), "free slots wait for the tenant");
    script.open_gate();
    for _ in 0..500 {
        if count("succeeded").await == 4 {
            return;
        }
        tokio::time::sleep(std::time::Duration::from_millis(20)).await;
    }
    panic!("the others never ran");
}
