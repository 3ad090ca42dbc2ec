//! `PATCH /scenes/{id}`: labels by a merge patch, with and without `If-Match`.

use hyper::Method;
use serde_json::{Value, json};

use crate::harness::script::Script;
use crate::harness::server::{Reply, Server};

const MERGE_PATCH: (&str, &str) = ("content-type", "application/merge-patch+json");

/// A finished scene with two labels; its path.
async fn labeled(server: &Server) -> String {
    let body = json!({ "text": "a mug", "seed": 7, "labels": { "split": "test", "room": "k" } });
    let scene = server.post("/scenes", body).await.json();
    server.job_is(scene["job"]["id"].as_str().unwrap(), "succeeded").await;
    format!("/scenes/{}", scene["id"].as_str().unwrap())
}

async fn patch(server: &Server, path: &str, headers: &[(&str, &str)], body: &Value) -> Reply {
    server.call(Method::PATCH, path, &[headers, &[MERGE_PATCH]].concat(), body.to_string()).await
}

#[tokio::test]
async fn labels_change_by_a_merge_patch() {
    let server = Server::start(&Script::new(&[])).await;
    let path = labeled(&server).await;
    let count = async |label: &str| {
        let listed = server.get(&format!("/scenes?label={label}")).await.json();
        listed["scenes"].as_array().unwrap().len()
    };
    let change = json!({ "labels": { "split": "train", "room": null, "absent": null, "seen": "" } });
    let changed = patch(&server, &path, &[], &change).await;
    assert_eq!(changed.status, 200, "{changed:?}");
    assert_eq!(changed.json()["labels"], json!({ "seen": "", "split": "train" }));
    assert_eq!(changed.json(), server.get(&path).await.json());
    assert_eq!((count("split:train").await, count("split:test").await, count("room:k").await), (1, 0, 0));
    let same = patch(&server, &path, &[], &change).await;
    assert_eq!(
        same.json(),
        changed.json(),
        "the same again changes nothing, nor the time of the last change"
    );
    assert_eq!(patch(&server, &path, &[], &json!({})).await.json(), changed.json());
    let none = patch(&server, &path, &[], &json!({ "labels": null })).await;
    assert_eq!(none.json()["labels"], json!({}));
    assert_eq!(count("split:train").await, 0);
}

#[tokio::test]
async fn labels_that_no_scene_may_have_are_refused_before_a_precondition() {
    let server = Server::start(&Script::new(&[])).await;
    let path = labeled(&server).await;
    let refused = patch(&server, &path, &[("if-match", "\"other\"")], &json!({ "labels": { "": "" } })).await;
    assert_eq!(refused.status, 422, "{refused:?}");
}

#[tokio::test]
async fn a_change_for_another_state_is_refused() {
    let server = Server::start(&Script::new(&[])).await;
    let path = labeled(&server).await;
    let read = server.get(&path).await;
    let tag = read.header("etag");
    let change = |split: &str| json!({ "labels": { "split": split } });
    let changed = patch(&server, &path, &[("if-match", tag)], &change("train")).await;
    assert_eq!(changed.status, 200, "{changed:?}");
    assert_ne!(changed.header("etag"), tag);
    let late = patch(&server, &path, &[("if-match", tag)], &change("validation")).await;
    assert_eq!(late.problem(), (412, "scene_changed".into()));
    let weak = format!("W/{}", changed.header("etag"));
    let refused = patch(&server, &path, &[("if-match", weak.as_str())], &change("validation")).await;
    assert_eq!(refused.status, 412, "weak tags match nothing");
    assert_eq!(server.get(&path).await.json()["labels"]["split"], "train");
    let tags = format!("{tag}, {}", changed.header("etag"));
    let either = patch(&server, &path, &[("if-match", tags.as_str())], &change("validation")).await;
    assert_eq!((either.status.as_u16(), &either.json()["labels"]["split"]), (200, &json!("validation")));
    let any = patch(&server, &path, &[("if-match", "*")], &change("test")).await;
    assert_eq!(any.status, 200);
}

#[tokio::test]
async fn patches_that_will_not_do_are_refused() {
    let server = Server::start(&Script::new(&[])).await;
    let path = labeled(&server).await;
    for (body, pointer) in [
        (json!({ "labels": { "split": 1 } }), "/labels/split"),
        (json!({ "labels": { "split": { "a": "b" } } }), "/labels/split"),
        (json!({ "labels": "train" }), "/labels"),
        (json!({ "labels": { "a key": "v" } }), "/labels"),
        (json!({ "labels": { "k": "a\u{7f}" } }), "/labels/k"),
        (json!({ "state": "ready" }), "/state"),
        (json!([]), ""),
        (json!(null), ""),
    ] {
        let refused = patch(&server, &path, &[], &body).await;
        assert_eq!(refused.problem(), (422, "invalid_body".into()), "{body}");
        assert_eq!(refused.json()["errors"][0]["pointer"], pointer, "{body}: {}", refused.json());
    }
    // 31 more are one too many.
    let many: serde_json::Map<_, _> = (0..31).map(|k| (format!("k{k}"), json!("v"))).collect();
    let refused = patch(&server, &path, &[], &json!({ "labels": many })).await;
    assert_eq!(refused.status, 422);
    let other = server.call(Method::PATCH, &path, &[("content-type", "application/json")], "{}").await;
    assert_eq!(other.problem(), (415, "body_format".into()));
    assert_eq!(other.header("accept-patch"), "application/merge-patch+json");
    assert_eq!(server.get(&path).await.json()["labels"], json!({ "room": "k", "split": "test" }));

    let unknown = "/scenes/0192f3a4-5b6c-7d8e-9fa0-b1c2d3e4f5a6";
    assert_eq!(patch(&server, unknown, &[], &json!({})).await.problem(), (404, "not_found".into()));
    assert_eq!(server.call(Method::DELETE, &path, &[], "").await.status, 204);
    assert_eq!(patch(&server, &path, &[], &json!({})).await.problem(), (410, "scene_deleted".into()));
}
