//! Stopping and starting again: nothing finished is repeated, nothing accepted is lost.

use std::sync::Arc;
use std::time::Duration;

use scene::JobId;
use serde_json::json;
use store::queue::Scope;
use store::scenes::{NewScene, SubmitOutcome};
use store::{DEFAULT_TENANT, Digest, Store};
use tabletopgen::service;

use crate::harness::script::{Act, Script};
use crate::harness::server::{Server, opened, reading, settings_in, wait_until_unlocked};

#[tokio::test]
async fn a_drain_finishes_the_stage_releases_the_job_uncharged_and_a_restart_goes_on() {
    let script = Script::new(&[("beta", &[Act::Wait, Act::Wait])]);
    let server = Server::start(&script).await;
    let (_, job) = server.submit("a mug").await;
    script.reaches("beta/mug_1").await;
    script.reaches("beta/mug_2").await;
    server.service.shutdown.cancel();
    tokio::time::sleep(Duration::from_millis(50)).await;
    script.open_gate();
    let directory = server.stop().await;
    assert_eq!(script.runs().len(), 3, "omega was not begun: {:?}", script.runs());

    let store = opened(directory.path()).await;
    let job_id: JobId = job.parse().unwrap();
    let row = store.job(&DEFAULT_TENANT, &job_id).await.unwrap().unwrap();
    assert_eq!((row.state.as_str(), row.attempt), ("queued", 0));
    let finished = store.stages(&DEFAULT_TENANT, &job_id).await.unwrap();
    assert!(finished.iter().all(|stage| stage.state == "finished"), "{finished:?}");
    drop(store);
    wait_until_unlocked(directory.path()).await;

    let second = Script::new(&[]);
    let server = Server::on(directory, &second, &[]).await;
    let view = server.job_is(&job, "succeeded").await;
    assert_eq!(second.runs(), ["omega"]);
    assert_eq!(view["attempt"], 1);
    assert!(server.kinds(&job).await.contains(&"job_released".to_owned()));
}

#[tokio::test]
async fn a_stage_that_outlasts_the_grace_is_interrupted_and_the_job_kept() {
    let script = Script::new(&[("alpha", &[Act::Wait])]);
    let server = Server::with(&script, &[("worker.drain_grace_secs", "0")]).await;
    let (_, job) = server.submit("a mug").await;
    script.reaches("alpha").await;
    let directory = server.stop().await;
    let second = Script::new(&[]);
    let server = Server::on(directory, &second, &[]).await;
    server.job_is(&job, "succeeded").await;
    assert_eq!(second.runs().len(), 4);
}

#[tokio::test]
async fn jobs_of_a_worker_that_died_are_taken_over_at_once() {
    let directory = Arc::new(tempfile::tempdir().unwrap());
    let store = opened(directory.path()).await;
    let job = submit(&store, "a mug").await;
    let lease = Duration::from_secs(3600);
    let claim = store.claim("the dead", lease, 3, &Scope::all()).await.unwrap().expect("claims");
    assert_eq!((&claim.lease.job_id, claim.attempt), (&job, 1));
    drop(store);
    wait_until_unlocked(directory.path()).await;

    let server = Server::on(directory, &Script::new(&[]), &[]).await;
    let view = server.job_is(job.as_str(), "succeeded").await;
    assert_eq!(view["state"], "succeeded");
}

#[tokio::test]
async fn a_job_whose_worker_dies_every_time_is_failed_in_the_end() {
    let directory = tempfile::tempdir().unwrap();
    let store = opened(directory.path()).await;
    let job = submit(&store, "a mug").await;
    for _ in 0..2 {
        let claim = store.claim("the dead", Duration::ZERO, 2, &Scope::all()).await.unwrap().expect("claims");
        assert_eq!(claim.attempt, 1, "the death of a worker is no attempt");
    }
    assert_eq!(store.claim("the next", Duration::ZERO, 2, &Scope::all()).await.unwrap(), None);
    let row = store.job(&DEFAULT_TENANT, &job).await.unwrap().unwrap();
    assert_eq!((row.state.as_str(), row.failure_code.as_deref()), ("failed", Some("worker_crashed")));
}

#[tokio::test]
async fn a_data_directory_has_one_user() {
    let server = Server::start(&Script::new(&[])).await;
    let refused = service::start(
        &reading(&settings_in(server.directory.path(), &[]).await),
        server.directory.path(),
        Script::new(&[]).build(),
    )
    .await;
    let message = refused.err().expect("is refused").chain();
    assert!(message.contains("in use by another process") && message.contains("--data-dir"), "{message}");
}

