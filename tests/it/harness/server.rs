//! A server on a free port, and a client that holds every answer against the contract.

use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use bytes::Bytes;
use http_body_util::{BodyExt, Full};
use hyper::{HeaderMap, Method, Request, StatusCode};
use hyper_util::client::legacy::Client;
use hyper_util::client::legacy::connect::HttpConnector;
use hyper_util::rt::TokioExecutor;
use serde_json::{Value, json};
use store::{Intent, Store};
use tabletopgen::app::App;
use tabletopgen::app::remote::Remote;
use tabletopgen::config::{Resolved, Sources, layers};
use tabletopgen::service;
use tabletopgen::service::Service;
use tabletopgen::worker::BuildScene;
use tempfile::TempDir;

use crate::harness::contract;
use crate::harness::script::Script;

/// A running server and its data directory.
pub struct Server {
    pub directory: Arc<TempDir>,
    pub service: Service,
    client: Client<HttpConnector, Full<Bytes>>,
}

/// An answer.
#[derive(Debug)]
pub struct Reply {
    pub status: StatusCode,
    pub headers: HeaderMap,
    pub body: Bytes,
}

/// Quick settings, and then these.
pub fn settings(set: &[(&str, &str)]) -> Resolved {
    let quick = [
        ("server.listen", "127.0.0.1:0"),
        ("store.fsync", "false"),
        ("worker.poll_ms", "20"),
        ("worker.backoff_base_ms", "10"),
        ("worker.cpu_threads", "1"),
        ("worker.max_attempts", "3"),
    ];
    let all = quick.iter().chain(set);
    let arguments = all.map(|(key, value)| (key.to_string(), value.to_string(), "--set")).collect();
    layers::load(Sources { arguments, ..Sources::default() }).expect("is a valid configuration")
}

/// The same for a data directory. With `TABLETOPGEN_TEST_DATABASE=postgres` its database is one of a private PostgreSQL
/// server instead of a SQLite file, the same one as long as the directory exists.
pub async fn settings_in(directory: &Path, set: &[(&str, &str)]) -> Resolved {
    if std::env::var("TABLETOPGEN_TEST_DATABASE").as_deref() != Ok("postgres") {
        return settings(set);
    }
    let address = directory.join("address_of_the_database");
    if !address.exists() {
        std::fs::write(&address, test_postgres::database().await).expect("writes");
    }
    let url = std::fs::read_to_string(&address).expect("reads");
    let database = ("store.database", url.as_str());
    settings(&[&[database], set].concat())
}

/// The use cases with the configured reader of instructions.
pub fn reading(resolved: &Resolved) -> App {
    App::reading_with(resolved, &Remote::load(resolved).expect("makes remote models"))
}

/// The store of a data directory.
pub async fn opened(directory: &Path) -> Store {
    tabletopgen::app::open(directory, &settings_in(directory, &[]).await.config, Intent::Create)
        .await
        .expect("opens")
}

impl Server {
    pub async fn start(script: &Arc<Script>) -> Self {
        Self::with(script, &[]).await
    }

    pub async fn with(script: &Arc<Script>, set: &[(&str, &str)]) -> Self {
        let directory = Arc::new(tempfile::tempdir().expect("temporary directory"));
        Self::on(directory, script, set).await
    }

    /// With a pipeline of its own.
    pub async fn building(build: BuildScene, resolved: &Resolved) -> Self {
        let directory = Arc::new(tempfile::tempdir().expect("temporary directory"));
        let service = service::start(&reading(resolved), directory.path(), build).await.expect("starts");
        Self { directory, service, client: Client::builder(TokioExecutor::new()).build_http() }
    }

    /// On a data directory that was used before.
    pub async fn on(directory: Arc<TempDir>, script: &Arc<Script>, set: &[(&str, &str)]) -> Self {
        let data = directory.path().to_owned();
        let service = service::start(&reading(&settings_in(&data, set).await), &data, script.build())
            .await
            .expect("starts");
        Self { directory, service, client: Client::builder(TokioExecutor::new()).build_http() }
    }

    /// Without a worker: a test takes its place.
    pub async fn without_worker(directory: Arc<TempDir>, set: &[(&str, &str)]) -> Self {
        let data = directory.path().to_owned();
        let service =
            service::start_api(&reading(&settings_in(&data, set).await), &data).await.expect("starts");
        Self::serving(directory, service)
    }

