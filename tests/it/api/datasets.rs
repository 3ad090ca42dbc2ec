//! `/datasets`: freezing scenes of the server, downloads of a version, verification.

use std::collections::BTreeMap;
use std::time::Duration;

use datasets::tar::TarReader;
use hyper::Method;
use serde_json::{Value, json};

use crate::harness::script::Script;
use crate::harness::server::{Reply, Server, settings};
use crate::harness::tiny_bundle;

async fn server() -> Server {
    Server::building(tiny_bundle::build(), &settings(&[])).await
}

/// Makes a batch of these texts; its id.
async fn made(server: &Server, texts: &[&str]) -> String {
    let line = |(k, text): (usize, &&str)| {
        let body =
            json!({ "text": text, "seed": 1, "labels": { "set": "a1", "parity": (k % 2).to_string() } });
        json!({ "custom_id": format!("r{k}"), "body": body }).to_string()
    };
    let lines: Vec<String> = texts.iter().enumerate().map(line).collect();
    let headers = [("content-type", "application/jsonl")];
    let reply = server.call(Method::POST, "/batches", &headers, lines.join("\n")).await;
    let id = reply.json()["id"].as_str().unwrap().to_owned();
    until(server, &format!("/batches/{id}"), |batch| batch["state"] == "finished").await;
    id
}