/// A crash between the blob and its row leaves a blob without a reference.
#[tokio::test]
async fn a_blob_without_its_row_is_a_stage_that_runs_again() {
    let script = Script::new(&[]);
    let server = Server::start(&script).await;
    let (_, job) = server.submit("a mug").await;
    server.job_is(&job, "succeeded").await;
    let directory = server.stop().await;
    sql(&directory, "DELETE FROM checkpoints WHERE stage = 'beta' AND instance = 'mug_2'").await;

    let script = Script::new(&[]);
    let server = Server::on(directory, &script, &[]).await;
    let (_, job) = server.submit("a mug").await;
    server.job_is(&job, "succeeded").await;
    assert_eq!(script.runs(), ["beta/mug_2"]);
}

#[tokio::test]
async fn missing_damaged_and_unreadable_work_is_done_again() {
    let server = Server::start(&Script::new(&[])).await;
    let (scene, job) = server.submit("a mug").await;
    server.job_is(&job, "succeeded").await;
    let whole = server.get(&format!("/scenes/{scene}/bundle")).await.body;
    let mut directory = server.stop().await;

    for (damage, again) in [
        // The artifact of one instance is gone.
        ("artifact", vec!["beta/mug_1"]),
        // The output of the first stage is not what its name says; what follows has the same keys.
        ("output", vec!["alpha"]),
        ("row", vec!["omega"]),
    ] {
        match damage {
            "artifact" => std::fs::remove_file(blob(&directory, b"beta/mug_1 was here")).unwrap(),
            "output" => {
                let query = "SELECT output FROM checkpoints WHERE stage = 'alpha'";
                let digest = sql(&directory, query).await;
                let path = directory.path().join(format!("blobs/sha256/{}/{digest}", &digest[..2]));
                std::fs::write(path, b"{}").unwrap();
            }
            _ => {
                sql(&directory, "UPDATE checkpoints SET artifacts = 'not json' WHERE stage = 'omega'").await;
            }
        }
        let script = Script::new(&[]);
        let server = Server::on(directory, &script, &[]).await;
        let (scene, job) = server.submit("a mug").await;
        server.job_is(&job, "succeeded").await;
        let mut runs = script.runs();
        runs.sort();
        assert_eq!(runs, again, "{damage}");
        assert_eq!(server.get(&format!("/scenes/{scene}/bundle")).await.body, whole, "{damage}");
        directory = server.stop().await;
    }
}

#[tokio::test]
async fn missing_bytes_are_made_again_and_the_server_goes_on() {
    let server = Server::start(&Script::new(&[])).await;
    let (scene, job) = server.submit("a mug").await;
    server.job_is(&job, "succeeded").await;
    std::fs::remove_file(blob(&server.directory, b"alpha was here")).unwrap();
    let reply = server.get(&format!("/scenes/{scene}/artifacts/alpha/note.txt")).await;
    assert_eq!(reply.problem(), (503, "being_rebuilt".into()));
    assert_eq!(server.get(&format!("/scenes/{scene}")).await.status, 200);
}

async fn submit(store: &Store, text: &str) -> JobId {
    let request =
        json!({ "version": 1, "input": { "kind": "text", "text": text }, "seed": 7, "options": {} });
    let new = NewScene {
        tenant_id: DEFAULT_TENANT.clone(),
        parent_id: None,
        request,
        labels: Default::default(),
        budget_micro_usd: 0,
        idempotency: None,
    };
    match store.submit(new).await.unwrap() {
        SubmitOutcome::Created { job_id, .. } => job_id,
        other => panic!("{other:?}"),
    }
}

fn blob(directory: &tempfile::TempDir, bytes: &[u8]) -> std::path::PathBuf {
    let digest = Digest::of(bytes).to_string();
    directory.path().join(format!("blobs/sha256/{}/{digest}", &digest[..2]))
}

/// Runs one statement on an unused data directory; the first column of its first row, if any.
async fn sql(directory: &tempfile::TempDir, statement: &'static str) -> String {
    use sqlx::{Connection, Row};
    let path = directory.path().join("tabletopgen.sqlite");
    let options = sqlx::sqlite::SqliteConnectOptions::new().filename(path);
    let mut connection = sqlx::SqliteConnection::connect_with(&options).await.unwrap();
    let row = sqlx::query(statement).fetch_optional(&mut connection).await.unwrap();
    connection.close().await.unwrap();
    row.map_or(String::new(), |row| row.get(0))
}
