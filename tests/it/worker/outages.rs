//! Storage that takes no writes: jobs wait and burn no attempts, the server says that it is not ready,
//! and all goes on when it works again.

use std::time::Duration;

use serde_json::json;
use sqlx::{Connection, SqliteConnection};
use store::Outage;

use crate::harness::script::{Act, Script};
use crate::harness::server::Server;

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
