//! `POST /scenes/{id}/executions`: refusals; executions in real bundles are tested with the command line.

use hyper::Method;
use serde_json::json;

use crate::harness::script::Script;
use crate::harness::server::Server;

#[tokio::test]
async fn executions_are_of_finished_scenes_and_of_one_task() {
    let server = Server::start(&Script::new(&[])).await;
    let (scene, job) = server.submit("a mug").await;
    server.job_is(&job, "succeeded").await;
    let path = format!("/scenes/{scene}/executions");
    for (query, body, expected) in [
        ("", r#"{"text": "lift the mug", "robot": "hal"}"#, (422, "unknown_robot")),
        ("", r#"{"robot": "panda"}"#, (422, "invalid_body")),
        ("", r#"{"text": " "}"#, (422, "invalid_body")),
        ("", r#"{"text": "lift the mug", "video": true}"#, (422, "invalid_body")),
        ("", r#"{"text": "lift the mug", "arms": 2}"#, (422, "invalid_body")),
        ("", r#"{"text": "lift the mug", "base": {"x_m": -0.5, "y_m": 0}}"#, (422, "invalid_body")),
        (
            "",
            r#"{"text": "lift the mug", "base": {"x_m": 99, "y_m": 0, "z_m": 0, "yaw_rad": 0}}"#,
            (422, "invalid_body"),
        ),
        ("?format=tar", r#"{"text": "lift the mug"}"#, (400, "invalid_parameter")),
        // The scripted bundle has no objects.
        ("?format=zip", r#"{"text": "lift the mug", "video": true}"#, (409, "bundle_unreadable")),
    ] {
        let json = [("content-type", "application/json"), ("prefer", "wait=30")];
        let reply = server.call(Method::POST, &format!("{path}{query}"), &json, body.to_owned()).await;
        assert_eq!(reply.problem(), (expected.0, expected.1.into()), "{query} {body}: {reply:?}");
    }
    let reply = server.call(Method::POST, &path, &[], "{}".to_owned()).await;
    assert_eq!(reply.status, 415, "{reply:?}");
    let reply = server.get(&path).await;
    assert_eq!(reply.status, 405, "{reply:?}");
}

#[tokio::test]
async fn an_execution_is_a_job_with_an_answer_of_its_own() {
    let server = Server::start(&Script::new(&[])).await;
    let (scene, job) = server.submit("a mug").await;
    server.job_is(&job, "succeeded").await;
    let json = [("content-type", "application/json")];
    let body = r#"{"text": "lift the mug", "seed": 3}"#.to_owned();
    let reply = server.call(Method::POST, &format!("/scenes/{scene}/executions"), &json, body).await;
    assert_eq!(reply.status, 202, "{reply:?}");
    let accepted = reply.json();
    assert_eq!((&accepted["kind"], &accepted["scene_id"]), (&json!("execute_task"), &json!(scene)));
    assert_eq!(accepted["links"]["scene"], format!("/scenes/{scene}"));
    let id = accepted["id"].as_str().unwrap().to_owned();
    assert_eq!(accepted["links"]["execution"], format!("/executions/{id}"));
    // The scripted bundle has no objects, which is the answer after the job has failed.
    server.job_is(&id, "failed").await;
    let reply = server.get(&format!("/executions/{id}")).await;
    assert_eq!(reply.problem(), (409, "bundle_unreadable".into()), "{reply:?}");
    let listed = server.get("/jobs?kind=execute_task").await.json();
    assert_eq!((&listed["jobs"][0]["id"], &listed["jobs"][0]["scene_id"]), (&json!(id), &json!(scene)));
    assert_eq!(listed["jobs"][0]["failure"]["code"], "bundle_unreadable");
    let reply = server.get(&format!("/executions/{job}")).await;
    assert_eq!(reply.problem(), (404, "not_found".into()), "another job is no execution: {reply:?}");
    let reply = server.call(Method::POST, &format!("/jobs/{id}/retry"), &[], String::new()).await;
    assert_eq!(reply.problem(), (409, "nothing_to_retry".into()), "{reply:?}");
}
