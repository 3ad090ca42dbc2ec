//! `POST /scenes/{id}/executions`: refusals; executions in real bundles are tested with the command line.

use hyper::Method;

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
        let json = [("content-type", "application/json")];
        let reply = server.call(Method::POST, &format!("{path}{query}"), &json, body.to_owned()).await;
        assert_eq!(reply.problem(), (expected.0, expected.1.into()), "{query} {body}: {reply:?}");
    }
    let reply = server.call(Method::POST, &path, &[], "{}".to_owned()).await;
    assert_eq!(reply.status, 415, "{reply:?}");
    let reply = server.get(&path).await;
    assert_eq!(reply.status, 405, "{reply:?}");
}
