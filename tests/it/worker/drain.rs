//! Stopping: what is refused first, what is waited for, and what cannot hold a stop or a cancellation up.

use std::net::SocketAddr;
use std::sync::Arc;
use std::time::{Duration, Instant};

use hyper::Method;
use scene::JobId;
use store::DEFAULT_TENANT;
use store::lifecycle::JobState;
use tabletopgen::app::App;
use tabletopgen::service;
use tokio::io::{AsyncReadExt, AsyncWriteExt};

use crate::harness::script::{Act, Script};
use crate::harness::server::{Server, opened, settings};

#[tokio::test]
async fn a_draining_server_is_not_ready_and_answers_until_its_jobs_are_given_back() {
    let script = Script::new(&[("alpha", &[Act::Wait])]);
    let server = Server::start(&script).await;
    let (_, job) = server.submit("a mug").await;
    script.reaches("alpha").await;
    assert_eq!(server.get("/readyz").await.status, 200);
    server.service.shutdown.cancel();
    assert_eq!(server.get("/readyz").await.problem(), (503, "shutting_down".into()));
    // The process lives, and clients see their jobs, until the stage has ended.
    assert_eq!(server.get("/healthz").await.status, 200);
    assert_eq!(server.get(&format!("/jobs/{job}")).await.json()["state"], "running");
    let (_, queued) = server.submit("a bowl").await;
    assert_eq!(server.get(&format!("/jobs/{queued}")).await.json()["state"], "queued");
    script.open_gate();
    server.job_is(&job, "queued").await;
    assert_eq!(script.runs(), ["alpha"], "nothing new was begun");
    server.stop().await;
}

#[tokio::test]
async fn a_stage_that_ignores_the_interrupt_holds_no_cancellation_up() {
    let script = Script::new(&[("alpha", &[Act::Ignore])]);
    let server = Server::start(&script).await;
    let (_, job) = server.submit("a mug").await;
    script.reaches("alpha").await;
    assert_eq!(server.call(Method::POST, &format!("/jobs/{job}/cancel"), &[], "").await.status, 202);
    server.job_is(&job, "cancelled").await;
    // The slot is free for the next job.
    let (_, next) = server.submit("a bowl").await;
    server.job_is(&next, "succeeded").await;
}

#[tokio::test]
async fn a_stage_that_ignores_the_interrupt_holds_no_stop_up() {
    let script = Script::new(&[("alpha", &[Act::Ignore])]);
    let server = Server::with(&script, &[("worker.drain_grace_secs", "0")]).await;
    let (_, job) = server.submit("a mug").await;
    script.reaches("alpha").await;
    let begun = Instant::now();
    let directory = server.stop().await;
    assert!(begun.elapsed() < Duration::from_secs(12), "{:?}", begun.elapsed());
    let store = opened(directory.path()).await;
    let job: JobId = job.parse().unwrap();
    let row = store.job(&DEFAULT_TENANT, &job).await.unwrap().unwrap();
    assert_eq!((row.state, row.attempt), (JobState::Queued, 0));
}

#[tokio::test]
async fn a_running_job_fails_at_its_deadline() {
    let script = Script::new(&[("alpha", &[Act::Wait])]);
    let set = [("queue.deadline_secs", "1"), ("worker.heartbeat_secs", "1")];
    let server = Server::with(&script, &set).await;
    let (_, job) = server.submit("a mug").await;
    script.reaches("alpha").await;
    let job = server.job_is(&job, "failed").await;
    assert_eq!(job["failure"]["code"], "deadline_passed");
    assert_eq!(script.runs(), ["alpha"]);
}

#[tokio::test]
async fn a_stage_ends_at_its_timeout_whatever_it_does() {
    let script = Script::new(&[("alpha", &[Act::Ignore, Act::Wait])]);
    let set = [("worker.stage_timeout_secs", "1"), ("worker.max_attempts", "2")];
    let server = Server::with(&script, &set).await;
    let (_, job) = server.submit("a mug").await;
    let job = server.job_is(&job, "failed").await;
    assert_eq!(job["failure"]["code"], "stage_timeout");
    assert_eq!(script.runs(), ["alpha", "alpha"]);
}

#[tokio::test]
async fn an_interface_without_a_worker_accepts_and_builds_nothing() {
    let directory = tempfile::tempdir().unwrap();
    // The command line refuses this on a SQLite file; the parts work all the same.
    let service = service::start_api(&App::new(&settings(&[])), directory.path()).await.unwrap();
    let server = Server::serving(Arc::new(directory), service);
    let (_, job) = server.submit("a mug").await;
    tokio::time::sleep(Duration::from_millis(200)).await;
    assert_eq!(server.get(&format!("/jobs/{job}")).await.json()["state"], "queued");
    server.stop().await;
}

#[tokio::test]
async fn a_worker_without_the_interface_answers_probes_and_nothing_else() {
    let directory = tempfile::tempdir().unwrap();
    let listen = Some("127.0.0.1:0");
    let build = Script::new(&[]).build();
    let worker =
        service::start_worker(&App::new(&settings(&[])), directory.path(), listen, build).await.unwrap();
    let address = worker.address.expect("it listens");
    for (path, status) in [("/healthz", 200), ("/readyz", 200), ("/metrics", 200), ("/scenes", 404)] {
        assert_eq!(status_of(address, path).await, status, "{path}");
    }
    worker.stop().await.unwrap();
    let directory = tempfile::tempdir().unwrap();
    let build = Script::new(&[]).build();
    let worker =
        service::start_worker(&App::new(&settings(&[])), directory.path(), None, build).await.unwrap();
    assert_eq!(worker.address, None);
    worker.stop().await.unwrap();
}

/// The status of the answer to a GET.
async fn status_of(address: SocketAddr, path: &str) -> u16 {
    let mut stream = tokio::net::TcpStream::connect(address).await.unwrap();
    let request = format!("GET {path} HTTP/1.1\r\nhost: {address}\r\nconnection: close\r\n\r\n");
    stream.write_all(request.as_bytes()).await.unwrap();
    let mut answer = String::new();
    stream.read_to_string(&mut answer).await.unwrap();
    answer[9..12].parse().unwrap()
}
