//! Deleted scenes free their space in a running server; quotas refuse what would exceed them.

use std::path::Path;
use std::time::Duration;

use hyper::Method;
use serde_json::json;

use crate::harness::script::Script;
use crate::harness::server::Server;

/// Files below a folder, and their bytes.
fn volume(folder: &Path) -> (u64, u64) {
    let mut sum = (0, 0);
    for entry in std::fs::read_dir(folder).unwrap() {
        let entry = entry.unwrap();
        let (files, bytes) = match entry.metadata().unwrap() {
            meta if meta.is_dir() => volume(&entry.path()),
            meta => (1, meta.len()),
        };
        sum = (sum.0 + files, sum.1 + bytes);
    }
    sum
}

#[tokio::test]
async fn deleted_scenes_free_their_space() {
    let set = [
        ("store.retention.sweep_interval_secs", "1"),
        ("store.retention.grace_secs", "2"),
        ("store.retention.deleted_hours", "0"),
        ("worker.stage_timeout_secs", "1"),
    ];
    let server = Server::with(&Script::new(&[]), &set).await;
    let blobs = server.directory.path().join("blobs");
    let before = volume(&blobs);
    let mut scenes = Vec::new();
    for text in ["a mug", "a bowl", "a plate"] {
        let (scene, job) = server.submit(text).await;
        server.job_is(&job, "succeeded").await;
        scenes.push(scene);
    }
    assert!(volume(&blobs).0 > before.0 + 9, "{:?}", volume(&blobs));
    for scene in &scenes {
        let deleted = server.call(Method::DELETE, &format!("/scenes/{scene}"), &[], "").await;
        assert_eq!(deleted.status, 204);
    }
    let freed = async {
        // One file is the lock of the sweep.
        while volume(&blobs).0 > before.0 + 1 {
            tokio::time::sleep(Duration::from_millis(100)).await;
        }
    };
    tokio::time::timeout(Duration::from_secs(30), freed).await.expect("the sweep frees the blobs");
    let purged = async {
        while server.get(&format!("/scenes/{}", scenes[0])).await.status != 404 {
            tokio::time::sleep(Duration::from_millis(100)).await;
        }
    };
    tokio::time::timeout(Duration::from_secs(30), purged).await.expect("the last rows go too");
}

#[tokio::test]
async fn a_tenant_beyond_its_quota_is_refused() {
    let server = Server::start(&Script::new(&[])).await;
    let (_, job) = server.submit("a mug").await;
    server.job_is(&job, "succeeded").await;
    let directory = server.stop().await;
    let quota = [("store.limits.bytes", "1")];
    let server = Server::on(directory, &Script::new(&[]), &quota).await;
    let refused = server.post("/scenes", json!({ "text": "a bowl" })).await;
    assert_eq!(refused.problem(), (507, "quota_exceeded".into()));
    assert_eq!(refused.json()["limit"]["name"], "store.limits.bytes");
    assert_eq!((&refused.json()["limit"]["max"], refused.header("retry-after")), (&json!(1.0), "30"));
    let retry = server.post(&format!("/jobs/{job}/retry"), json!({})).await;
    assert_eq!(retry.problem(), (507, "quota_exceeded".into()), "every kind of work");
    // Checking a request and reading go on.
    assert_eq!(server.post("/scenes/validate", json!({ "text": "a bowl" })).await.status, 200);
    assert_eq!(server.get("/readyz").await.status, 200);
}