    /// A client of a service that runs already.
    pub fn serving(directory: Arc<TempDir>, service: Service) -> Self {
        Self { directory, service, client: Client::builder(TokioExecutor::new()).build_http() }
    }

    /// Stops in good order; the data directory can be used again.
    pub async fn stop(self) -> Arc<TempDir> {
        drop(self.client);
        self.service.stop().await.expect("stops");
        wait_until_unlocked(self.directory.path()).await;
        self.directory
    }

    pub fn store(&self) -> &Store {
        &self.service.store
    }

    /// Any request.
    pub async fn call(
        &self,
        method: Method,
        path: &str,
        headers: &[(&str, &str)],
        body: impl Into<Bytes>,
    ) -> Reply {
        let mut request =
            Request::builder().method(method.clone()).uri(format!("http://{}{path}", self.service.address));
        for (name, value) in headers {
            request = request.header(*name, *value);
        }
        let request = request.body(Full::new(body.into())).expect("is a request");
        let answer = self.client.request(request).await.expect("is answered");
        let (parts, body) = answer.into_parts();
        let body = body.collect().await.expect("arrives").to_bytes();
        let reply = Reply { status: parts.status, headers: parts.headers, body };
        contract::hold(&method, path, &reply);
        reply
    }

    pub async fn get(&self, path: &str) -> Reply {
        self.call(Method::GET, path, &[], "").await
    }

    pub async fn post(&self, path: &str, body: Value) -> Reply {
        self.call(Method::POST, path, &[("content-type", "application/json")], body.to_string()).await
    }

    /// Submits a text; scene and job ids.
    pub async fn submit(&self, text: &str) -> (String, String) {
        let reply = self.post("/scenes", json!({ "text": text, "seed": 7 })).await;
        assert_eq!(reply.status, 202, "{reply:?}");
        let scene = reply.json();
        (scene["id"].as_str().unwrap().to_owned(), scene["job"]["id"].as_str().unwrap().to_owned())
    }

    /// Waits until the job is in this state; the job.
    pub async fn job_is(&self, job_id: &str, state: &str) -> Value {
        let reached = async {
            loop {
                let job = self.get(&format!("/jobs/{job_id}")).await.json();
                if job["state"] == state {
                    return job;
                }
                tokio::time::sleep(Duration::from_millis(10)).await;
            }
        };
        tokio::time::timeout(Duration::from_secs(20), reached)
            .await
            .unwrap_or_else(|_| panic!("job {job_id} never was {state}"))
    }

    /// Waits until the job has ended, at most so long; the job.
    pub async fn job_ends(&self, job_id: &str, at_most: Duration) -> Value {
        let ended = async {
            loop {
                let job = self.get(&format!("/jobs/{job_id}")).await.json();
                if ["succeeded", "failed", "cancelled"].contains(&job["state"].as_str().unwrap()) {
                    return job;
                }
                tokio::time::sleep(Duration::from_millis(50)).await;
            }
        };
        tokio::time::timeout(at_most, ended).await.unwrap_or_else(|_| panic!("job {job_id} never ended"))
    }

    /// Kinds of the job's events, in order.
    pub async fn kinds(&self, job_id: &str) -> Vec<String> {
        let events = self.get(&format!("/jobs/{job_id}/events?page_size=200")).await.json();
        let kind = |event: &Value| event["kind"].as_str().unwrap().to_owned();
        events["events"].as_array().unwrap().iter().map(kind).collect()
    }
}

impl Reply {
    pub fn json(&self) -> Value {
        serde_json::from_slice(&self.body)
            .unwrap_or_else(|error| panic!("{error}: {}", String::from_utf8_lossy(&self.body)))
    }

    pub fn header(&self, name: &str) -> &str {
        self.headers.get(name).map_or("", |value| value.to_str().unwrap())
    }

    /// Status and code of a problem.
    pub fn problem(&self) -> (u16, String) {
        assert_eq!(self.header("content-type"), "application/problem+json", "{self:?}");
        (self.status.as_u16(), self.json()["code"].as_str().unwrap().to_owned())
    }
}

/// The writer's thread lets go of the lock a moment after the last handle.
pub async fn wait_until_unlocked(data_dir: &Path) {
    let lock = std::fs::File::open(data_dir.join("lock")).expect("there is a lock file");
    for _ in 0..500 {
        if lock.try_lock().is_ok() {
            return;
        }
        tokio::time::sleep(Duration::from_millis(10)).await;
    }
    panic!("the data directory stays locked");
}
