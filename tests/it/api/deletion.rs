//! `DELETE` of datasets, batches and recordings: what answers afterwards, what stays whole, and that all rows and blobs
//! go.

use std::collections::BTreeMap;
use std::path::Path;
use std::time::Duration;

use hyper::Method;
use serde_json::{Value, json};
use sqlx::Connection;
use sqlx::sqlite::{SqliteConnectOptions, SqliteConnection};
use store::retention::RetentionSettings;

use crate::harness::server::{Reply, Server, settings};
use crate::harness::tiny_bundle;

async fn delete(server: &Server, path: &str) -> Reply {
    server.call(Method::DELETE, path, &[], "").await
}

async fn until(server: &Server, path: &str, states: &[&str]) -> Value {
    let reached = async {
        loop {
            let found = server.get(path).await.json();
            if states.contains(&found["state"].as_str().unwrap()) {
                return found;
            }
            tokio::time::sleep(Duration::from_millis(20)).await;
        }
    };
    match tokio::time::timeout(Duration::from_secs(60), reached).await {
        Ok(found) => found,
        Err(_) => panic!("{}", server.get(path).await.json()),
    }
}

fn path_of(reply: &Reply, kind: &str) -> String {
    assert_eq!(reply.status, 202, "{reply:?}");
    format!("/{kind}/{}", reply.json()["id"].as_str().unwrap())
}

/// A finished batch of these texts; its path.
async fn batch(server: &Server, texts: &[String]) -> String {
    let line = |text: &String| {
        json!({ "custom_id": text.replace(' ', "-"), "body": { "text": text, "seed": 1 } }).to_string()
    };
    let lines: Vec<String> = texts.iter().map(line).collect();
    let headers = [("content-type", "application/jsonl")];
    let reply = server.call(Method::POST, "/batches", &headers, lines.join("\n")).await;
    let path = path_of(&reply, "batches");
    until(server, &path, &["finished"]).await;
    path
}

/// A version of a dataset of a batch; its path.
async fn dataset(server: &Server, name: &str, batch: &str) -> String {
    let batch = batch.trim_start_matches("/batches/");
    let body = json!({ "name": name, "batch": batch, "splits": { "all": 1.0 } });
    let path = path_of(&server.post("/datasets", body).await, "datasets");
    until(server, &path, &["finished"]).await;
    path
}

/// A recording of a scene; its path.
async fn recording(server: &Server, scene: &str) -> String {
    let body = json!({ "task": "put the mug on the plate", "count": 1 });
    path_of(&server.post(&format!("{scene}/episodes"), body).await, "episodes")
}

/// A finished scene; its path.
async fn scene(server: &Server, text: &str) -> String {
    let (scene, job) = server.submit(text).await;
    server.job_is(&job, "succeeded").await;
    format!("/scenes/{scene}")
}

fn texts(name: &str, count: usize) -> Vec<String> {
    (0..count).map(|k| format!("a {name} mug number {k}")).collect()
}

#[tokio::test]
async fn what_is_deleted_is_gone() {
    let server = Server::building(tiny_bundle::build(), &settings(&[])).await;
    let batch = batch(&server, &texts("red", 3)).await;
    let dataset = dataset(&server, "mugs", &batch).await;
    let file = server.get(&format!("{dataset}/files")).await.json()["files"][0]["url"].clone();
    let scene = scene(&server, "a mug").await;
    let recording = recording(&server, &scene).await;
    until(&server, &recording, &["failed"]).await;
    let post = async |path: String| server.call(Method::POST, &path, &[], "").await;

    for (path, code, reads, orders, list) in [
        (
            &dataset,
            "dataset_deleted",
            vec!["/files".to_owned(), "/archive".into(), "/files/dataset.json".into()],
            vec!["/verify"],
            "datasets",
        ),
        (
            &batch,
            "batch_deleted",
            vec!["/output".into(), "/errors".into()],
            vec!["/cancel", "/retry"],
            "batches",
        ),
        (
            &recording,
            "episodes_deleted",
            vec!["/files".into(), "/events".into(), "/archives/robomimic".into()],
            vec!["/cancel"],
            "recordings",
        ),
    ] {
        for _ in 0..2 {
            let deleted = delete(&server, path).await;
            assert_eq!(deleted.status, 204, "deleting twice is fine: {deleted:?}");
        }
        assert_eq!(server.get(path).await.problem(), (410, code.to_owned()));
        for part in reads {
            assert_eq!(
                server.get(&format!("{path}{part}")).await.problem(),
                (410, code.to_owned()),
                "{part}"
            );
        }
        for order in orders {
            assert_eq!(post(format!("{path}{order}")).await.problem(), (410, code.to_owned()), "{order}");
        }
        let kind = path.split('/').nth(1).unwrap();
        let listed = server.get(&format!("/{kind}")).await.json();
        assert_eq!(listed[list], json!([]), "{listed}");
        let unknown = format!("/{kind}/0192f3a4-5b6c-7d8e-9fa0-b1c2d3e4f5a6");
        assert_eq!(delete(&server, &unknown).await.problem(), (404, "not_found".into()));
    }
    assert_eq!(server.get(file.as_str().unwrap()).await.problem(), (410, "dataset_deleted".into()));
    let scenes = server.get("/scenes").await.json();
    assert_eq!(scenes["scenes"].as_array().unwrap().len(), 4, "scenes outlive their batch");
    let body = json!({ "name": "mugs", "batch": batch.trim_start_matches("/batches/") });
    let late = server.post("/datasets", body).await;
    assert_eq!((late.status.as_u16(), &late.json()["errors"][0]["pointer"]), (422, &json!("/batch")));
    let other = delete(&server, &format!("{batch}?scenes=perhaps")).await;
    assert_eq!(other.problem(), (400, "invalid_parameter".into()));
}

