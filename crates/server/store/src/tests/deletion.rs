//! Deletion of datasets, batches and recordings: work on them stops, sweeps remove their rows and blobs, and what
//! others need stays.

use ::batches::BatchState;
use sqlx::AssertSqlSafe;

use super::batches::{batch_of, built, failed, feed};
use super::datasets::{dataset_of, file, freezing, frozen, submitted_dataset};
use super::recordings::{assembly, attempt, keep, made, submitted as ordered, work};
use super::*;
use crate::batches::{BatchCancelOutcome, BatchFilter, BatchRetryOutcome, BatchScenes};
use crate::database::Dialect;
use crate::datasets::{DatasetFilter, VerifyOutcome};
use crate::deletion::DeleteOutcome;
use crate::jobs::RetryOutcome;
use crate::lifecycle::SceneState;
use crate::queue::AttemptOutcome;
use crate::recordings::{
    ArchivePart, CancelRecordingOutcome, RecordingArchive, RecordingFile, RecordingFilter,
};
use crate::retention::{ResourceRemovals, RetentionSettings, SweepReport};
use crate::scenes::SceneFilter;
use scene::{BatchId, DatasetId, RecordingId};

const LEASE: Duration = Duration::from_secs(60);

/// Nothing is young, and nothing stays after its deletion.
fn retention() -> RetentionSettings {
    RetentionSettings {
        grace_secs: 0,
        intermediate_hours: 0,
        quarantined_hours: 0,
        deleted_hours: 0,
        ..test_settings::section("store.retention")
    }
}

async fn sweep_by(store: &Store, settings: &RetentionSettings) -> SweepReport {
    // Files have the time of the last tick, which may be the present one.
    tokio::time::sleep(Duration::from_millis(20)).await;
    store.sweep(settings, false).await.expect("sweeps").expect("no backup is under way")
}

async fn sweep(store: &Store) -> SweepReport {
    sweep_by(store, &retention()).await
}

/// A sweep a moment after a deletion: contents go, last rows stay.
async fn early_sweep(store: &Store) -> SweepReport {
    sweep_by(store, &RetentionSettings { deleted_hours: 1, ..retention() }).await
}

fn removals(emptied: u64, purged: u64) -> ResourceRemovals {
    ResourceRemovals { expired: 0, emptied, purged }
}

async fn put(store: &Store, content: &str) {
    store.blobs().put(content.to_owned()).await.expect("puts");
}

async fn has(store: &Store, content: &str) -> bool {
    store.blobs().contains(&Digest::of(content.as_bytes())).await.expect("answers")
}

async fn claim_freeze(store: &Store) -> Claim {
    store.claim("a", LEASE, MAX_DEATHS, &freezing()).await.expect("answers").expect("there is work")
}

/// Freezes a version with a file of its own and one that all versions have.
async fn version(store: &Store, name: &str, number: i64) -> DatasetId {
    let id = submitted_dataset(store, name).await;
    let claim = claim_freeze(store).await;
    assert_eq!(dataset_of(&claim).id, id);
    let own = format!("shard of {name} {number}");
    for (path, content) in [("shared", "shared"), ("own", own.as_str())] {
        put(store, content).await;
        store.record_dataset_file(&claim.lease, file(path, content.as_bytes())).await.expect("records");
    }
    store.finish(&claim.lease, frozen(number, &["shared", "own"])).await.expect("finishes");
    id
}

async fn delete_dataset(store: &Store, id: &DatasetId) {
    for _ in 0..2 {
        let deleted = store.delete_dataset(&DEFAULT_TENANT, id).await.expect("answers");
        assert_eq!(deleted, DeleteOutcome::Done, "deleting twice is fine");
    }
}

async fn is_known(store: &Store, id: &DatasetId) -> bool {
    store.dataset(&DEFAULT_TENANT, id).await.expect("reads").is_some()
}

