//! `/scenes/{id}/episodes` and `/episodes`: the same dataset as the command writes, over a restart; cancellations and
//! refusals.

use std::collections::BTreeMap;
use std::path::Path;
use std::process::Command;
use std::time::Duration;

use datasets::tar::TarReader;
use hyper::Method;
use serde_json::{Value, json};
use tabletopgen::app::{App, pipeline};
use tabletopgen::service;

use crate::harness::script::{Act, Script};
use crate::harness::server::{Server, settings};

const TASK: &str = "put the block on the plate";

async fn until(server: &Server, path: &str, holds: impl Fn(&Value) -> bool) -> Value {
    let reached = async {
        loop {
            let found = server.get(path).await.json();
            if holds(&found) {
                return found;
            }
            tokio::time::sleep(Duration::from_millis(50)).await;
        }
    };
    match tokio::time::timeout(Duration::from_secs(300), reached).await {
        Ok(found) => found,
        Err(_) => panic!("{}", server.get(path).await.json()),
    }
}

fn has_ended(recording: &Value) -> bool {
    ["finished", "failed", "cancelled"].contains(&recording["state"].as_str().unwrap())
}

/// Orders episodes; the path of the recording.
async fn ordered(server: &Server, scene: &str, body: &Value) -> String {
    let reply = server.post(&format!("/scenes/{scene}/episodes"), body.clone()).await;
    assert_eq!(reply.status, 202, "{reply:?}");
    let path = format!("/episodes/{}", reply.json()["id"].as_str().unwrap());
    assert_eq!(reply.header("location"), path);
    path
}

/// Every file below a folder by its path.
fn files(folder: &Path, path: &str, found: &mut BTreeMap<String, Vec<u8>>) {
    for entry in folder.read_dir().unwrap() {
        let place = entry.unwrap().path();
        let name = place.file_name().unwrap().to_str().unwrap();
        let path = if path.is_empty() { name.to_owned() } else { format!("{path}/{name}") };
        if place.is_dir() {
            files(&place, &path, found);
        } else {
            found.insert(path, std::fs::read(&place).unwrap());
        }
    }
}

