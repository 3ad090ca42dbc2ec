//! `GET /scenes/{id}/tasks`: refusals; tasks of real bundles are tested with the command line.

use hyper::Method;

use crate::harness::script::Script;
use crate::harness::server::Server;

#[tokio::test]
async fn tasks_are_of_finished_scenes_and_known_robots() {
    let server = Server::start(&Script::new(&[])).await;
    let (scene, job) = server.submit("a mug").await;
    server.job_is(&job, "succeeded").await;
    for (query, expected) in [
        ("?robot=hal", (422, "unknown_robot")),
        ("?count=0", (400, "invalid_parameter")),
        ("?count=51", (400, "invalid_parameter")),
        ("?text=%20", (400, "invalid_parameter")),
        ("?count=many", (400, "invalid_parameter")),
        ("?arms=2", (400, "invalid_parameter")),
        // Proposals are rehearsed, unless the client asks for others.
        ("?count=11", (400, "invalid_parameter")),
        ("?count=11&rehearsed=true", (400, "invalid_parameter")),
        // The scripted bundle has no objects.
        ("?count=11&rehearsed=false", (409, "bundle_unreadable")),
        ("?count=11&text=lift%20the%20mug", (409, "bundle_unreadable")),
        ("", (409, "bundle_unreadable")),
    ] {
        let reply = server.get(&format!("/scenes/{scene}/tasks{query}")).await;
        assert_eq!(reply.problem(), (expected.0, expected.1.into()), "{query}: {reply:?}");
    }
    let unknown = "scn_00000000000000000000000000000000";
    let reply = server.get(&format!("/scenes/{unknown}/tasks")).await;
    assert_eq!(reply.status, 404, "{reply:?}");
    let reply = server.call(Method::POST, &format!("/scenes/{scene}/tasks"), &[], String::new()).await;
    assert_eq!(reply.status, 405, "{reply:?}");
}