async fn delete_recording(store: &Store, id: &RecordingId) {
    for _ in 0..2 {
        let deleted = store.delete_recording(&DEFAULT_TENANT, id).await.expect("answers");
        assert_eq!(deleted, DeleteOutcome::Done, "deleting twice is fine");
    }
}

async fn delete_batch(store: &Store, id: &BatchId, scenes: BatchScenes) {
    for _ in 0..2 {
        let deleted = store.delete_batch(&DEFAULT_TENANT, id, scenes).await.expect("answers");
        assert_eq!(deleted, DeleteOutcome::Done, "deleting twice is fine");
    }
}

pub(super) async fn a_dataset_that_is_deleted_stops_and_goes(place: Place) {
    let store = place.store();
    let stranger: TenantId = "other".parse().expect("an id");
    let id = submitted_dataset(store, "mugs").await;
    let claim = claim_freeze(store).await;
    put(store, "one").await;
    store.record_dataset_file(&claim.lease, file("one", b"one")).await.expect("records");
    let other = store.delete_dataset(&stranger, &id).await.expect("answers");
    assert_eq!(other, DeleteOutcome::NotFound);
    delete_dataset(store, &id).await;
    let renewed = store.renew(vec![claim.lease.clone()], LEASE).await.expect("answers");
    assert_eq!(renewed[0].1, Some(JobState::Cancelling), "its worker hears of it");
    let row = store.dataset(&DEFAULT_TENANT, &id).await.expect("reads").expect("says that it is deleted");
    assert!(row.is_deleted);
    let all = DatasetFilter { limit: 9, ..DatasetFilter::default() };
    assert_eq!(store.datasets(&DEFAULT_TENANT, all).await.expect("reads"), []);
    let report = sweep(store).await;
    assert_eq!(report.datasets, removals(0, 0), "its worker has not stopped yet");
    let state = store.finish(&claim.lease, frozen(1, &["one"])).await.expect("ends");
    assert_eq!(state, JobState::Cancelled, "the version came too late");
    let retried = store.retry(&DEFAULT_TENANT, &claim.lease.job_id, None).await.expect("answers");
    assert_eq!(retried, RetryOutcome::NothingToRepeat);
    let verified = store.verify_dataset(&DEFAULT_TENANT, &id).await.expect("answers");
    assert_eq!(verified, VerifyOutcome::NotFound);
    assert_eq!(early_sweep(store).await.datasets, removals(0, 0), "a cancelled freeze has dropped its files");
    assert!(is_known(store, &id).await && !has(store, "one").await);
    assert_eq!(sweep(store).await.datasets, removals(0, 1));
    assert!(!is_known(store, &id).await);
    assert_eq!(store.job(&DEFAULT_TENANT, &claim.lease.job_id).await.expect("reads"), None);
    let gone = store.delete_dataset(&DEFAULT_TENANT, &id).await.expect("answers");
    assert_eq!(gone, DeleteOutcome::NotFound);
    // One that waits ends at once.
    let waiting = submitted_dataset(store, "mugs").await;
    delete_dataset(store, &waiting).await;
    assert_eq!(store.claim("a", LEASE, MAX_DEATHS, &freezing()).await.expect("answers"), None);
    assert_eq!(sweep(store).await.datasets, removals(0, 1));
}

