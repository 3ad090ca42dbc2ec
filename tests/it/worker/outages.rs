//! Storage that takes no writes: jobs wait and burn no attempts, the server says that it is not ready,
//! and all goes on when it works again.

use std::sync::Arc;
use std::time::{Duration, Instant};

use serde_json::json;
use sqlx::{AssertSqlSafe, Connection, PgConnection, SqliteConnection};
use store::Outage;

use crate::harness::script::{Act, Script};
use crate::harness::server::{Server, settings};

/// Another program that holds the database: no write succeeds meanwhile.
async fn hold(server: &Server) -> SqliteConnection {
    let path = server.directory.path().join("tabletopgen.sqlite");
    let options = sqlx::sqlite::SqliteConnectOptions::new().filename(path);
    let mut connection = SqliteConnection::connect_with(&options).await.unwrap();
    sqlx::query("BEGIN IMMEDIATE").execute(&mut connection).await.unwrap();
    connection
}

#[tokio::test]
async fn a_database_that_takes_no_writes_is_waited_for() {
    let script = Script::new(&[("beta", &[Act::Wait, Act::Wait])]);
    let set = [("store.busy_timeout_ms", "1"), ("worker.max_attempts", "1"), ("worker.backoff_cap_ms", "50")];
    let server = Server::with(&script, &set).await;
    let (_, job) = server.submit("a mug").await;
    script.reaches("beta/mug_1").await;
    script.reaches("beta/mug_2").await;

    let holder = hold(&server).await;
    let refused = server.post("/scenes", json!({ "text": "a bowl" })).await;
    assert_eq!(refused.problem(), (503, "store_unavailable".into()));
    assert_eq!(refused.header("retry-after"), "5");
    assert_eq!(*server.store().outage().borrow(), Some(Outage::Other));
    assert_eq!(server.get("/readyz").await.problem(), (503, "store_unavailable".into()));
    // Reading goes on.
    assert_eq!(server.get(&format!("/jobs/{job}")).await.json()["state"], "running");
    script.open_gate();
    tokio::time::sleep(Duration::from_millis(300)).await;
    drop(holder);

    // With one attempt the job would have failed, had the outage been charged to it.
    let view = server.job_is(&job, "succeeded").await;
    assert_eq!(view["failure"], json!(null));
    assert_eq!(server.get("/readyz").await.status, 200);
    assert_eq!(*server.store().outage().borrow(), None);
}

#[tokio::test]
async fn an_idle_server_notices_the_end_of_an_outage() {
    let set = [("store.busy_timeout_ms", "1"), ("worker.backoff_cap_ms", "50")];
    let server = Server::with(&Script::new(&[]), &set).await;
    let holder = hold(&server).await;
    let mut outage = server.store().outage();
    outage.wait_for(Option::is_some).await.unwrap();
    drop(holder);
    tokio::time::timeout(Duration::from_secs(10), outage.wait_for(Option::is_none))
        .await
        .expect("it is noticed")
        .unwrap();
}

/// A server on PostgreSQL whose limits are short enough for a test.
async fn on_postgres(script: &Arc<Script>, url: &str) -> Server {
    let set = [
        ("store.database", url),
        ("store.blobs", "memory"),
        ("store.postgres.acquire_timeout_ms", "1000"),
        ("store.postgres.statement_timeout_ms", "800"),
        ("store.postgres.lock_timeout_ms", "400"),
        ("store.postgres.answer_timeout_ms", "1500"),
        ("worker.max_attempts", "1"),
        ("worker.backoff_cap_ms", "50"),
    ];
    Server::building(script.build(), &settings(&set)).await
}

/// Each of these is refused with 503 and `Retry-After`, in seconds and not for as long as the database is away.
async fn refuses(server: &Server, path: &str) {
    let began = Instant::now();
    let (read, submission, readiness) = tokio::join!(
        server.get(path),
        server.post("/scenes", json!({ "text": "a bowl" })),
        server.get("/readyz")
    );
    for (name, reply) in [("GET", read), ("POST", submission), ("/readyz", readiness)] {
        assert_eq!(reply.problem(), (503, "store_unavailable".into()), "{name}");
        assert_eq!(reply.header("retry-after"), "5", "{name}");
    }
    assert!(began.elapsed() < Duration::from_secs(5), "it took {:?}", began.elapsed());
    assert_eq!(server.get("/healthz").await.status, 200);
}

async fn is_well_again(server: &Server) {
    let ready = async {
        while server.get("/readyz").await.status != 200 {
            tokio::time::sleep(Duration::from_millis(50)).await;
        }
    };
    tokio::time::timeout(Duration::from_secs(20), ready).await.expect("it goes on by itself");
    let (_, job) = server.submit("a plate").await;
    server.job_is(&job, "succeeded").await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_locked_table_of_postgres_is_answered_with_503_in_seconds() {
    let url = test_postgres::database().await;
    let script = Script::new(&[]);
    let server = on_postgres(&script, &url).await;
    let (_, job) = server.submit("a mug").await;
    server.job_is(&job, "succeeded").await;
    let mut operator = PgConnection::connect(&url).await.unwrap();
    let lock = "BEGIN; LOCK TABLE jobs IN ACCESS EXCLUSIVE MODE".to_owned();
    sqlx::raw_sql(AssertSqlSafe(lock)).execute(&mut operator).await.unwrap();
    refuses(&server, &format!("/jobs/{job}")).await;
    sqlx::raw_sql("ROLLBACK").execute(&mut operator).await.unwrap();
    is_well_again(&server).await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_frozen_postgres_is_answered_with_503_in_seconds() {
    let postgres = test_postgres::OwnServer::start().await;
    let script = Script::new(&[("beta", &[Act::Wait, Act::Wait])]);
    let server = on_postgres(&script, &postgres.url).await;
    let (_, job) = server.submit("a mug").await;
    script.reaches("beta/mug_1").await;
    let frozen = postgres.freeze();
    refuses(&server, &format!("/jobs/{job}")).await;
    refuses(&server, &format!("/jobs/{job}")).await;
    script.open_gate();
    tokio::time::sleep(Duration::from_millis(500)).await;
    drop(frozen);
    // With one attempt the job would have failed, had the outage been charged to it.
    server.job_is(&job, "succeeded").await;
    is_well_again(&server).await;
}