#[tokio::test]
async fn a_version_outlives_its_batch_its_scenes_and_other_versions() {
    let server = Server::building(tiny_bundle::build(), &settings(&[])).await;
    let (small, large) = (batch(&server, &texts("red", 2)).await, batch(&server, &texts("blue", 3)).await);
    let (first, second) = (dataset(&server, "mugs", &small).await, dataset(&server, "mugs", &large).await);
    for path in [format!("{small}?scenes=delete"), format!("{large}?scenes=delete"), first] {
        assert_eq!(delete(&server, &path).await.status, 204, "{path}");
    }
    assert_eq!(server.get("/scenes").await.json()["scenes"], json!([]));
    sweep(&server).await;
    let verify = server.call(Method::POST, &format!("{second}/verify"), &[], "").await;
    assert_eq!(verify.status, 202);
    let verified = async {
        loop {
            let found = server.get(&second).await.json();
            if found["verification"]["state"] == "finished" {
                return found;
            }
            tokio::time::sleep(Duration::from_millis(20)).await;
        }
    };
    let found = tokio::time::timeout(Duration::from_secs(60), verified).await.expect("is verified");
    assert_eq!(found["verification"]["found"]["intact"], true, "{found}");

    // The number of a version that is gone is not used again, while an earlier one stays.
    let third = dataset(&server, "mugs", &batch(&server, &texts("green", 2)).await).await;
    assert_eq!(delete(&server, &third).await.status, 204);
    let fourth = dataset(&server, "mugs", &batch(&server, &texts("white", 2)).await).await;
    assert_eq!(server.get(&fourth).await.json()["version"], 4);
}

/// Waits until blobs are older than the grace period, and sweeps. Nothing stays after its deletion.
async fn sweep(server: &Server) {
    let settings =
        RetentionSettings { grace_secs: 1, deleted_hours: 0, ..settings(&[]).config.store.retention };
    tokio::time::sleep(Duration::from_millis(1200)).await;
    server.store().sweep(&settings, false).await.expect("sweeps").expect("no backup is under way");
}

/// Number of rows of every table of a data directory, but of the record of changes, which stays.
async fn rows(directory: &Path) -> BTreeMap<String, i64> {
    let options = SqliteConnectOptions::new().filename(directory.join("tabletopgen.sqlite"));
    let mut connection = SqliteConnection::connect_with(&options).await.unwrap();
    let tables: Vec<String> = sqlx::query_scalar(
        "SELECT name FROM sqlite_master WHERE type = 'table' AND name NOT LIKE 'sqlite%' AND name <> 'audit'
         ORDER BY name",
    )
    .fetch_all(&mut connection)
    .await
    .unwrap();
    let mut rows = BTreeMap::new();
    for table in tables {
        let count = sqlx::AssertSqlSafe(format!("SELECT COUNT(*) FROM {table}"));
        rows.insert(table, sqlx::query_scalar(count).fetch_one(&mut connection).await.unwrap());
    }
    rows
}

/// Files with blobs below a folder.
fn blobs(folder: &Path) -> usize {
    let entries = std::fs::read_dir(folder).unwrap().map(Result::unwrap);
    let count = |entry: std::fs::DirEntry| match entry.metadata().unwrap().is_dir() {
        true => blobs(&entry.path()),
        false => usize::from(entry.path().extension().is_none_or(|end| end != "lock")),
    };
    entries.map(count).sum()
}

#[tokio::test]
async fn all_rows_and_blobs_go_with_what_is_deleted() {
    const COUNT: usize = 10;
    let server = Server::building(tiny_bundle::build(), &settings(&[])).await;
    let data = server.directory.path().to_owned();
    let before = (rows(&data).await, blobs(&data.join("blobs")));
    let mut made = Vec::new();
    for k in 0..COUNT {
        let batch = batch(&server, &texts(&format!("batch {k}"), 1)).await;
        made.push(dataset(&server, &format!("set{}", k / 3), &batch).await);
        let scene = scene(&server, &format!("a mug of scene {k}")).await;
        made.extend([recording(&server, &scene).await, scene, format!("{batch}?scenes=delete")]);
    }
    assert!(blobs(&data.join("blobs")) > 4 * COUNT);
    for path in &made {
        assert_eq!(delete(&server, path).await.status, 204, "{path}");
    }
    // Workers stop, and the highest number of a name goes after those below it.
    for _ in 0..3 {
        sweep(&server).await;
    }
    assert_eq!((rows(&data).await, blobs(&data.join("blobs"))), before);
    for path in &made {
        assert_eq!(server.get(path.split('?').next().unwrap()).await.problem(), (404, "not_found".into()));
    }
}