pub(super) async fn a_version_stays_whole_when_others_and_its_scenes_go(place: Place) {
    let store = place.store();
    let scene = submitted(store).await.0;
    let job = claimed(store, "w").await;
    store.finish(&job.lease, built(true)).await.expect("finishes");
    let (first, second) = (version(store, "mugs", 1).await, version(store, "mugs", 2).await);
    // The same set again: the version has another row, with the same files.
    let again = submitted_dataset(store, "mugs").await;
    let claim = claim_freeze(store).await;
    let earlier = store.latest_version(&DEFAULT_TENANT, "mugs").await.expect("reads").expect("a version");
    assert_eq!(earlier.id, second);
    store.share_dataset_files(&claim.lease, &earlier).await.expect("shares");
    store.finish(&claim.lease, frozen(2, &["shared", "own"])).await.expect("finishes");
    // A row with the same number is enough to remember it.
    store.delete_scene(&DEFAULT_TENANT, &scene).await.expect("deletes");
    delete_dataset(store, &first).await;
    delete_dataset(store, &second).await;
    assert_eq!(sweep(store).await.datasets, removals(2, 2));
    assert_eq!(store.dataset_files(&again).await.expect("reads").len(), 2);
    assert!(has(store, "shared").await && has(store, "shard of mugs 2").await);
    assert!(!has(store, "shard of mugs 1").await);

    // Files of a version that is deleted are not shared, as a sweep may have taken some.
    let earlier = store.latest_version(&DEFAULT_TENANT, "mugs").await.expect("reads").expect("a version");
    submitted_dataset(store, "mugs").await;
    let claim = claim_freeze(store).await;
    delete_dataset(store, &again).await;
    let late = store.share_dataset_files(&claim.lease, &earlier).await;
    assert!(matches!(late, Err(StoreError::VersionGone)), "{late:?}");
}

pub(super) async fn a_number_of_a_version_is_not_used_again(place: Place) {
    let store = place.store();
    let highest = async || store.highest_version(&DEFAULT_TENANT, "mugs").await.expect("reads");
    assert_eq!(highest().await, 0);
    let (first, second) = (version(store, "mugs", 1).await, version(store, "mugs", 2).await);
    let third = version(store, "mugs", 3).await;
    delete_dataset(store, &third).await;
    assert_eq!(sweep(store).await.datasets, removals(1, 0), "its number is remembered");
    let latest = store.latest_version(&DEFAULT_TENANT, "mugs").await.expect("reads").expect("a version");
    assert_eq!((latest.id, highest().await), (second.clone(), 3));
    delete_dataset(store, &second).await;
    assert_eq!(sweep(store).await.datasets, removals(1, 1), "a lower number need not be");
    delete_dataset(store, &first).await;
    assert_eq!(sweep(store).await.datasets, removals(1, 2));
    assert_eq!(highest().await, 0, "nothing of the name is left");
}

/// Records a dataset of one episode.
async fn recorded(store: &Store) -> RecordingId {
    let id = ordered(store, 1, 50).await;
    let lease = attempt(store, "a").await;
    put(store, "unit").await;
    keep(store, &lease, made("success")).await.expect("keeps");
    let lease = assembly(store, "a").await;
    let part = format!("part of {id}");
    put(store, &part).await;
    let digest = Digest::of(part.as_bytes());
    store.begin_assembly(&lease).await.expect("begins");
    let archive = RecordingArchive {
        format: "robomimic".into(),
        digest: Some(digest.clone()),
        size: 4,
        files: 1,
        parts: vec![ArchivePart { digest: digest.clone(), size: 4 }],
    };
    store.record_recording_archive(&lease, archive).await.expect("records");
    let recorded = RecordingFile { path: "robomimic/a".into(), digest, start: 0, size: 4 };
    store.record_recording_files(&lease, 0, vec![recorded]).await.expect("records");
    store.finish(&lease, AttemptOutcome::Assembled(json!({}))).await.expect("finishes");
    id
}

