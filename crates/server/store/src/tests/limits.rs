//! Limits of everything that is asked of PostgreSQL, and the intent of those who open a database.

use std::time::Instant;

use sqlx::{Connection, PgConnection};

use super::*;

/// Limits so short that a test waits for them.
fn short() -> PostgresSettings {
    PostgresSettings {
        acquire_timeout_ms: 1_000,
        statement_timeout_ms: 800,
        lock_timeout_ms: 300,
        answer_timeout_ms: 1_500,
        ..test_settings::section("store.postgres")
    }
}

async fn opened(url: &str) -> (Store, tempfile::TempDir) {
    let directory = tempfile::tempdir().expect("temporary directory");
    let settings = Settings { postgres: short(), ..settings(DatabaseAddress::Postgres(url.to_owned())) };
    let store = Store::open(directory.path(), &settings, Intent::Create).await.expect("opens");
    (store, directory)
}

/// A question fails as an outage, within these seconds.
async fn is_refused<T>(answer: impl Future<Output = Result<T, StoreError>>, doing: &str) {
    let began = Instant::now();
    let error = match answer.await {
        Ok(_) => panic!("{doing} succeeds"),
        Err(error) => error,
    };
    assert_eq!(error.outage(), Some(Outage::Other), "{doing}: {}", error.chain());
    assert!(began.elapsed() < Duration::from_secs(4), "{doing} took {:?}", began.elapsed());
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_locked_table_refuses_reads_writes_and_readiness_in_time() {
    let url = test_postgres::database().await;
    let (store, _directory) = opened(&url).await;
    let (scene, job) = submitted(&store).await;
    let mut operator = PgConnection::connect(&url).await.expect("connects");
    for table in ["scenes", "jobs", "events"] {
        let lock = format!("BEGIN; LOCK TABLE {table} IN ACCESS EXCLUSIVE MODE");
        sqlx::raw_sql(sqlx::AssertSqlSafe(lock)).execute(&mut operator).await.expect("locks");
        is_refused(store.submit(new_scene()), "a submission").await;
        is_refused(store.is_healthy(), "readiness").await;
        if table == "jobs" {
            is_refused(store.job(&DEFAULT_TENANT, &job), "a read").await;
            is_refused(store.queue_status(), "reads on a connection").await;
            is_refused(store.claim("a", Duration::from_secs(60), 3, &Scope::all()), "a claim").await;
        }
        sqlx::raw_sql("ROLLBACK").execute(&mut operator).await.expect("frees");
        submitted(&store).await;
        store.is_healthy().await.expect("is well again");
    }
    // The good verdict of a moment ago is over.
    tokio::time::sleep(Duration::from_millis(1_100)).await;
    // A lock that lets reads pass, as that of CREATE INDEX, stops the work as well.
    sqlx::raw_sql("BEGIN; LOCK TABLE jobs IN SHARE MODE").execute(&mut operator).await.expect("locks");
    assert!(store.scene(&DEFAULT_TENANT, &scene).await.expect("reads").is_some());
    is_refused(store.is_healthy(), "readiness").await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_frozen_server_refuses_reads_writes_and_readiness_in_time() {
    let server = test_postgres::OwnServer::start().await;
    let (store, directory) = opened(&server.url).await;
    let (_, job) = submitted(&store).await;
    let frozen = server.freeze();
    // At once, a connection that has just answered is used again; later, one that has to be tested first.
    for pause_ms in [0, 1_500] {
        tokio::time::sleep(Duration::from_millis(pause_ms)).await;
        let read = is_refused(store.job(&DEFAULT_TENANT, &job), "a read");
        let several = is_refused(store.queue_status(), "reads on a connection");
        let write = is_refused(store.submit(new_scene()), "a submission");
        let readiness = is_refused(store.is_healthy(), "readiness");
        tokio::join!(read, several, write, readiness);
    }
    let settings = Settings { postgres: short(), ..settings(DatabaseAddress::Postgres(server.url.clone())) };
    is_refused(Store::open(directory.path(), &settings, Intent::Existing), "opening").await;
    drop(frozen);
    // Connections that were closed are replaced.
    for _ in 0..20 {
        if store.is_healthy().await.is_ok() {
            break;
        }
        tokio::time::sleep(Duration::from_millis(100)).await;
    }
    assert!(store.job(&DEFAULT_TENANT, &job).await.expect("reads").is_some());
    submitted(&store).await;
    assert_eq!(*store.outage().borrow(), None);
}

#[tokio::test]
async fn a_statement_ends_by_its_limit_and_an_unhurried_one_goes_on() {
    let (store, _directory) = opened(&test_postgres::database().await).await;
    let slow = "SELECT CAST(1 AS BIGINT) FROM (SELECT pg_sleep(1.2)) AS slept";
    let slow = async |readers: &Readers| sqlx::query_scalar::<_, i64>(slow).fetch_one(readers).await;
    let usual = slow(&store.readers).await.map_err(StoreError::from);
    is_refused(async { usual }, "a slow statement").await;
    assert_eq!(slow(&store.readers.unhurried()).await.expect("has the time"), 1);
    let sleep = |writer: Writer| async move {
        let sleep = writer.write("sleep", |connection| {
            Box::pin(async move {
                sqlx::query("SELECT pg_sleep(1.2)").execute(connection).await?;
                Ok(())
            })
        });
        sleep.await
    };
    is_refused(sleep(store.writer.clone()), "a slow transaction").await;
    sleep(store.writer.unhurried()).await.expect("has the time");
}

#[tokio::test]
async fn without_intent_to_create_a_missing_database_is_an_error_and_stays_missing() {
    let home = tempfile::tempdir().expect("temporary directory");
    let mistyped = home.path().join("daat");
    let sqlite = settings(DatabaseAddress::Sqlite);
    let missing = Store::open(&mistyped, &sqlite, Intent::Existing).await.err().expect("is refused");
    let message = missing.to_string();
    assert!(matches!(missing, StoreError::NoDatabase { .. }), "{message}");
    assert!(message.contains("daat") && message.contains("tabletopgen.sqlite"), "{message}");
    assert!(!mistyped.exists(), "nothing is created");
    let beside = crate::Operator::open(&mistyped, &sqlite).await.err().expect("is refused");
    assert!(matches!(beside, StoreError::NoDatabase { .. }), "{beside}");

    let url = test_postgres::database().await;
    let postgres = settings(DatabaseAddress::Postgres(url.clone()));
    let missing = Store::open(home.path(), &postgres, Intent::Existing).await.err().expect("is refused");
    assert!(missing.to_string().contains(&url), "{missing}");
    drop(Store::open(home.path(), &postgres, Intent::Create).await.expect("creates"));
    Store::open(home.path(), &postgres, Intent::Existing).await.expect("is there now");
}
