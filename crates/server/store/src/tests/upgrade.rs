//! Databases of earlier releases: work that waits or is in progress becomes jobs, and goes on.

use std::collections::BTreeSet;

use sqlx::Connection;
use sqlx::migrate::Migrator;
use sqlx::postgres::PgConnection;
use sqlx::sqlite::{SqliteConnectOptions, SqliteConnection};

use super::datasets::{dataset_of, freezing};
use super::recordings::{attempt_of, keep, made, recording};
use super::*;
use crate::datasets::DatasetState;
use crate::recordings::RecordingState;
use crate::scenes::SceneFilter;

/// The last migration before datasets and recordings became jobs.
const BEFORE_JOBS: i64 = 40;
const LEASE: Duration = Duration::from_secs(60);

/// Datasets that wait, are frozen, are verified, and are finished; recordings before their first attempt, with attempts
/// in progress, and before assembling.
const ROWS: &str = "
    INSERT INTO datasets (id, tenant_id, name, version, state, request, body_digest, created_at, owner, attempt, verify_state)
    VALUES ('d1', 'default', 'mugs', NULL, 'running', '{}', 'b', 1, 'dead', 2, NULL),
           ('d2', 'default', 'mugs', NULL, 'queued', '{}', 'b', 2, NULL, 0, NULL),
           ('d3', 'default', 'jugs', 1, 'finished', '{}', 'b', 3, 'dead', 1, 'running'),
           ('d4', 'default', 'cups', 1, 'finished', '{}', 'b', 4, NULL, 0, NULL);
    INSERT INTO recordings (id, tenant_id, scene_id, state, request, bundle, wanted, max_attempts, begun, made, successes,
                            body_digest, created_at)
    VALUES ('r1', 'default', 's', 'queued', '{}', 'DIGEST', 2, 50, 0, 0, 0, 'b', 1),
           ('r2', 'default', 's', 'running', '{}', 'DIGEST', 2, 50, 3, 1, 1, 'b', 2),
           ('r3', 'default', 's', 'running', '{}', 'DIGEST', 1, 50, 1, 1, 1, 'b', 3);
    INSERT INTO recording_attempts (recording_id, number, owner, token, lease_until, tries, outcome, unit, made_at)
    VALUES ('r2', 0, 'dead', 't', 0, 1, 'success', 'DIGEST', 5),
           ('r2', 1, 'dead', 't', 0, 1, NULL, NULL, NULL),
           ('r2', 2, 'dead', 't', 0, 1, NULL, NULL, NULL),
           ('r3', 0, 'dead', 't', 0, 1, 'success', 'DIGEST', 6);
    INSERT INTO scenes (id, tenant_id, state, request, summary, created_at, updated_at)
    VALUES ('s', 'default', 'ready', '{\"input\": {\"kind\": \"text\", \"text\": \"two mugs\"}}',
            '{\"objects\": 2, \"text\": {\"understood\": [{\"kind\": \"object\", \"category\": \"mug\"},
                                                      {\"kind\": \"object\", \"category\": \"mug\"}]}}', 1, 1),
           ('t', 'default', 'pending', '{}', NULL, 1, 1);
    INSERT INTO jobs (id, tenant_id, kind, scene_id, state, next_seq, created_at)
    VALUES ('j', 'default', 'generate', 's', 'succeeded', 3, 1);
    INSERT INTO events (job_id, seq, at, kind, data)
    VALUES ('j', 2, 6, 'job_succeeded', '{}'), ('j', 1, 7, 'job_queued', '{}');
    INSERT INTO recording_events (recording_id, seq, at, kind, data) VALUES ('r2', 1, 2, 'queued', '{}');";

/// The migrations of the release before.
fn earlier(migrator: &Migrator) -> Migrator {
    let earlier = migrator.iter().filter(|migration| migration.version <= BEFORE_JOBS).cloned().collect();
    Migrator { migrations: earlier, ..Migrator::DEFAULT }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn work_of_an_earlier_release_goes_on_as_jobs() {
    let digest = Digest::of(b"blob").to_string();
    let rows = ROWS.replace("DIGEST", &digest);
    let directory = tempfile::tempdir().expect("temporary directory");
    let path = directory.path().join(backup::DATABASE_FILE);
    let options = SqliteConnectOptions::new().filename(&path).create_if_missing(true);
    let mut connection = SqliteConnection::connect_with(&options).await.expect("connects");
    earlier(&migrations::SQLITE).run_direct(None, &mut connection, false).await.expect("migrates");
    sqlx::raw_sql(sqlx::AssertSqlSafe(rows.clone())).execute(&mut connection).await.expect("inserts");
    connection.close().await.expect("closes");
    goes_on(directory.path(), &settings(DatabaseAddress::Sqlite)).await;

    let url = test_postgres::database().await;
    let mut connection = PgConnection::connect(&url).await.expect("connects");
    earlier(&migrations::POSTGRES).run_direct(None, &mut connection, false).await.expect("migrates");
    sqlx::raw_sql(sqlx::AssertSqlSafe(rows)).execute(&mut connection).await.expect("inserts");
    connection.close().await.expect("closes");
    goes_on(directory.path(), &settings(DatabaseAddress::Postgres(url))).await;
}

async fn goes_on(data_dir: &Path, settings: &Settings) {
    let store = Store::open(data_dir, settings, Intent::Existing).await.expect("migrates");
    let mugs = SceneFilter {
        category: Some("mug".into()),
        min_objects: Some(2),
        limit: 9,
        ..SceneFilter::default()
    };
    let found = store.scenes(&DEFAULT_TENANT, mugs).await.expect("reads");
    assert_eq!(found.iter().map(|(scene, _)| scene.id.as_str()).collect::<Vec<_>>(), ["s"]);
    let events = store.tenant_events(&DEFAULT_TENANT, 0, 9).await.expect("reads");
    let numbers: Vec<_> = events.iter().map(|event| (event.position, event.event.seq)).collect();
    assert_eq!(numbers, [(1, 1), (2, 2), (3, 1)]);
    let claim = async |scope: &Scope| store.claim("a", LEASE, MAX_DEATHS, scope).await.expect("answers");

    let state = async |id: &str| {
        let id = id.parse().expect("an id");
        let row = store.dataset(&DEFAULT_TENANT, &id).await.expect("reads").expect("is there");
        (row.state, row.job_id.is_some())
    };
    assert_eq!(state("d1").await, (DatasetState::Queued, true));
    assert_eq!(state("d4").await, (DatasetState::Finished, false));
    let mut claimed = BTreeSet::new();
    while let Some(claim) = claim(&freezing()).await {
        let id = dataset_of(&claim).id.as_str().to_owned();
        let attempt = if id == "d1" { 2 } else { 1 };
        assert_eq!(claim.attempt, attempt, "the attempt of the dead process does not count");
        claimed.insert((id, claim.work.kind()));
    }
    let freeze = |id: &str| (id.to_owned(), JobKind::FreezeDataset);
    let expected = [freeze("d1"), ("d3".to_owned(), JobKind::VerifyDataset)];
    assert_eq!(claimed, BTreeSet::from(expected), "the second freeze of the name waits");

    let mut attempts = BTreeSet::new();
    let mut assembled = Vec::new();
    while let Some(claim) = claim(&recording()).await {
        match &claim.work {
            queue::ClaimedWork::AssembleRecording(recording) => assembled.push(recording.id.to_string()),
            queue::ClaimedWork::RecordAttempt(work) => {
                let id = work.recording.id.to_string();
                let attempt = attempt_of(claim);
                attempts.insert((id.clone(), attempt.number));
                let outcome = if (id.as_str(), attempt.number) == ("r2", 1) { "slipped" } else { "success" };
                keep(&store, &attempt, made(outcome)).await.expect("keeps");
            }
            other => panic!("{other:?}"),
        }
    }
    let attempt = |id: &str, number| (id.to_owned(), number);
    let first = [attempt("r1", 0), attempt("r1", 1), attempt("r2", 1), attempt("r2", 2)];
    assert!(attempts.is_superset(&BTreeSet::from(first)), "{attempts:?}");
    assembled.sort();
    assert_eq!(assembled, ["r1", "r2", "r3"]);
    let id = "r2".parse().expect("an id");
    let row = store.recording(&DEFAULT_TENANT, &id).await.expect("reads").expect("is there");
    assert_eq!((row.state, row.made >= 3, row.successes >= 2), (RecordingState::Running, true, true));
}