pub(super) async fn a_recording_that_is_deleted_stops_and_goes(place: Place) {
    let store = place.store();
    let stranger: TenantId = "other".parse().expect("an id");
    let id = recorded(store).await;
    let other = store.delete_recording(&stranger, &id).await.expect("answers");
    assert_eq!(other, DeleteOutcome::NotFound);
    let running = ordered(store, 1, 50).await;
    let open = attempt(store, "a").await;
    for id in [&id, &running] {
        delete_recording(store, id).await;
        let row =
            store.recording(&DEFAULT_TENANT, id).await.expect("reads").expect("says that it is deleted");
        assert!(row.is_deleted);
        let late = store.cancel_recording(&DEFAULT_TENANT, id).await.expect("answers");
        assert_eq!(late, CancelRecordingOutcome::NotFound);
    }
    let late = keep(store, &open, made("success")).await;
    assert!(matches!(late, Err(StoreError::LeaseLost { .. })), "{late:?}");
    assert_eq!(work(store, "a").await, None);
    let all = RecordingFilter { limit: 9, ..RecordingFilter::default() };
    assert_eq!(store.recordings(&DEFAULT_TENANT, all).await.expect("reads"), []);
    assert_eq!(early_sweep(store).await.recordings, removals(1, 0));
    assert_eq!(store.recording_archives(&id).await.expect("reads"), []);
    assert!(!has(store, &format!("part of {id}")).await);
    let events = store.recording_events(&DEFAULT_TENANT, &id, 0, 99).await.expect("reads");
    assert!(!events.is_empty(), "they tell how it ended");
    assert_eq!(sweep(store).await.recordings, removals(0, 2));
    assert_eq!(store.recording(&DEFAULT_TENANT, &id).await.expect("reads"), None);
    let gone = store.delete_recording(&DEFAULT_TENANT, &id).await.expect("answers");
    assert_eq!(gone, DeleteOutcome::NotFound);
}

/// A batch of three requests: one is made, one has failed, one is being made.
async fn begun_batch(store: &Store) -> (BatchId, Claim) {
    let id = batch_of(store, 3).await;
    feed(store, &id, 10).await;
    for outcome in [built(true), failed()] {
        let claim = claimed(store, "worker").await;
        store.finish(&claim.lease, outcome).await.expect("finishes");
    }
    feed(store, &id, 10).await;
    (id, claimed(store, "worker").await)
}

async fn scenes(store: &Store) -> usize {
    let all = SceneFilter { limit: 99, ..SceneFilter::default() };
    store.scenes(&DEFAULT_TENANT, all).await.expect("reads").len()
}

pub(super) async fn a_batch_that_is_deleted_leaves_its_scenes_unless_they_go_with_it(place: Place) {
    let store = place.store();
    let stranger: TenantId = "other".parse().expect("an id");
    let (kept, running) = begun_batch(store).await;
    let other = store.delete_batch(&stranger, &kept, BatchScenes::Delete).await.expect("answers");
    assert_eq!(other, DeleteOutcome::NotFound);
    delete_batch(store, &kept, BatchScenes::Keep).await;
    let row = store.batch(&DEFAULT_TENANT, &kept).await.expect("reads").expect("says that it is deleted");
    assert_eq!((row.is_deleted, row.state), (true, BatchState::Cancelling));
    let all = BatchFilter { limit: 9, ..BatchFilter::default() };
    assert_eq!(store.batches(&DEFAULT_TENANT, all).await.expect("reads"), []);
    let late = store.cancel_batch(&DEFAULT_TENANT, &kept).await.expect("answers");
    assert_eq!(late, BatchCancelOutcome::NotFound);
    let late = store.retry_batch(&DEFAULT_TENANT, &kept, None).await.expect("answers");
    assert_eq!(late, BatchRetryOutcome::NotFound);
    assert_eq!(sweep(store).await.batches, removals(0, 0), "a request is still stopping");
    store.finish(&running.lease, AttemptOutcome::Stopped).await.expect("stops");
    // A job that is repeated on its own does not bring the batch back.
    let retried = store.retry(&DEFAULT_TENANT, &running.lease.job_id, None).await.expect("retries");
    assert!(matches!(retried, RetryOutcome::Created { .. }), "{retried:?}");
    let again = claimed(store, "worker").await;
    store.finish(&again.lease, built(true)).await.expect("finishes");
    feed(store, &kept, 10).await;
    assert_eq!(early_sweep(store).await.batches, removals(1, 0));
    assert_eq!(sweep(store).await.batches, removals(0, 1));
    assert_eq!(store.batch(&DEFAULT_TENANT, &kept).await.expect("reads"), None);
    assert_eq!(scenes(store).await, 3);

    let (whole, running) = begun_batch(store).await;
    assert_eq!(scenes(store).await, 6);
    delete_batch(store, &whole, BatchScenes::Delete).await;
    assert_eq!(scenes(store).await, 3, "those of the other batch");
    let scene = running.scene().expect("a scene").scene_id.clone();
    let row = store.scene(&DEFAULT_TENANT, &scene).await.expect("reads").expect("says that it is deleted");
    assert_eq!(row.state, SceneState::Deleted);
    feed(store, &whole, 10).await;
    assert_eq!(sweep(store).await.batches, removals(1, 1), "it need not wait for its jobs");
    store.finish(&running.lease, AttemptOutcome::Stopped).await.expect("stops");
    sweep(store).await;
    assert_eq!(store.scene(&DEFAULT_TENANT, &scene).await.expect("reads"), None);
}