async fn until(server: &Server, path: &str, holds: impl Fn(&Value) -> bool) -> Value {
    let reached = async {
        loop {
            let found = server.get(path).await.json();
            if holds(&found) {
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

async fn submit(server: &Server, body: Value) -> Reply {
    server.post("/datasets", body).await
}

/// Freezes a dataset, and waits until that has ended.
async fn frozen(server: &Server, body: Value) -> Value {
    let reply = submit(server, body).await;
    assert_eq!(reply.status, 202, "{reply:?}");
    let path = format!("/datasets/{}", reply.json()["id"].as_str().unwrap());
    assert_eq!(reply.header("location"), path);
    until(server, &path, |dataset| ["finished", "failed"].contains(&dataset["state"].as_str().unwrap())).await
}

const TEXTS: [&str; 6] =
    ["a red mug", "a blue mug", "a green mug", "a white mug", "a quarantine mug", "a black mug"];

#[tokio::test]
async fn the_scenes_of_a_batch_become_a_version() {
    let server = server().await;
    let batch = made(&server, &TEXTS).await;
    let body = json!({
        "name": "mugs", "batch": batch, "splits": { "train": 0.6, "test": 0.4 }, "seed": 7, "shard_scenes": 2,
    });
    let dataset = frozen(&server, body.clone()).await;
    assert_eq!((&dataset["state"], &dataset["version"]), (&json!("finished"), &json!(1)), "{dataset}");
    let counts = &dataset["summary"]["counts"];
    assert_eq!((&counts["scenes"], &counts["splits"]), (&json!(5), &json!({ "train": 3, "test": 2 })));
    let selection = &dataset["summary"]["selection"];
    assert_eq!((&selection["requested"], &selection["left_out"]), (&json!(6), &json!({ "verdict": 1 })));

    let files = server.get(dataset["links"]["files"].as_str().unwrap()).await.json();
    let paths: Vec<&str> =
        files["files"].as_array().unwrap().iter().map(|file| file["path"].as_str().unwrap()).collect();
    let expected = [
        "LICENSES.md",
        "dataset.json",
        "shards/test-000000.tar",
        "shards/train-000000.tar",
        "shards/train-000001.tar",
        "statistics.html",
        "statistics.json",
    ];
    assert_eq!(paths, expected);
    let manifest = server.get(dataset["links"]["manifest"].as_str().unwrap()).await.json();
    assert_eq!((&manifest["digest"], &manifest["name"]), (&dataset["digest"], &json!("mugs")));
    let names: Vec<&Value> =
        manifest["scenes"].as_array().unwrap().iter().map(|scene| &scene["custom_id"]).collect();
    assert!(names.contains(&&json!("r0")) && !names.contains(&&json!("r4")), "{names:?}");
    let statistics = server.get(dataset["links"]["statistics"].as_str().unwrap()).await.json();
    assert_eq!((&statistics["scenes"], &statistics["objects"]), (&json!(5), &json!(5)));
    let page = server.get(dataset["links"]["statistics_page"].as_str().unwrap()).await;
    assert!(page.header("content-type").starts_with("text/html"), "{page:?}");

    // The same again is no new version; without the quarantined scene's condition it is one.
    let again = frozen(&server, body.clone()).await;
    assert_eq!((&again["version"], &again["summary"]["unchanged"]), (&json!(1), &json!(true)));
    assert_eq!(server.get(again["links"]["manifest"].as_str().unwrap()).await.json(), manifest);
    let mut wider = body;
    wider["filter"] = json!({ "verdict": "any" });
    let next = frozen(&server, wider).await;
    assert_eq!((&next["version"], &next["summary"]["counts"]["scenes"]), (&json!(2), &json!(6)));
    let changes = &next["summary"]["changes"];
    assert_eq!((changes["added"].as_array().unwrap().len(), &changes["moved"]), (1, &json!([])));
    let listed = server.get("/datasets?name=mugs&state=finished").await.json();
    let versions: Vec<&Value> =
        listed["datasets"].as_array().unwrap().iter().map(|row| &row["version"]).collect();
    assert_eq!(versions, [&json!(2), &json!(1), &json!(1)]);
    assert_eq!(server.get("/datasets?name=jugs").await.json()["datasets"], json!([]));
    let left = server.directory.path().join("datasets");
    for _ in 0..500 {
        if left.read_dir().map_or(0, Iterator::count) == 0 {
            return;
        }
        tokio::time::sleep(Duration::from_millis(10)).await;
    }
    panic!("work folders are removed");
}

#[tokio::test]
async fn splits_that_would_be_empty_are_refused() {
    let server = server().await;
    made(&server, &TEXTS[..2]).await;
    let scenes = server.get("/scenes?state=ready").await.json();
    let ids: Vec<&Value> = scenes["scenes"].as_array().unwrap().iter().map(|scene| &scene["id"]).collect();
    // Two scenes never fill three splits, which the request shows.
    let refused = submit(&server, json!({ "name": "mugs", "scenes": ids })).await;
    assert_eq!(refused.status, 422, "{refused:?}");
    let error = &refused.json()["errors"][0];
    assert_eq!(error["pointer"], "/splits");
    assert!(error["detail"].as_str().unwrap().contains("scenes: 2, groups: 2"), "{error}");
    // A label does not show it; the freeze fails, for the same reason.
    let failed = frozen(&server, json!({ "name": "mugs", "label": "set:a1" })).await;
    assert_eq!((&failed["state"], &failed["failure"]["code"]), (&json!("failed"), &json!("empty_split")));
    let message = failed["failure"]["message"].as_str().unwrap();
    assert!(message.contains("scenes: 2, groups: 2") && message.contains("all=1"), "{message}");
}

#[tokio::test]
async fn labels_and_ids_name_scenes() {
    let server = server().await;
    made(&server, &TEXTS).await;
    let by_label =
        frozen(&server, json!({ "name": "even", "label": "parity:0", "splits": { "all": 1.0 } })).await;
    assert_eq!(by_label["summary"]["counts"]["scenes"], 2, "{by_label}");
    let filter = json!({ "verdict": "any", "labels": { "parity": "1" } });
    let filtered = frozen(
        &server,
        json!({ "name": "odd", "label": "set:a1", "splits": { "all": 1 }, "filter": filter }),
    )
    .await;
    assert_eq!(filtered["summary"]["counts"]["scenes"], 3, "{filtered}");
    let scenes = server.get("/scenes?state=ready").await.json();
    let ids: Vec<&Value> =
        scenes["scenes"].as_array().unwrap().iter().take(2).map(|scene| &scene["id"]).collect();
    let named = frozen(&server, json!({ "name": "two", "scenes": ids, "splits": { "all": 1.0 } })).await;
    assert_eq!(named["summary"]["counts"]["scenes"], 2, "{named}");
    let none = frozen(&server, json!({ "name": "none", "label": "set:b2" })).await;
    assert_eq!(
        (&none["state"], &none["failure"]["code"]),
        (&json!("failed"), &json!("no_dataset")),
        "{none}"
    );
    let files = server.get(none["links"]["files"].as_str().unwrap()).await;
    assert_eq!(files.problem(), (409, "dataset_failed".into()));
}

#[tokio::test]
async fn shards_are_sent_in_ranges_with_their_digest_as_etag() {
    let server = server().await;
    let batch = made(&server, &TEXTS[..3]).await;
    let dataset =
        frozen(&server, json!({ "name": "mugs", "batch": batch, "splits": { "train": 1.0 } })).await;
    let files = server.get(dataset["links"]["files"].as_str().unwrap()).await.json();
    let shard =
        files["files"].as_array().unwrap().iter().find(|file| file["media_type"] == "application/x-tar");
    let (url, size) = (shard.unwrap()["url"].as_str().unwrap(), shard.unwrap()["size"].as_u64().unwrap());
    let whole = server.get(url).await;
    assert_eq!(whole.body.len() as u64, size);
    assert_eq!(whole.header("etag"), format!("\"{}\"", shard.unwrap()["sha256"].as_str().unwrap()));
    let rest = server.call(Method::GET, url, &[("range", "bytes=1000-")], "").await;
    assert_eq!((rest.status.as_u16(), &rest.body[..]), (206, &whole.body[1000..]));
    let same = server.call(Method::GET, url, &[("if-none-match", whole.header("etag"))], "").await;
    assert_eq!(same.status, 304);

    // The whole version is one archive, of which a client that was cut off gets the rest.
    let url_of_all = dataset["links"]["archive"].as_str().unwrap();
    let all = server.get(url_of_all).await;
    assert_eq!(
        (all.status.as_u16(), all.header("content-length")),
        (200, all.body.len().to_string().as_str())
    );
    let path = format!("v1/{}", shard.unwrap()["path"].as_str().unwrap());
    let members = tar_members(&all.body);
    assert_eq!(members.len(), files["files"].as_array().unwrap().len());
    assert_eq!(members[&path], whole.body);
    for range in ["bytes=5-", "bytes=700-1500", "bytes=-600"] {
        let headers = [("range", range), ("if-range", all.header("etag"))];
        let part = server.call(Method::GET, url_of_all, &headers, "").await;
        assert_eq!(part.status, 206, "{range}");
        let (first, last) =
            part.header("content-range").trim_start_matches("bytes ").split_once('-').unwrap();
        let last: usize = last.split('/').next().unwrap().parse().unwrap();
        assert_eq!(part.body, all.body[first.parse().unwrap()..=last], "{range}");
    }
    let none = server.get(&format!("{url}x")).await;
    assert_eq!(none.problem(), (404, "not_found".into()));
}

/// Members of a tar archive by name.
fn tar_members(archive: &[u8]) -> BTreeMap<String, Vec<u8>> {
    let mut reader = TarReader::new(archive);
    let mut members = BTreeMap::new();
    while let Some(header) = reader.next_member().unwrap() {
        members.insert(header.name.clone(), reader.content(&header).unwrap());
    }
    members
}

#[tokio::test]
async fn a_verification_reads_every_byte_and_names_what_is_damaged() {
    let server = server().await;
    let batch = made(&server, &TEXTS[..3]).await;
    let dataset =
        frozen(&server, json!({ "name": "mugs", "batch": batch, "splits": { "train": 1.0 } })).await;
    let path = format!("/datasets/{}", dataset["id"].as_str().unwrap());
    let verified = async || {
        let asked = server.call(Method::POST, &format!("{path}/verify"), &[], "").await;
        assert_eq!(asked.status, 202, "{asked:?}");
        until(&server, &path, |dataset| dataset["verification"]["state"] == "finished").await
    };
    let intact = verified().await;
    let found = &intact["verification"]["found"];
    assert_eq!((&found["intact"], &found["scenes"]), (&json!(true), &json!(3)), "{intact}");
    assert!(found["bytes"].as_u64().unwrap() > 1000);
    let files = server.get(dataset["links"]["files"].as_str().unwrap()).await.json();
    let shard =
        files["files"].as_array().unwrap().iter().find(|file| file["media_type"] == "application/x-tar");
    let digest = shard.unwrap()["sha256"].as_str().unwrap();
    let blobs = server.directory.path().join("blobs");
    let blob = find(&blobs, digest).expect("the shard is a file");
    let mut bytes = std::fs::read(&blob).unwrap();
    bytes[700] ^= 1;
    std::fs::write(&blob, bytes).unwrap();
    let damaged = verified().await;
    let found = &damaged["verification"]["found"];
    assert_eq!(found["intact"], false, "{damaged}");
    let named =
        found["faults"].as_array().unwrap().iter().any(|fault| fault["path"] == "shards/train-000000.tar");
    assert!(named, "{damaged}");
}

/// The file below a folder whose name ends with this.
fn find(folder: &std::path::Path, name: &str) -> Option<std::path::PathBuf> {
    for entry in folder.read_dir().ok()? {
        let path = entry.ok()?.path();
        let found = if path.is_dir() { find(&path, name) } else { None };
        if found.is_some() {
            return found;
        }
        if path.is_file() && name.ends_with(path.file_name().unwrap().to_str().unwrap()) {
            return Some(path);
        }
    }
    None
}

#[tokio::test]
async fn requests_that_will_not_do_are_refused_with_pointers() {
    let server = Server::start(&Script::new(&[])).await;
    let unknown = "0192f3a4-5b6c-7d8e-9fa0-b1c2d3e4f5a6";
    let with = |name: &str, value: Value| {
        let mut body = json!({ "name": "mugs", "label": "set:a1" });
        body[name] = value;
        body
    };
    for (body, pointer) in [
        (json!({ "label": "set:a1" }), "/name"),
        (with("name", json!("Mugs!")), "/name"),
        (json!({ "name": "mugs" }), ""),
        (with("batch", json!(unknown)), ""),
        (json!({ "name": "mugs", "batch": unknown }), "/batch"),
        (json!({ "name": "mugs", "scenes": [] }), "/scenes"),
        (json!({ "name": "mugs", "scenes": [unknown] }), "/scenes/0"),
        (with("label", json!("nocolon")), "/label"),
        (with("splits", json!({ "train": 0.5 })), "/splits"),
        (with("splits", json!({ "Train": 1.0 })), "/splits"),
        (with("disjoint", json!(["colour"])), "/disjoint"),
        (with("filter", json!({ "verdict": "maybe" })), "/filter/verdict"),
        (with("filter", json!({ "colour": 1 })), "/filter/colour"),
        (with("shard_mb", json!(0)), "/shard_mb"),
        (with("shard_scenes", json!(0)), "/shard_scenes"),
        (with("colour", json!(1)), "/colour"),
    ] {
        let reply = submit(&server, body.clone()).await;
        assert_eq!(reply.problem(), (422, "invalid_body".into()), "{body}");
        assert_eq!(reply.json()["errors"][0]["pointer"], pointer, "{body}: {reply:?}");
    }
    let text = server.call(Method::POST, "/datasets", &[("content-type", "text/plain")], "mugs").await;
    assert_eq!(text.problem(), (415, "body_format".into()));
    for path in ["/datasets/none", &format!("/datasets/{unknown}"), &format!("/datasets/{unknown}/files")] {
        assert_eq!(server.get(path).await.problem(), (404, "not_found".into()));
    }
    assert_eq!(server.get("/datasets").await.json()["datasets"], json!([]));
}

#[tokio::test]
async fn bundles_that_are_no_scenes_fail_the_dataset_and_keys_make_one() {
    // The script's bundles have no readable scene.
    let server = Server::start(&Script::new(&[])).await;
    let (scene, job) = server.submit("a mug").await;
    server.job_is(&job, "succeeded").await;
    let body = json!({ "name": "mugs", "scenes": [scene], "splits": { "all": 1 } });
    let send = async |body: &Value| {
        let headers = [("content-type", "application/json"), ("idempotency-key", "k1")];
        server.call(Method::POST, "/datasets", &headers, body.to_string()).await
    };
    let first = send(&body).await.json();
    assert_eq!(send(&body).await.json()["id"], first["id"]);
    let other = json!({ "name": "jugs", "scenes": [scene], "splits": { "all": 1 } });
    assert_eq!(send(&other).await.problem(), (422, "idempotency_key_reused".into()));
    let path = format!("/datasets/{}", first["id"].as_str().unwrap());
    let failed = until(&server, &path, |dataset| dataset["state"] == "failed").await;
    assert_eq!(failed["failure"]["code"], "bundle_unusable", "{failed}");
}
