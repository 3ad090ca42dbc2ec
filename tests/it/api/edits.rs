//! `POST /scenes/{id}/edits` and `GET /scenes/{id}/lineage`: new scenes made from finished ones.

use hyper::Method;
use serde_json::{Value, json};

use crate::harness::script::{Act, Script};
use crate::harness::server::{Reply, Server};

/// A finished scene; its id.
async fn finished(server: &Server) -> String {
    let (scene, job) = server.submit("a mug").await;
    server.job_is(&job, "succeeded").await;
    scene
}

/// Edits a scene, and waits for the new one; its id.
async fn edited(server: &Server, parent: &str, target: &str) -> String {
    let body = json!({ "operations": [{ "op": "remove", "target": target }] });
    let headers = [("content-type", "application/json"), ("prefer", "wait=20")];
    let reply =
        server.call(Method::POST, &format!("/scenes/{parent}/edits"), &headers, body.to_string()).await;
    assert_eq!(reply.status, 200, "{reply:?}");
    assert_eq!(reply.json()["state"], "ready", "{reply:?}");
    reply.json()["id"].as_str().unwrap().to_owned()
}

async fn edit(server: &Server, parent: &str, body: Value) -> Reply {
    server.post(&format!("/scenes/{parent}/edits"), body).await
}

fn tidy() -> Value {
    json!({ "operations": [{ "op": "tidy" }] })
}

async fn scene_count(server: &Server) -> usize {
    server.get("/scenes?page_size=200").await.json()["scenes"].as_array().unwrap().len()
}

#[tokio::test]
async fn an_edit_becomes_a_scene_with_a_parent() {
    let server = Server::start(&Script::new(&[])).await;
    let parent = finished(&server).await;
    let operations = json!([
        { "op": "move", "target": "the mug", "where": { "relation": "left_of", "target": "laptop_1" } },
        { "op": "add", "object": "a spoon", "where": { "position_m": [0.1, -0.2], "yaw_rad": 0.5 } },
    ]);
    let body = json!({
        "operations": operations, "labels": { "set": "a1" },
        "options": { "budget_usd": 0.5, "set": { "decompose.max_hulls": "24" } },
    });
    let reply = edit(&server, &parent, body).await;
    assert_eq!(reply.status, 202, "{reply:?}");
    let scene = reply.json();
    let id = scene["id"].as_str().unwrap();
    assert_eq!(reply.header("location"), format!("/scenes/{id}"));
    assert_eq!((&scene["parent"], &scene["labels"]), (&json!(parent), &json!({ "set": "a1" })));
    assert!(scene["seed"].as_u64().is_some_and(|seed| seed < 1 << 53), "a seed is drawn and reported");
    let input = &scene["request"]["input"];
    assert_eq!((&input["kind"], &input["operations"]), (&json!("edit"), &operations));
    assert!(input.get("text").is_none(), "{input}");
    // The scripted bundle has this id; its archive is what the edit reads.
    assert_eq!(input["parent"], "5ce9e");
    let bundle = server.get(&format!("/scenes/{parent}/bundle")).await;
    assert_eq!(bundle.header("etag").trim_matches('"'), input["bundle_sha256"].as_str().unwrap());
    assert_eq!(
        scene["request"]["options"],
        json!({ "budget_usd": 0.5, "set": { "decompose.max_hulls": "24" } })
    );
    server.job_is(scene["job"]["id"].as_str().unwrap(), "succeeded").await;

    let children = server.get(&format!("/scenes?parent={parent}")).await.json();
    let children: Vec<&Value> =
        children["scenes"].as_array().unwrap().iter().map(|scene| &scene["id"]).collect();
    assert_eq!(children, [&json!(id)]);
}

#[tokio::test]
async fn a_parent_must_be_there_and_finished() {
    let script = Script::new(&[("alpha", &[Act::Permanent]), ("omega", &[Act::Wait])]);
    let server = Server::start(&script).await;
    for unknown in ["none", "0192f3a4-5b6c-7d8e-9fa0-b1c2d3e4f5a6"] {
        assert_eq!(edit(&server, unknown, tidy()).await.problem(), (404, "not_found".into()), "{unknown}");
        let lineage = server.get(&format!("/scenes/{unknown}/lineage")).await;
        assert_eq!(lineage.problem(), (404, "not_found".into()), "{unknown}");
    }
    let (failed, job) = server.submit("a bowl").await;
    server.job_is(&job, "failed").await;
    assert_eq!(edit(&server, &failed, tidy()).await.problem(), (409, "parent_failed".into()));
    let (pending, job) = server.submit("a mug").await;
    assert_eq!(edit(&server, &pending, tidy()).await.problem(), (409, "parent_not_ready".into()));
    script.open_gate();
    server.job_is(&job, "succeeded").await;
    assert_eq!(edit(&server, &pending, tidy()).await.status, 202);
    server.call(Method::DELETE, &format!("/scenes/{pending}"), &[], "").await;
    assert_eq!(edit(&server, &pending, tidy()).await.problem(), (410, "scene_deleted".into()));
}