pub(super) async fn scenes_left_by_a_dead_process_go_with_their_batch(place: Place) {
    let store = place.store();
    let (id, running) = begun_batch(store).await;
    store.finish(&running.lease, built(true)).await.expect("finishes");
    feed(store, &id, 10).await;
    // The mark alone, as after the first transaction.
    let batch = id.clone();
    let marked = store.writer.write("mark a batch", move |connection| {
        Box::pin(async move {
            sqlx::query("UPDATE batches SET deleted_at = 1, deletes_scenes = 1 WHERE id = $1")
                .bind(batch.as_str())
                .execute(connection)
                .await?;
            Ok(())
        })
    });
    marked.await.expect("marks");
    assert_eq!(scenes(store).await, 3);
    // By the settings the last rows stay an hour, however slow this sweep is.
    let report = early_sweep(store).await;
    assert_eq!((report.batches, report.stripped_scenes), (removals(1, 1), 3));
    assert_eq!(scenes(store).await, 0);
    assert_eq!(sweep(store).await.purged_scenes, 3);
}

/// Moves every end so many hours back.
async fn pass_hours(store: &Store, hours: i64) {
    let aged = store.writer.write("age what has ended", move |connection| {
        Box::pin(async move {
            for table in ["batches", "datasets", "recordings", "jobs"] {
                let sql = format!("UPDATE {table} SET finished_at = finished_at - $1");
                sqlx::query(AssertSqlSafe(sql)).bind(hours * 3_600_000).execute(&mut *connection).await?;
            }
            Ok(())
        })
    });
    aged.await.expect("ages");
}

pub(super) async fn what_has_ended_goes_after_its_time(place: Place) {
    let store = place.store();
    let (batch, running) = begun_batch(store).await;
    store.finish(&running.lease, built(true)).await.expect("finishes");
    feed(store, &batch, 10).await;
    let version = version(store, "mugs", 1).await;
    for _ in 0..2 {
        store.verify_dataset(&DEFAULT_TENANT, &version).await.expect("enqueues");
        let claim = claim_freeze(store).await;
        store.finish(&claim.lease, AttemptOutcome::Verified(json!({}))).await.expect("finishes");
    }
    submitted_dataset(store, "jugs").await;
    store.finish(&claim_freeze(store).await.lease, failed()).await.expect("fails");
    recorded(store).await;
    let cancelled = ordered(store, 1, 50).await;
    store.cancel_recording(&DEFAULT_TENANT, &cancelled).await.expect("cancels");

    let settings = RetentionSettings {
        ended_batch_hours: 10,
        failed_recording_hours: 10,
        failed_dataset_hours: 10,
        dataset_job_hours: 10,
        deleted_hours: 1,
        ..retention()
    };
    let ends = |report: &SweepReport| {
        let expired = [report.batches, report.datasets, report.recordings].map(|removals| removals.expired);
        (expired, report.dataset_jobs)
    };
    pass_hours(store, 9).await;
    assert_eq!(ends(&sweep_by(store, &settings).await), ([0; 3], 0));
    pass_hours(store, 2).await;
    assert_eq!(ends(&sweep_by(store, &retention()).await), ([0; 3], 0), "0 keeps all");
    let dry = store.sweep(&settings, true).await.expect("counts").expect("runs");
    assert_eq!(ends(&dry), ([1; 3], 2));
    let report = sweep_by(store, &settings).await;
    assert_eq!(ends(&report), ([1; 3], 2), "the freeze and the first verification go, the last one stays");
    assert_eq!(report.batches, ResourceRemovals { expired: 1, emptied: 1, purged: 0 });
    assert_eq!(ends(&sweep_by(store, &settings).await), ([0; 3], 0));
    assert_eq!(scenes(store).await, 3, "scenes outlive their batch");
    assert_eq!(store.dataset_files(&version).await.expect("reads").len(), 2);
    let report = sweep(store).await;
    assert_eq!([report.batches, report.datasets, report.recordings], [removals(0, 1); 3]);
}

