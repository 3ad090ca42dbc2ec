//! No statement of the store reads a whole table: all that a store does ([`exercise`]) is run on a SQLite file, and
//! every statement of it is explained. A process with one test, as the statements are gathered from the log of the
//! process.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod exercise;
mod gathered;

use std::collections::BTreeSet;

use sqlx::sqlite::SqliteConnectOptions;
use sqlx::{AssertSqlSafe, Connection, Row, SqliteConnection};
use store::{BlobPlace, DatabaseAddress, Intent, Settings, Store};

fn settings(database: DatabaseAddress) -> Settings {
    Settings { database, fsync: false, blobs: BlobPlace::Memory, ..test_settings::section("store") }
}

async fn sqlite_file(directory: &std::path::Path) -> SqliteConnection {
    let options = SqliteConnectOptions::new().filename(directory.join("tabletopgen.sqlite"));
    SqliteConnection::connect_with(&options).await.unwrap()
}

/// Statements that may read a whole table, by a part of their text, and why.
const MAY_SCAN: [(&str, &str); 3] = [
    ("SELECT COUNT(*) FROM artifacts", "a sweep estimates its memory; nobody waits for it"),
    ("SELECT 1 FROM jobs LIMIT 1", "it reads one row"),
    ("SELECT 1 FROM api_keys LIMIT 1", "it reads one row"),
];

/// Statements that may read all rows of a tenant.
const MAY_READ_A_TENANT: [(&str, &str); 3] = [
    ("SUM(size)", "the sum of a quota is computed in the background, at most a twentieth of the time"),
    ("SELECT MAX(claimed_at) FROM jobs AS past", "it reads the last row of the index"),
    ("FROM tenant_limits WHERE tenant_id = $1", "a tenant has one row"),
];

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn no_statement_scans_a_table_of_a_sqlite_file() {
    gathered::begin();
    let directory = tempfile::tempdir().unwrap();
    let store =
        Store::open(directory.path(), &settings(DatabaseAddress::Sqlite), Intent::Create).await.unwrap();
    gathered::take();
    exercise::all(&store).await;
    let statements = gathered::take();
    let mut connection = sqlite_file(directory.path()).await;
    let partial: Vec<String> =
        sqlx::query_scalar("SELECT name FROM sqlite_master WHERE type = 'index' AND sql LIKE '%WHERE%'")
            .fetch_all(&mut connection)
            .await
            .unwrap();
    scans_are_recognized(&mut connection).await;
    let (mut faults, mut explained) = (Vec::new(), 0);
    for statement in statements {
        let word = statement.split_whitespace().next().unwrap_or_default().to_uppercase();
        if !["SELECT", "WITH", "UPDATE", "DELETE", "INSERT"].contains(&word.as_str()) {
            continue;
        }
        let plan = plan(&mut connection, &statement).await;
        explained += 1;
        let may_scan = MAY_SCAN.iter().any(|(part, _)| statement.contains(part));
        let scans = scans(&plan, &partial);
        if !may_scan && !scans.is_empty() {
            faults.push(format!("{scans:?} in {statement}"));
        }
        // A list ends at its limit; anything else that is sought by its tenant alone grows with the tenant.
        let may_read_tenant = MAY_READ_A_TENANT.iter().any(|(part, _)| statement.contains(part));
        let by_tenant = plan.iter().filter(|line| line.ends_with("(tenant_id=?)")).collect::<Vec<_>>();
        if !by_tenant.is_empty() && !statement.contains("LIMIT") && !may_read_tenant {
            faults.push(format!("{by_tenant:?} in {statement}"));
        }
        if statement.contains("> $1 OR (") {
            faults.push(format!("pages by OR, each of which reads what was read before: {statement}"));
        }
        // A later page begins where the one before ended.
        let pages = ["id < $", ") > ("].iter().any(|page| statement.contains(page));
        if pages
            && !plan.iter().any(|line| line.contains("id<?") || line.contains(">?") || line.contains(")>("))
        {
            faults.push(format!("pages are not sought, {plan:?} in {statement}"));
        }
    }
    assert!(explained > 120, "only {explained} statements were run");
    assert!(faults.is_empty(), "{} faults:\n{}", faults.len(), faults.join("\n\n"));
}

async fn plan(connection: &mut SqliteConnection, statement: &str) -> Vec<String> {
    let rows = sqlx::raw_sql(AssertSqlSafe(format!("EXPLAIN QUERY PLAN {statement}")))
        .fetch_all(connection)
        .await
        .unwrap_or_else(|error| panic!("{error}: {statement}"));
    rows.iter().map(|row| row.get::<String, _>("detail")).collect()
}

/// The lines of a plan that read all of a table, or all of an index that is not restricted to a few rows.
fn scans(plan: &[String], partial: &[String]) -> Vec<String> {
    let computed: BTreeSet<&str> = plan
        .iter()
        .filter_map(|line| line.strip_prefix("CO-ROUTINE ").or_else(|| line.strip_prefix("MATERIALIZE ")))
        .collect();
    let is_scan = |line: &&String| {
        let Some(rest) = line.strip_prefix("SCAN ") else { return false };
        let name = rest.split_whitespace().next().unwrap_or_default();
        let index =
            rest.split(" INDEX ").nth(1).map(|index| index.split_whitespace().next().unwrap_or_default());
        let is_row = rest == "CONSTANT ROW"
            || rest.contains("VIRTUAL TABLE")
            || rest.contains("VALUES CLAUSE")
            || rest.contains("-ROW");
        !is_row
            && !computed.contains(name)
            && !index.is_some_and(|index| partial.iter().any(|name| name == index))
    };
    plan.iter().filter(is_scan).cloned().collect()
}

/// The judge itself is judged.
async fn scans_are_recognized(connection: &mut SqliteConnection) {
    let partial = ["jobs_turns".to_owned()];
    for (statement, is_scan) in [
        ("SELECT id FROM scenes WHERE failure_message = 'x'", true),
        ("SELECT id FROM scenes WHERE labels = 'x' ORDER BY id", true),
        ("SELECT id FROM jobs INDEXED BY jobs_turns WHERE state = 'queued'", false),
        ("SELECT id FROM scenes WHERE id = $1", false),
    ] {
        let plan = plan(connection, statement).await;
        assert_eq!(!scans(&plan, &partial).is_empty(), is_scan, "{statement}: {plan:?}");
    }
}
