//! Removals find the rows that refer to what they remove: every foreign key has an index on the referring side. And no
//! statement scans a table of PostgreSQL: all that a store does is run where scans are as unwelcome as possible, and
//! the scans of each table are counted.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

#[path = "../statements/exercise.rs"]
mod exercise;

use std::collections::BTreeMap;
use std::time::Duration;

use sqlx::sqlite::SqliteConnectOptions;
use sqlx::{AssertSqlSafe, Connection, PgConnection, Row, SqliteConnection};
use store::{BlobPlace, DatabaseAddress, Intent, Settings, Store};

fn settings(database: DatabaseAddress) -> Settings {
    Settings { database, fsync: false, blobs: BlobPlace::Memory, ..test_settings::section("store") }
}

async fn sqlite_file(directory: &std::path::Path) -> SqliteConnection {
    let options = SqliteConnectOptions::new().filename(directory.join("tabletopgen.sqlite"));
    SqliteConnection::connect_with(&options).await.unwrap()
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn no_statement_scans_a_table_of_a_postgres_database() {
    /// A few rows, whatever a store holds.
    const SMALL: [&str; 3] = ["_sqlx_migrations", "switches", "upkeep"];
    let url = test_postgres::database().await;
    let settings = settings(DatabaseAddress::Postgres(url.clone()));
    let directory = tempfile::tempdir().unwrap();
    drop(Store::open(directory.path(), &settings, Intent::Create).await.unwrap());
    let mut connection = PgConnection::connect(&url).await.unwrap();
    let name: String =
        sqlx::query_scalar("SELECT current_database()::text").fetch_one(&mut connection).await.unwrap();
    // With every other way at a discount, a scan means that there is no index.
    let unwelcome = format!("ALTER DATABASE {name} SET enable_seqscan = off");
    sqlx::raw_sql(AssertSqlSafe(unwelcome)).execute(&mut connection).await.unwrap();
    let before = scans_of_tables(&mut connection).await;
    let store = Store::open(directory.path(), &settings, Intent::Existing).await.unwrap();
    exercise::all(&store).await;
    drop(store);
    let after = scans_of_tables(&mut connection).await;
    let scanned: Vec<String> = after
        .into_iter()
        .filter(|(table, scans)| {
            before.get(table).copied().unwrap_or(0) < *scans && !SMALL.contains(&table.as_str())
        })
        .map(|(table, scans)| format!("{table}: {scans}"))
        .collect();
    // The estimate of a sweep reads these, once for each sweep.
    let estimated = [
        "artifacts",
        "checkpoints",
        "bundle_archives",
        "dataset_files",
        "recording_attempts",
        "recording_archives",
    ];
    let faults: Vec<&String> = scanned
        .iter()
        .filter(|line| !estimated.iter().any(|table| line.starts_with(&format!("{table}:"))))
        .collect();
    assert!(faults.is_empty(), "scanned: {faults:?}");
}

/// Scans of each table so far, when the connections of the store have ended: they report at their end.
async fn scans_of_tables(connection: &mut PgConnection) -> BTreeMap<String, i64> {
    let others = "SELECT COUNT(*) FROM pg_stat_activity WHERE datname = current_database() AND pid <> pg_backend_pid()";
    for _ in 0..100 {
        let open: i64 = sqlx::query_scalar(others).fetch_one(&mut *connection).await.unwrap();
        if open == 0 {
            break;
        }
        tokio::time::sleep(Duration::from_millis(50)).await;
    }
    sqlx::raw_sql("SELECT pg_stat_clear_snapshot()").execute(&mut *connection).await.unwrap();
    let rows =
        sqlx::query("SELECT relname::text AS name, seq_scan FROM pg_stat_user_tables").fetch_all(connection);
    rows.await.unwrap().iter().map(|row| (row.get("name"), row.get("seq_scan"))).collect()
}

#[tokio::test]
async fn every_foreign_key_of_a_sqlite_file_has_an_index() {
    let directory = tempfile::tempdir().unwrap();
    drop(Store::open(directory.path(), &settings(DatabaseAddress::Sqlite), Intent::Create).await.unwrap());
    let mut connection = sqlite_file(directory.path()).await;
    let keys = sqlx::query(
        r#"SELECT tables.name AS child, keys."from" AS child_column, keys.seq AS seq
           FROM sqlite_master AS tables JOIN pragma_foreign_key_list(tables.name) AS keys
           WHERE tables.type = 'table'"#,
    );
    let keys = keys.fetch_all(&mut connection).await.unwrap();
    assert!(keys.len() >= 15, "{}", keys.len());
    let mut faults = Vec::new();
    for key in keys {
        let (child, column): (String, String) = (key.get("child"), key.get("child_column"));
        assert_eq!(key.get::<i64, _>("seq"), 0, "{child}.{column}: keys of several columns are not judged");
        // An index that leaves out rows without a reference serves as well.
        let index: Option<String> = sqlx::query_scalar(
            "SELECT indexes.name FROM pragma_index_list($1) AS indexes
             JOIN pragma_index_info(indexes.name) AS columns
             LEFT JOIN sqlite_master AS text ON text.type = 'index' AND text.name = indexes.name
             WHERE columns.seqno = 0 AND columns.name = $2
               AND (indexes.partial = 0 OR text.sql LIKE '%) WHERE ' || $2 || ' IS NOT NULL')
             LIMIT 1",
        )
        .bind(&child)
        .bind(&column)
        .fetch_optional(&mut connection)
        .await
        .unwrap();
        if index.is_none() {
            faults.push(format!("{child}.{column}"));
        }
    }
    assert!(faults.is_empty(), "foreign keys without an index: {faults:?}");
}

#[tokio::test]
async fn every_foreign_key_of_a_postgres_database_has_an_index() {
    let url = test_postgres::database().await;
    let directory = tempfile::tempdir().unwrap();
    let settings = settings(DatabaseAddress::Postgres(url.clone()));
    drop(Store::open(directory.path(), &settings, Intent::Create).await.unwrap());
    let mut connection = PgConnection::connect(&url).await.unwrap();
    let keys = sqlx::query(
        "SELECT keys.conrelid::regclass::text || '.' || columns.attname::text AS place,
                array_length(keys.conkey, 1) AS columns,
                EXISTS (SELECT 1 FROM pg_index AS indexes
                        WHERE indexes.indrelid = keys.conrelid AND indexes.indkey[0] = keys.conkey[1]
                          AND (indexes.indpred IS NULL
                               OR pg_get_expr(indexes.indpred, indexes.indrelid)
                                  = '(' || columns.attname::text || ' IS NOT NULL)')) AS has_index
         FROM pg_constraint AS keys
         JOIN pg_attribute AS columns ON columns.attrelid = keys.conrelid AND columns.attnum = keys.conkey[1]
         WHERE keys.contype = 'f'",
    );
    let keys = keys.fetch_all(&mut connection).await.unwrap();
    assert!(keys.len() >= 15, "{}", keys.len());
    assert!(
        keys.iter().all(|key| key.get::<i32, _>("columns") == 1),
        "keys of several columns are not judged"
    );
    let faults: Vec<String> =
        keys.iter().filter(|key| !key.get::<bool, _>("has_index")).map(|key| key.get("place")).collect();
    assert!(faults.is_empty(), "foreign keys without an index: {faults:?}");
}
