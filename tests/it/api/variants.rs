//! `POST /scenes/{id}/variants`: several scenes from one, each with its own seed.

use std::collections::BTreeSet;

use hyper::Method;
use serde_json::{Value, json};

use crate::harness::script::{Act, Script};
use crate::harness::server::{Reply, Server};

async fn finished(server: &Server) -> String {
    let (scene, job) = server.submit("a mug").await;
    server.job_is(&job, "succeeded").await;
    scene
}

async fn variants(server: &Server, parent: &str, body: Value) -> Reply {
    server.post(&format!("/scenes/{parent}/variants"), body).await
}

async fn children(server: &Server, parent: &str) -> usize {
    let list = server.get(&format!("/scenes?parent={parent}&page_size=200")).await.json();
    list["scenes"].as_array().unwrap().len()
}

#[tokio::test]
async fn variants_become_scenes_with_a_parent_and_seeds_of_their_own() {
    let server = Server::start(&Script::new(&[])).await;
    let parent = finished(&server).await;
    let body = json!({
        "count": 3, "seed": 7, "randomize": { "layout": true, "sizes": 0.2 }, "labels": { "set": "v" },
    });
    let reply = variants(&server, &parent, body).await;
    assert_eq!(reply.status, 202, "{reply:?}");
    let answer = reply.json();
    assert_eq!(
        (&answer["parent"], &answer["seed"], &answer["remaining"]),
        (&json!(parent), &json!(7), &json!(0))
    );
    assert_eq!(answer["randomize"], json!({ "layout": true, "sizes": 0.2 }));
    let scenes = answer["scenes"].as_array().unwrap();
    let seeds: BTreeSet<u64> = scenes.iter().map(|scene| scene["seed"].as_u64().unwrap()).collect();
    assert_eq!((scenes.len(), seeds.len()), (3, 3));
    for made in scenes {
        let id = made["id"].as_str().unwrap();
        let scene = server.get(made["link"].as_str().unwrap()).await.json();
        assert_eq!((&scene["id"], &scene["parent"]), (&json!(id), &json!(parent)));
        assert_eq!((&scene["seed"], &scene["labels"]), (&made["seed"], &json!({ "set": "v" })));
        let input = &scene["request"]["input"];
        assert_eq!((&input["kind"], &input["randomize"]), (&json!("variant"), &answer["randomize"]));
        server.job_is(scene["job"]["id"].as_str().unwrap(), "succeeded").await;
        let lineage = server.get(&format!("/scenes/{id}/lineage")).await.json();
        assert_eq!(lineage["scene"]["randomize"], answer["randomize"], "{lineage}");
        assert_eq!(lineage["ancestors"][0]["id"], json!(parent));
    }
    assert_eq!(children(&server, &parent).await, 3);
}

#[tokio::test]
async fn a_request_without_axes_varies_all_and_validation_makes_nothing() {
    let server = Server::start(&Script::new(&[])).await;
    let parent = finished(&server).await;
    let path = format!("/scenes/{parent}/variants/validate");
    let answer = server.post(&path, json!({ "count": 2, "seed": 1 })).await;
    assert_eq!(answer.status, 200, "{answer:?}");
    let requests = answer.json()["requests"].as_array().unwrap().clone();
    assert_eq!(requests.len(), 2);
    for axis in ["layout", "meshes", "colors", "materials", "table", "light", "camera"] {
        assert_eq!(requests[0]["input"]["randomize"][axis], json!(true), "{axis}");
    }
    assert_eq!(children(&server, &parent).await, 0);
}

#[tokio::test]
async fn the_same_key_names_the_same_variants() {
    let server = Server::start(&Script::new(&[])).await;
    let parent = finished(&server).await;
    let path = format!("/scenes/{parent}/variants");
    let headers = [("content-type", "application/json"), ("idempotency-key", "k1")];
    let body = json!({ "count": 2 }).to_string();
    let first = server.call(Method::POST, &path, &headers, body.clone()).await;
    let second = server.call(Method::POST, &path, &headers, body).await;
    assert_eq!(first.status, 202, "{first:?}");
    assert_eq!(first.json(), second.json());
    assert_eq!(children(&server, &parent).await, 2);
    let other = json!({ "count": 2, "randomize": { "layout": true } }).to_string();
    let reused = server.call(Method::POST, &path, &headers, other).await;
    assert_eq!(reused.problem(), (422, "idempotency_key_reused".into()));
    // The keys of clients are none of those by which variants are kept apart, nor are those of other requests.
    for key in ["k1/0", "k1/1", "variant/0", "k1"] {
        let headers = [("content-type", "application/json"), ("idempotency-key", key)];
        let scene = json!({ "text": "a bowl" }).to_string();
        let reply = server.call(Method::POST, "/scenes", &headers, scene).await;
        assert_eq!(reply.status, 202, "{key}: {reply:?}");
    }
    assert_eq!(children(&server, &parent).await, 2);
}

#[tokio::test]
async fn a_full_queue_takes_some_variants_and_the_same_key_goes_on() {
    let limits = [("queue.max_jobs", "4"), ("store.limits.waiting_jobs", "4"), ("worker.concurrency", "1")];
    let script = Script::new(&[]);
    let server = Server::with(&script, &limits).await;
    let parent = finished(&server).await;
    script.next("omega", Act::Wait);
    let path = format!("/scenes/{parent}/variants");
    let headers = [("content-type", "application/json"), ("idempotency-key", "k2")];
    let body = json!({ "count": 9 }).to_string();
    let first = server.call(Method::POST, &path, &headers, body.clone()).await;
    assert_eq!(first.status, 202, "{first:?}");
    let made = first.json()["scenes"].as_array().unwrap().len();
    assert!((1..9).contains(&made), "{made}");
    assert_eq!(first.json()["remaining"], json!(9 - made));
    assert!(!first.header("retry-after").is_empty());
    script.open_gate();
    for _ in 0..200 {
        let next = server.call(Method::POST, &path, &headers, body.clone()).await;
        if next.status == 202 && next.json()["remaining"] == json!(0) {
            assert_eq!(
                next.json()["scenes"].as_array().unwrap()[..made],
                first.json()["scenes"].as_array().unwrap()[..]
            );
            assert_eq!(children(&server, &parent).await, 9);
            return;
        }
        tokio::time::sleep(std::time::Duration::from_millis(100)).await;
    }
    panic!("the queue never took all variants");
}

#[tokio::test]
async fn bad_requests_are_refused_with_pointers() {
    let server = Server::start(&Script::new(&[])).await;
    let parent = finished(&server).await;
    for (body, pointer) in [
        (json!({ "count": 0 }), "/count"),
        (json!({ "count": 1001 }), "/count"),
        (json!({ "count": -1 }), "/count"),
        (json!({ "randomize": { "sizes": 0.5 } }), "/randomize/sizes"),
        (json!({ "randomize": { "weather": true } }), "/randomize/weather"),
        (json!({ "randomize": "all" }), "/randomize"),
        (json!({ "number": 3 }), "/number"),
        (json!({ "seed": 1_u64 << 53 }), "/seed"),
    ] {
        let reply = variants(&server, &parent, body.clone()).await;
        assert_eq!(reply.problem().0, 422, "{body}: {reply:?}");
        let pointers: Vec<Value> =
            reply.json()["errors"].as_array().unwrap().iter().map(|error| error["pointer"].clone()).collect();
        assert_eq!(pointers, [json!(pointer)], "{body}");
    }
    assert_eq!(children(&server, &parent).await, 0);
}
