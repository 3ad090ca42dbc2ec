//! Stored bytes that are damaged or gone: never served under their old tag, and made again.

use std::path::{Path, PathBuf};
use std::time::Duration;

use hyper::Method;
use serde_json::json;

use crate::harness::script::{Act, Script};
use crate::harness::server::{Reply, Server};

/// The file of the blob that a reply has as its tag.
pub fn file_of(data_dir: &Path, reply: &Reply) -> PathBuf {
    let digest = reply.header("etag").trim_matches('"');
    data_dir.join("blobs/sha256").join(&digest[..2]).join(digest)
}

/// Changes the central byte.
pub fn damage(file: &Path) {
    let mut bytes = std::fs::read(file).expect("reads");
    let at = bytes.len() / 2;
    bytes[at] ^= 1;
    std::fs::write(file, bytes).expect("writes");
}

pub async fn newest_job(server: &Server, scene: &str) -> String {
    server.get(&format!("/scenes/{scene}")).await.json()["job"]["id"].as_str().unwrap().to_owned()
}

#[tokio::test]
async fn a_damaged_bundle_is_made_again_and_is_the_same() {
    let script = Script::new(&[]);
    let server = Server::start(&script).await;
    let (scene, job) = server.submit("a mug").await;
    server.job_is(&job, "succeeded").await;
    let path = format!("/scenes/{scene}/bundle");
    let whole = server.get(&path).await;
    let file = file_of(server.directory.path(), &whole);
    for (round, range) in [(1, None), (2, Some(("range", "bytes=0-3")))] {
        damage(&file);
        let headers: Vec<_> = range.into_iter().collect();
        let refused = server.call(Method::GET, &path, &headers, "").await;
        assert_eq!(refused.problem(), (503, "being_rebuilt".into()), "round {round}");
        assert_ne!(refused.header("retry-after"), "");
        assert_eq!(refused.header("etag"), "");
        let rebuild = newest_job(&server, &scene).await;
        assert_ne!(rebuild, job, "another job works on the scene");
        server.job_is(&rebuild, "succeeded").await;
        let again = server.get(&path).await;
        assert_eq!((again.status.as_u16(), &again.body), (200, &whole.body));
        assert_eq!(again.header("etag"), whole.header("etag"));
        assert_eq!(server.get(&format!("/scenes/{scene}")).await.json()["state"], "ready");
    }
    // Only what was damaged was computed again.
    assert_eq!(script.runs().iter().filter(|run| *run == "omega").count(), 3);
    assert_eq!(script.runs().iter().filter(|run| *run == "alpha").count(), 1);
}

#[tokio::test]
async fn a_damaged_archive_of_one_format_is_cut_again() {
    let server = Server::start(&Script::new(&[])).await;
    let (scene, job) = server.submit("a mug").await;
    server.job_is(&job, "succeeded").await;
    let path = format!("/scenes/{scene}/bundle?format=mjcf");
    let first = server.get(&path).await;
    damage(&file_of(server.directory.path(), &first));
    let second = server.get(&path).await;
    assert_eq!((second.status.as_u16(), &second.body), (200, &first.body));
    assert_eq!(newest_job(&server, &scene).await, job, "no job is needed for that");
}

#[tokio::test]
async fn a_damaged_artifact_and_a_damaged_checkpoint_are_computed_again() {
    let script = Script::new(&[]);
    let server = Server::start(&script).await;
    let (scene, job) = server.submit("a mug").await;
    server.job_is(&job, "succeeded").await;
    let path = format!("/scenes/{scene}/artifacts/alpha/note.txt");
    let note = server.get(&path).await;
    damage(&file_of(server.directory.path(), &note));
    assert_eq!(server.get(&path).await.problem(), (503, "being_rebuilt".into()));
    let rebuild = newest_job(&server, &scene).await;
    server.job_is(&rebuild, "succeeded").await;
    assert_eq!(server.get(&path).await.body, note.body);
    assert_eq!(script.runs().iter().filter(|run| *run == "alpha").count(), 2);

    // The outputs of stages are the blobs that nothing serves.
    let folder = server.directory.path().join("blobs/sha256");
    for shard in std::fs::read_dir(&folder).unwrap() {
        for entry in std::fs::read_dir(shard.unwrap().path()).unwrap() {
            let path = entry.unwrap().path();
            if std::fs::read(&path).unwrap().starts_with(b"{\"artifacts\":") {
                damage(&path);
            }
        }
    }
    let (_, again) = server.submit("a mug").await;
    server.job_is(&again, "succeeded").await;
    assert_eq!(script.runs().iter().filter(|run| *run == "alpha").count(), 3);
    assert_eq!(script.runs().iter().filter(|run| *run == "omega").count(), 2);
}

#[tokio::test]
async fn a_bundle_that_cannot_be_made_again_says_so() {
    let script = Script::new(&[]);
    let server = Server::start(&script).await;
    let (scene, job) = server.submit("a mug").await;
    server.job_is(&job, "succeeded").await;
    let path = format!("/scenes/{scene}/bundle");
    let whole = server.get(&path).await;
    script.next("omega", Act::Permanent);
    damage(&file_of(server.directory.path(), &whole));
    assert_eq!(server.get(&path).await.problem(), (503, "being_rebuilt".into()));
    let rebuild = newest_job(&server, &scene).await;
    server.job_is(&rebuild, "failed").await;
    assert_eq!(server.get(&path).await.problem(), (500, "stored_data_missing".into()));
    // A retry of that job is what the answer asks for.
    let retried = server.post(&format!("/jobs/{rebuild}/retry"), json!({})).await;
    assert_eq!(retried.status, 202, "{retried:?}");
    let retry = newest_job(&server, &scene).await;
    server.job_ends(&retry, Duration::from_secs(20)).await;
    assert_eq!(server.get(&path).await.body, whole.body);
}