/// Number of rows of every table.
async fn rows(store: &Store) -> BTreeMap<String, i64> {
    let tables = match store.readers.dialect() {
        Dialect::Sqlite => "SELECT name FROM sqlite_master WHERE type = 'table' AND name NOT LIKE 'sqlite%'",
        Dialect::Postgres => {
            "SELECT table_name::text FROM information_schema.tables WHERE table_schema = current_schema()"
        }
    };
    let tables: Vec<String> = sqlx::query_scalar(tables).fetch_all(&store.readers).await.expect("lists");
    let mut rows = BTreeMap::new();
    for table in tables {
        let sql = format!("SELECT COUNT(*) FROM {table}");
        let count = sqlx::query_scalar(AssertSqlSafe(sql)).fetch_one(&store.readers).await.expect("counts");
        rows.insert(table, count);
    }
    rows
}

pub(super) async fn all_rows_and_blobs_go_with_what_is_deleted(place: Place) {
    const COUNT: usize = 10;
    let store = place.store();
    put(store, "unused").await;
    sweep(store).await;
    let before = rows(store).await;
    let mut scenes = Vec::new();
    for index in 0..COUNT {
        let labels = BTreeMap::from([("place".to_owned(), index.to_string())]);
        let SubmitOutcome::Created { scene_id, .. } =
            store.submit(NewScene { labels, ..new_scene() }).await.expect("submits")
        else {
            panic!("no key")
        };
        let claim = claimed(store, "worker").await;
        let output = format!("output {index}");
        put(store, &output).await;
        let checkpoint = Checkpoint { output: Digest::of(output.as_bytes()), ..checkpoint() };
        store.stage_finished(&claim.lease, &stage(&output), &checkpoint, false).await.expect("commits");
        store.finish(&claim.lease, built(index % 2 == 0)).await.expect("finishes");
        scenes.push(scene_id);
    }
    let (mut batches, mut datasets, mut recordings) = (Vec::new(), Vec::new(), Vec::new());
    for index in 0..COUNT {
        let (batch, running) = begun_batch(store).await;
        store.finish(&running.lease, built(true)).await.expect("finishes");
        feed(store, &batch, 10).await;
        batches.push(batch);
        datasets.push(version(store, &format!("set{}", index / 3), (index % 3) as i64 + 1).await);
        recordings.push(recorded(store).await);
    }
    assert_eq!(sweep(store).await.removed.blobs, 1, "the unit of the recordings, which are made");
    for id in &scenes {
        store.delete_scene(&DEFAULT_TENANT, id).await.expect("deletes");
    }
    for id in &batches {
        delete_batch(store, id, BatchScenes::Delete).await;
    }
    for id in &datasets {
        delete_dataset(store, id).await;
    }
    for id in &recordings {
        delete_recording(store, id).await;
    }
    let dry = store.sweep(&retention(), true).await.expect("counts").expect("runs");
    assert_eq!((dry.batches.emptied, dry.datasets.emptied, dry.recordings.emptied), (10, 10, 10));
    // The highest number of a name goes when those below it are gone, which may take another sweep.
    sweep(store).await;
    let last = sweep(store).await;
    assert_eq!(rows(store).await, before);
    assert_eq!((last.kept.blobs, last.removed.blobs), (0, 0));
}