#[tokio::test]
async fn a_quarantined_parent_is_edited_only_on_request() {
    let server = Server::start(&Script::quarantining()).await;
    let (parent, job) = server.submit("a mug").await;
    server.job_is(&job, "succeeded").await;
    assert_eq!(edit(&server, &parent, tidy()).await.problem(), (409, "parent_quarantined".into()));
    let mut body = tidy();
    body["allow_quarantined"] = json!(true);
    assert_eq!(edit(&server, &parent, body).await.status, 202);
}

#[tokio::test]
async fn bad_edits_are_refused_with_pointers_and_nothing_is_enqueued() {
    let server = Server::with(&Script::new(&[]), &[("server.max_text_chars", "200")]).await;
    let parent = finished(&server).await;
    let operations = |operation: Value| json!({ "operations": [{ "op": "tidy" }, operation] });
    let with = |name: &str, value: Value| {
        let mut body = tidy();
        body[name] = value;
        body
    };
    for (body, pointer) in [
        (json!({}), ""),
        (json!([]), ""),
        (json!({ "operations": [{ "op": "tidy" }], "text": "tidy the table" }), ""),
        (json!({ "operations": [] }), "/operations"),
        (json!({ "operations": {} }), "/operations"),
        (json!({ "operations": vec![json!({ "op": "tidy" }); 65] }), "/operations"),
        (operations(json!("tidy")), "/operations/1"),
        (operations(json!(["tidy"])), "/operations/1"),
        (operations(json!({ "op": "explode" })), "/operations/1/op"),
        (operations(json!({ "op": "remove" })), "/operations/1"),
        (operations(json!({ "op": "remove", "target": " " })), "/operations/1/target"),
        (operations(json!({ "op": "remove", "target": 5 })), "/operations/1/target"),
        (operations(json!({ "op": "remove", "target": "a", "when": 1 })), "/operations/1/when"),
        (
            operations(json!({ "op": "move", "target": "a", "where": { "relation": "left_of" } })),
            "/operations/1/where/target",
        ),
        (
            operations(
                json!({ "op": "move", "target": "a", "where": { "distance_m": "far", "relation": "at_left" } }),
            ),
            "/operations/1/where/distance_m",
        ),
        (operations(json!({ "op": "add", "object": "a", "where": ["on"] })), "/operations/1/where"),
        (operations(json!({ "op": "add", "object": "a spoon", "count": 33 })), "/operations/1/count"),
        (json!({ "text": "  " }), "/text"),
        (json!({ "text": "!!!" }), "/text"),
        (json!({ "text": "x".repeat(201) }), "/text"),
        (json!({ "text": "a\u{0}b" }), "/text"),
        (json!({ "text": "qwrtz zorgle" }), "/text"),
        (with("seed", json!(-1)), "/seed"),
        (with("seed", json!(1u64 << 53)), "/seed"),
        (with("labels", json!({ "two words": "x" })), "/labels"),
        (with("options", json!([])), "/options"),
        (with("options", json!({ "budget_usd": -1 })), "/options/budget_usd"),
        (with("options", json!({ "max_objects": 5 })), "/options/max_objects"),
        (with("options", json!({ "robot": "hal" })), "/options/robot"),
        (
            with("options", json!({ "set": { "decompose.max_hulls": "0" } })),
            "/options/set/decompose.max_hulls",
        ),
        (with("priority", json!(101)), "/priority"),
        (with("deadline", json!("2001-01-01T00:00:00Z")), "/deadline"),
        (with("image", json!({ "base64": "" })), "/image"),
    ] {
        let shown: String = body.to_string().chars().take(100).collect();
        for path in [format!("/scenes/{parent}/edits"), format!("/scenes/{parent}/edits/validate")] {
            let reply = server.post(&path, body.clone()).await;
            assert_eq!(reply.problem(), (422, "invalid_body".into()), "{shown}: {reply:?}");
            let errors = reply.json()["errors"].clone();
            let pointers: Vec<&str> =
                errors.as_array().unwrap().iter().map(|error| error["pointer"].as_str().unwrap()).collect();
            assert_eq!(pointers, [pointer], "{shown}: {errors}");
        }
    }
    let path = format!("/scenes/{parent}/edits");
    let form = server.call(Method::POST, &path, &[("content-type", "text/plain")], "tidy").await;
    assert_eq!(form.problem(), (415, "body_format".into()));
    let cut =
        server.call(Method::POST, &path, &[("content-type", "application/json")], "{\"operations\": [").await;
    assert_eq!(cut.problem(), (400, "malformed_json".into()));
    assert_eq!(scene_count(&server).await, 1);
}