/// Files that the command writes for the bundle in `at`.
fn commanded(at: &Path) -> BTreeMap<String, Vec<u8>> {
    let done = Command::new(env!("CARGO_BIN_EXE_tabletopgen"))
        .args(["episodes", "--bundle", "scene.zip", "--task", TASK, "--count", "2", "--cameras", "front"])
        .args(["--size", "32", "--fps", "5", "--format", "lerobot-v2.1,parquet-png", "--out", "whole"])
        .current_dir(at)
        .output()
        .unwrap();
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    let mut found = BTreeMap::new();
    files(&at.join("whole"), "", &mut found);
    found
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn episodes_over_a_restart_are_those_of_the_command() {
    let resolved = settings(&[("worker.lease_secs", "5"), ("worker.heartbeat_secs", "1")]);
    let server = Server::building(pipeline::build_pipeline(&resolved).unwrap(), &resolved).await;
    let text = json!({ "text": "A table with a block and a plate", "seed": 3 });
    let scene = server.post("/scenes", text).await.json();
    let job = server.job_ends(scene["job"]["id"].as_str().unwrap(), Duration::from_secs(240)).await;
    assert_eq!(job["state"], "succeeded", "{job}");
    let scene = scene["id"].as_str().unwrap();
    let bundle = server.get(&format!("/scenes/{scene}/bundle")).await;

    let order = json!({
        "title": "whole", "task": TASK, "count": 2, "formats": ["parquet-png", "lerobot-v2.1"],
        "record": { "cameras": ["front"], "size_px": 32, "fps": 5 },
    });
    let path = ordered(&server, scene, &order).await;
    let made =
        |count: u64| move |recording: &Value| recording["progress"]["attempts"].as_u64() >= Some(count);
    until(&server, &path, made(1)).await;
    let id = path.trim_start_matches("/episodes/").parse().unwrap();
    let before = server.store().kept_attempts(&id).await.unwrap();
    let home = server.stop().await;
    let build = pipeline::build_pipeline(&resolved).unwrap();
    let service = service::start(&App::new(&resolved), home.path(), build).await.unwrap();
    let server = Server::serving(home, service);
    let after = server.store().kept_attempts(&id).await.unwrap();
    assert_eq!(after[..before.len()], before, "attempts that were made are not made again");

    let recording = until(&server, &path, has_ended).await;
    assert_eq!(recording["state"], "finished", "{recording}");
    assert_eq!(recording["dataset"]["episodes"], 2, "{recording}");
    assert_eq!(server.store().kept_attempts(&id).await.unwrap(), [], "attempts are dropped");
    let events = server.get(&format!("{path}/events?page_size=200")).await.json();
    let events = events["events"].as_array().unwrap();
    let kind = |place: usize| events[place]["kind"].as_str().unwrap();
    assert_eq!((kind(0), kind(1), kind(events.len() - 1)), ("queued", "running", "finished"));
    let attempts = events.iter().filter(|event| event["kind"] == "attempt").count();
    assert_eq!(recording["progress"]["attempts"], attempts, "over the restart, too: {events:?}");
    let left = server.directory.path().join("episodes");
    let removed = async {
        while left.read_dir().map_or(0, Iterator::count) > 0 {
            tokio::time::sleep(Duration::from_millis(10)).await;
        }
    };
    tokio::time::timeout(Duration::from_secs(20), removed).await.expect("work folders are removed");

    let at = tempfile::tempdir().unwrap();
    std::fs::write(at.path().join("scene.zip"), &bundle.body).unwrap();
    let expected = commanded(at.path());
    let mut listed = Vec::new();
    let mut page = server.get(&format!("{path}/files?page_size=7")).await.json();
    loop {
        listed.extend(page["files"].as_array().unwrap().clone());
        let Some(token) = page["next_page_token"].as_str() else { break };
        page = server.get(&format!("{path}/files?page_size=7&page_token={token}")).await.json();
    }
    let mut paths: Vec<&str> = listed.iter().map(|file| file["path"].as_str().unwrap()).collect();
    paths.sort_unstable();
    assert_eq!(paths, expected.keys().collect::<Vec<_>>());
    for file in &listed {
        let reply = server.get(file["url"].as_str().unwrap()).await;
        let expected = &expected[file["path"].as_str().unwrap()];
        assert!(reply.body == expected, "{file}");
        assert_eq!(reply.header("etag"), format!("\"{}\"", file["sha256"].as_str().unwrap()));
    }
    let largest = listed.iter().max_by_key(|file| file["size"].as_u64()).unwrap();
    let url = largest["url"].as_str().unwrap();
    let part = server.call(Method::GET, url, &[("range", "bytes=100-299")], "").await;
    assert_eq!(part.status, 206);
    assert_eq!(part.body, expected[largest["path"].as_str().unwrap()][100..300]);
    for format in recording["dataset"]["formats"].as_array().unwrap() {
        let url = format["archive"].as_str().unwrap();
        let archive = server.get(url).await.body;
        assert_eq!(Some(archive.len() as u64), format["size"].as_u64());
        let mut reader = TarReader::new(&archive[..]);
        let mut count = 0;
        while let Some(member) = reader.next_member().unwrap() {
            assert!(reader.content(&member).unwrap() == expected[&member.name], "{}", member.name);
            count += 1;
        }
        assert_eq!(Some(count), format["files"].as_u64());
        let rest = server.call(Method::GET, url, &[("range", "bytes=700-")], "").await;
        assert_eq!((rest.status.as_u16(), &rest.body[..]), (206, &archive[700..]));
    }

    // What the robot cannot do is found by the worker.
    let fork = json!({ "task": "put the fork on the plate", "count": 1 });
    let fork = ordered(&server, scene, &fork).await;
    let failed = until(&server, &fork, has_ended).await;
    assert_eq!(failed["state"], "failed", "{failed}");
    assert!(failed["failure"]["message"].as_str().unwrap().contains("fork"), "{failed}");
    assert_eq!(server.get(&format!("{fork}/files")).await.problem(), (409, "episodes_failed".into()));

    // A cancelled recording stops.
    let long =
        ordered(&server, scene, &json!({ "task": TASK, "count": 500, "record": { "cameras": [] } })).await;
    until(&server, &long, made(1)).await;
    let early = server.get(&format!("{long}/files")).await;
    assert_eq!(early.problem(), (409, "episodes_not_ready".into()));
    let cancel = server.call(Method::POST, &format!("{long}/cancel"), &[], "").await;
    assert_eq!((cancel.status.as_u16(), &cancel.json()["state"]), (202, &json!("cancelled")));
    let again = server.call(Method::POST, &format!("{long}/cancel"), &[], "").await;
    assert_eq!(again.problem(), (409, "episodes_already_ended".into()));
    let listed = server.get(&format!("/episodes?scene={scene}&state=cancelled")).await.json();
    assert_eq!(listed["recordings"].as_array().unwrap().len(), 1);
}

#[tokio::test]
async fn orders_that_will_not_do_are_refused() {
    let server = Server::start(&Script::new(&[])).await;
    let (scene, job) = server.submit("a mug").await;
    server.job_is(&job, "succeeded").await;
    let unknown = "0192f3a4-5b6c-7d8e-9fa0-b1c2d3e4f5a6";
    let path = format!("/scenes/{scene}/episodes");
    let good = json!({ "task": TASK, "count": 2 });
    for (body, pointer) in [
        (json!({ "count": 2 }), "/tasks"),
        (json!({ "task": TASK, "count": 0 }), "/count"),
        (json!({ "task": TASK }), "/count"),
        (json!({ "task": " ", "count": 1 }), "/task"),
        (json!({ "task": TASK, "count": 1, "formats": ["rlds"] }), "/formats/0"),
        (json!({ "task": TASK, "count": 1, "record": { "cameras": ["top"] } }), "/record/cameras"),
        (json!({ "task": TASK, "count": 1, "record": { "arms": 2 } }), "/record/arms"),
        (json!({ "task": TASK, "count": 1, "randomize": { "mass": 0.9 } }), "/randomize/mass"),
    ] {
        let reply = server.post(&path, body.clone()).await;
        assert_eq!(reply.problem(), (422, "invalid_body".into()), "{body}");
        assert_eq!(reply.json()["errors"][0]["pointer"], pointer, "{body}: {reply:?}");
    }
    let hal = json!({ "task": TASK, "count": 1, "robot": "hal" });
    assert_eq!(server.post(&path, hal).await.problem(), (422, "unknown_robot".into()));
    let odd = json!({ "task": TASK, "count": 1, "record": { "size_px": 33 } });
    assert_eq!(server.post(&path, odd).await.problem(), (422, "description".into()));
    let text = server.call(Method::POST, &path, &[("content-type", "text/plain")], "x").await;
    assert_eq!(text.problem(), (415, "body_format".into()));
    let none = server.post(&format!("/scenes/{unknown}/episodes"), good.clone()).await;
    assert_eq!(none.problem(), (404, "not_found".into()));
    for path in [format!("/episodes/{unknown}"), format!("/episodes/{unknown}/archives/robomimic")] {
        assert_eq!(server.get(&path).await.problem(), (404, "not_found".into()));
    }
    assert_eq!(server.get("/episodes?state=wild").await.problem(), (400, "invalid_parameter".into()));

    // The script's bundles have no objects, which the worker finds.
    let send = async |body: &Value| {
        let headers = [("content-type", "application/json"), ("idempotency-key", "k1")];
        server.call(Method::POST, &path, &headers, body.to_string()).await
    };
    let first = send(&good).await.json();
    assert_eq!(send(&good).await.json()["id"], first["id"]);
    let other = json!({ "task": TASK, "count": 3 });
    assert_eq!(send(&other).await.problem(), (422, "idempotency_key_reused".into()));
    let failed = until(&server, first["links"]["self"].as_str().unwrap(), has_ended).await;
    assert_eq!(failed["failure"]["code"], "bundle_unreadable", "{failed}");
}

#[tokio::test]
async fn episodes_are_of_finished_scenes() {
    let server = Server::start(&Script::new(&[("alpha", &[Act::Permanent, Act::Wait])])).await;
    let (failed, job) = server.submit("a mug").await;
    server.job_is(&job, "failed").await;
    let (pending, _) = server.submit("a bowl").await;
    for (scene, code) in [(failed, "parent_failed"), (pending, "parent_not_ready")] {
        let order = json!({ "task": TASK, "count": 2 });
        let reply = server.post(&format!("/scenes/{scene}/episodes"), order).await;
        assert_eq!(reply.problem(), (409, code.into()));
    }
}