#[tokio::test]
async fn a_validated_edit_reads_the_bundle_and_is_not_enqueued() {
    let server = Server::start(&Script::new(&[])).await;
    let parent = finished(&server).await;
    let reply = server.post(&format!("/scenes/{parent}/edits/validate"), tidy()).await;
    // The scripted bundle has no objects to predict anything from.
    assert_eq!(reply.problem(), (409, "parent_unreadable".into()), "{reply:?}");
    assert_eq!(scene_count(&server).await, 1);
}

#[tokio::test]
async fn the_same_key_makes_one_edit() {
    let server = Server::start(&Script::new(&[])).await;
    let (parent, other_parent) = (finished(&server).await, finished(&server).await);
    let send = |parent: &str, body: Value| {
        let headers = [("content-type", "application/json"), ("idempotency-key", "k1")];
        let (server, path) = (&server, format!("/scenes/{parent}/edits"));
        async move { server.call(Method::POST, &path, &headers, body.to_string()).await }
    };
    let first = send(&parent, tidy()).await.json();
    let again = send(&parent, json!({ "labels": {}, "operations": [{ "op": "tidy" }] })).await;
    assert_eq!(again.status, 202);
    assert_eq!((&again.json()["id"], &again.json()["seed"]), (&first["id"], &first["seed"]));
    let other_body = send(&parent, json!({ "operations": [{ "op": "clutter", "count": 2 }] })).await;
    assert_eq!(other_body.problem(), (422, "idempotency_key_reused".into()));
    assert_eq!(scene_count(&server).await, 3);
    // Both parents have the same bytes, so the edit is the same but for its parent.
    assert_eq!(send(&other_parent, tidy()).await.problem(), (422, "idempotency_key_reused".into()));
}

#[tokio::test]
async fn a_lineage_leads_to_the_first_scene_and_to_the_children() {
    let server = Server::start(&Script::new(&[])).await;
    let first = finished(&server).await;
    let second = edited(&server, &first, "the mug").await;
    let third = edited(&server, &second, "the bowl").await;
    let ids = |entries: &Value| -> Vec<String> {
        entries.as_array().unwrap().iter().map(|entry| entry["id"].as_str().unwrap().to_owned()).collect()
    };

    let lineage = server.get(&format!("/scenes/{third}/lineage")).await.json();
    assert_eq!(ids(&lineage["ancestors"]), [first.clone(), second.clone()]);
    assert_eq!((&lineage["scene"]["id"], &lineage["scene"]["parent"]), (&json!(third), &json!(second)));
    assert_eq!(lineage["scene"]["operations"], json!([{ "op": "remove", "target": "the bowl" }]));
    let stages = lineage["scene"]["stages"].as_array().unwrap();
    assert_eq!(stages.len(), 4);
    assert!(stages.iter().all(|stage| stage["cached"] == false), "{stages:?}");
    assert_eq!(ids(&lineage["children"]), [] as [String; 0]);
    let root = &lineage["ancestors"][0];
    assert_eq!((&root["text"], &root["operations"]), (&json!("a mug"), &Value::Null));
    assert_eq!((&root["state"], &root["verdict"]), (&json!("ready"), &json!("pass")));
    assert!(root.get("stages").is_none(), "{root}");

    server.call(Method::DELETE, &format!("/scenes/{first}"), &[], "").await;
    let lineage = server.get(&format!("/scenes/{second}/lineage")).await.json();
    assert_eq!((ids(&lineage["ancestors"]), ids(&lineage["children"])), (vec![first.clone()], vec![third]));
    assert_eq!(lineage["ancestors"][0]["state"], "deleted");
    assert_eq!(
        server.get(&format!("/scenes/{first}/lineage")).await.problem(),
        (410, "scene_deleted".into())
    );
}
