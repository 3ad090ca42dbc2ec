//! Scenes that come and go, and what stays of them.

use std::collections::BTreeMap;
use std::time::Duration;

use serde_json::json;

use super::super::artifacts::{ArchiveRow, BuiltScene, FileRow};
use super::super::checkpoints::{Checkpoint, StageKey};
use super::super::executions::{ExecutionAnswer, NewExecution, SubmitExecutionOutcome};
use super::super::queue::{AttemptOutcome, Scope};
use super::super::scenes::{NewScene, SubmitOutcome};
use super::super::{BlobPlace, DEFAULT_TENANT, DatabaseAddress, Intent, Settings};
use super::*;
use crate::lifecycle::JobState;
use crate::limits::{Admission, Limit, LimitChange, LimitSettings};
use scene::{JobId, SceneId};

/// Nothing is young.
fn retention() -> RetentionSettings {
    RetentionSettings {
        sweep_interval_secs: 0,
        grace_secs: 0,
        intermediate_hours: 0,
        quarantined_hours: 0,
        deleted_hours: 24,
        ended_batch_hours: 0,
        failed_recording_hours: 0,
        failed_dataset_hours: 0,
        dataset_job_hours: 0,
        delivery_hours: 1,
    }
}

/// A store with blobs in files, and its directory.
type Opened = (tempfile::TempDir, Store);

async fn opened(database: DatabaseAddress) -> Opened {
    let directory = tempfile::tempdir().expect("temporary directory");
    let settings: Settings = test_settings::section("store");
    let settings =
        Settings { database, fsync: false, blobs: BlobPlace::Files, retention: retention(), ..settings };
    let store = Store::open(directory.path(), &settings, Intent::Create).await.expect("opens");
    (directory, store)
}

/// Every case runs on both databases.
macro_rules! on_both_databases {
    ($($case:ident,)+) => {
        mod sqlite {
            $(#[tokio::test]
            async fn $case() {
                super::$case(super::opened(super::DatabaseAddress::Sqlite).await).await;
            })+
        }

        #[cfg(feature = "postgres")]
        mod postgres {
            $(#[tokio::test]
            async fn $case() {
                let address = super::DatabaseAddress::Postgres(test_postgres::database().await);
                super::$case(super::opened(address).await).await;
            })+
        }
    };
}

on_both_databases! {
    deleted_scenes_free_what_no_other_scene_uses,
    young_blobs_and_those_of_active_jobs_stay,
    old_intermediates_go_and_the_bundle_stays,
    bundles_of_quarantined_scenes_end,
    answers_of_executions_stay_for_their_time,
    the_image_of_a_request_stays_with_its_scene,
    a_checkpoint_that_was_removed_is_not_reused,
    usage_counts_each_blob_once_and_the_quota_compares,
    one_process_at_a_time_takes_the_turn,
    the_database_shrinks_with_its_scenes,
    checkpoints_that_no_job_names_go,
}

async fn submitted(store: &Store, request: serde_json::Value) -> (SceneId, JobId) {
    let new = NewScene {
        tenant_id: DEFAULT_TENANT.clone(),
        parent_id: None,
        request,
        labels: BTreeMap::new(),
        budget_micro_usd: 0,
        idempotency: None,
    };
    match store.submit(new).await.expect("submits") {
        SubmitOutcome::Created { scene_id, job_id, .. } => (scene_id, job_id),
        other => panic!("{other:?}"),
    }
}

fn file(name: &str, digest: &Digest, size: u64) -> FileRow {
    FileRow { name: name.into(), digest: digest.clone(), media_type: "text/plain".into(), size }
}

/// A stage with one artifact, common to all scenes that name the same key.
async fn stage(store: &Store, lease: &super::super::Lease, key: &str) -> (StageKey, Checkpoint) {
    let artifact = store.blobs().put(format!("artifact of {key}")).await.expect("puts");
    let output = store.blobs().put(format!("output of {key}")).await.expect("puts");
    let stage = StageKey {
        tenant_id: DEFAULT_TENANT.clone(),
        stage: key.into(),
        version: 1,
        instance: String::new(),
        key: Digest::of(key.as_bytes()),
    };
    let known = store.checkpoint(&stage).await.expect("reads");
    let cached = known.is_some();
    let checkpoint = known.unwrap_or_else(|| Checkpoint {
        output,
        artifacts: vec![file(&format!("{key}/note.txt"), &artifact, 10)],
        elapsed_ms: 1,
    });
    store.stage_finished(lease, &stage, &checkpoint, cached).await.expect("commits");
    (stage, checkpoint)
}

/// A finished scene with these stages and a bundle of its own.
async fn built(store: &Store, stages: &[&str], passed: bool) -> SceneId {
    let (scene_id, job_id) = submitted(store, json!({ "seed": 1 })).await;
    let claim =
        store.claim("worker", Duration::from_secs(60), 3, &Scope::Job(job_id.clone())).await.expect("claims");
    let lease = claim.expect("a job").lease;
    for key in stages {
        stage(store, &lease, key).await;
    }
    let bundle = store.blobs().put(format!("bundle of {scene_id}")).await.expect("puts");
    let built = BuiltScene {
        files: vec![file("scene.json", &Digest::of(b"inside"), 6)],
        archive: ArchiveRow { digest: bundle, size: 100 },
        passed,
        reasons: Vec::new(),
        summary: json!({}),
        metrics: json!({}),
    };
    let state = store.finish(&lease, AttemptOutcome::Built(Box::new(built))).await.expect("finishes");
    assert_eq!(state, JobState::Succeeded);
    scene_id
}

/// Moves the last change of every scene and the end of every job so many hours back.
async fn pass_hours(store: &Store, hours: i64) {
    let aged = store.writer.write("age scenes", move |connection| {
        Box::pin(async move {
            sqlx::query("UPDATE scenes SET updated_at = updated_at - $1, stripped_at = stripped_at - $2")
                .bind(hours * 3_600_000)
                .bind(hours * 3_600_000)
                .execute(&mut *connection)
                .await?;
            sqlx::query("UPDATE jobs SET finished_at = finished_at - $1")
                .bind(hours * 3_600_000)
                .execute(connection)
                .await?;
            Ok(())
        })
    });
    aged.await.expect("ages");
}

async fn sweep(store: &Store, settings: &RetentionSettings) -> SweepReport {
    store.sweep(settings, false).await.expect("sweeps").expect("no backup is under way")
}

async fn has(store: &Store, text: &str) -> bool {
    store.blobs().contains(&Digest::of(text.as_bytes())).await.expect("answers")
}

async fn deleted_scenes_free_what_no_other_scene_uses((directory, store): Opened) {
    let first = built(&store, &["common", "of_first"], true).await;
    let second = built(&store, &["common", "of_second"], true).await;
    let report = sweep(&store, &retention()).await;
    assert_eq!((report.removed.blobs, report.kept.blobs), (0, 8), "3 stages of 2 blobs and 2 bundles");

    store.delete_scene(&DEFAULT_TENANT, &first).await.expect("deletes");
    let dry = store.sweep(&retention(), true).await.expect("counts").expect("runs");
    assert_eq!((dry.stripped_scenes, dry.removed.blobs), (1, 0));
    assert!(has(&store, "output of of_first").await, "a dry run removes nothing");
    let report = sweep(&store, &retention()).await;
    assert_eq!((report.stripped_scenes, report.removed.blobs, report.kept.blobs), (1, 3, 5));
    assert!(!has(&store, "output of of_first").await && !has(&store, &format!("bundle of {first}")).await);
    assert!(has(&store, "artifact of common").await && has(&store, "output of common").await);
    assert_eq!(store.artifacts(&DEFAULT_TENANT, &second).await.expect("reads").len(), 2);
    assert!(
        store.scene(&DEFAULT_TENANT, &first).await.expect("reads").is_some(),
        "it says that it is deleted"
    );

    store.delete_scene(&DEFAULT_TENANT, &second).await.expect("deletes");
    let report = sweep(&store, &retention()).await;
    assert_eq!((report.removed.blobs, report.kept.blobs), (5, 0));
    assert_eq!(report.purged_scenes, 0);
    pass_hours(&store, 25).await;
    assert_eq!(sweep(&store, &retention()).await.purged_scenes, 2);
    for table in ["scenes", "jobs", "events", "stages", "checkpoints", "artifacts", "bundle_files"] {
        let sql = format!("SELECT COUNT(*) FROM {table}");
        let count: i64 =
            sqlx::query_scalar(sqlx::AssertSqlSafe(sql)).fetch_one(&store.readers).await.expect("counts");
        assert_eq!(count, 0, "{table}");
    }
    let left: Vec<_> = walk(&directory.path().join("blobs"));
    assert_eq!(left, ["sweep.lock"], "no file is left");
}

fn walk(folder: &std::path::Path) -> Vec<String> {
    let mut names = Vec::new();
    for entry in std::fs::read_dir(folder).expect("lists") {
        let entry = entry.expect("lists");
        if entry.path().is_dir() {
            names.extend(walk(&entry.path()));
        } else {
            names.push(entry.file_name().to_string_lossy().into_owned());
        }
    }
    names
}

async fn young_blobs_and_those_of_active_jobs_stay((_directory, store): Opened) {
    let unreferenced = store.blobs().put("no row yet").await.expect("puts");
    let with_grace = RetentionSettings { grace_secs: 600, ..retention() };
    sweep(&store, &with_grace).await;
    assert!(store.blobs().contains(&unreferenced).await.expect("answers"));

    let (scene_id, job_id) = submitted(&store, json!({})).await;
    let claim =
        store.claim("worker", Duration::from_secs(60), 3, &Scope::Job(job_id.clone())).await.expect("claims");
    let lease = claim.expect("a job").lease;
    stage(&store, &lease, "alpha").await;
    store.delete_scene(&DEFAULT_TENANT, &scene_id).await.expect("deletes");
    let report = sweep(&store, &retention()).await;
    assert_eq!((report.stripped_scenes, report.removed.blobs), (0, 1), "the worker has not stopped yet");
    store.finish(&lease, AttemptOutcome::Stopped).await.expect("stops");
    assert_eq!(sweep(&store, &retention()).await.removed.blobs, 2);
}

async fn old_intermediates_go_and_the_bundle_stays((_directory, store): Opened) {
    let scene = built(&store, &["alpha"], true).await;
    let settings = RetentionSettings { intermediate_hours: 48, ..retention() };
    pass_hours(&store, 47).await;
    assert_eq!(sweep(&store, &settings).await.stripped_scenes, 0);
    pass_hours(&store, 2).await;
    let report = sweep(&store, &settings).await;
    assert_eq!((report.stripped_scenes, report.removed.blobs, report.kept.blobs), (1, 2, 1));
    assert!(has(&store, &format!("bundle of {scene}")).await);
    assert!(store.artifacts(&DEFAULT_TENANT, &scene).await.expect("reads").is_empty());
    assert_eq!(sweep(&store, &settings).await.stripped_scenes, 0, "once is enough");
}

async fn answers_of_executions_stay_for_their_time((_directory, store): Opened) {
    let put = async |content: &'static [u8]| store.blobs().put(content).await.expect("puts");
    let (bundle, answer) = (put(b"bundle").await, put(b"answer").await);
    let new = NewExecution {
        tenant_id: DEFAULT_TENANT.clone(),
        scene_id: "scene".parse().expect("an id"),
        request: json!({ "version": 1 }),
        bundle,
        idempotency: None,
    };
    let SubmitExecutionOutcome::Created(id) = store.submit_execution(new).await.expect("submits") else {
        panic!("there is no key")
    };
    let settings = RetentionSettings { intermediate_hours: 48, ..retention() };
    assert_eq!(
        sweep(&store, &settings).await.kept.blobs,
        1,
        "the bundle is needed, and nothing has that answer"
    );
    let answer = ExecutionAnswer { digest: answer, media_type: "application/json".into(), size: 6 };
    put(b"answer").await;
    let scope = Scope::Job(id.clone());
    let claim =
        store.claim("w", Duration::from_secs(60), 3, &scope).await.expect("claims").expect("it waits");
    store.finish(&claim.lease, AttemptOutcome::Executed(answer.clone())).await.expect("finishes");
    let report = sweep(&store, &settings).await;
    assert_eq!((report.executions, report.removed.blobs, report.kept.blobs), (0, 1, 1), "the bundle goes");
    pass_hours(&store, 49).await;
    let report = sweep(&store, &settings).await;
    assert_eq!((report.executions, report.removed.blobs), (1, 1));
    assert_eq!(store.job(&DEFAULT_TENANT, &id).await.expect("reads"), None);
}

async fn bundles_of_quarantined_scenes_end((_directory, store): Opened) {
    let (good, bad) = (built(&store, &["alpha"], true).await, built(&store, &["beta"], false).await);
    let settings = RetentionSettings { quarantined_hours: 10, ..retention() };
    pass_hours(&store, 11).await;
    let report = sweep(&store, &settings).await;
    assert_eq!((report.quarantined_bundles, report.removed.blobs), (1, 1));
    for (scene, count) in [(good, 1), (bad, 0)] {
        let archive = store.archive(&DEFAULT_TENANT, &scene, "all").await.expect("reads");
        assert_eq!(archive.iter().count(), count);
    }
}

async fn the_image_of_a_request_stays_with_its_scene((_directory, store): Opened) {
    let image = store.blobs().put("image").await.expect("puts");
    let request = json!({ "input": { "kind": "image", "sha256": image.as_str() } });
    let (scene, _) = submitted(&store, request).await;
    assert_eq!(sweep(&store, &retention()).await.removed.blobs, 0);
    store.delete_scene(&DEFAULT_TENANT, &scene).await.expect("deletes");
    assert_eq!(sweep(&store, &retention()).await.removed.blobs, 1);
}

async fn a_checkpoint_that_was_removed_is_not_reused((_directory, store): Opened) {
    let first = built(&store, &["alpha"], true).await;
    let (_, job_id) = submitted(&store, json!({})).await;
    let claim =
        store.claim("worker", Duration::from_secs(60), 3, &Scope::Job(job_id.clone())).await.expect("claims");
    let lease = claim.expect("a job").lease;
    let stage = StageKey {
        tenant_id: DEFAULT_TENANT.clone(),
        stage: "alpha".into(),
        version: 1,
        instance: String::new(),
        key: Digest::of(b"alpha"),
    };
    let found = store.checkpoint(&stage).await.expect("reads").expect("is there");
    store.delete_scene(&DEFAULT_TENANT, &first).await.expect("deletes");
    sweep(&store, &retention()).await;
    let reused = store.stage_finished(&lease, &stage, &found, true).await;
    assert!(matches!(reused, Err(StoreError::CheckpointGone)), "{reused:?}");
}

async fn usage_counts_each_blob_once_and_the_quota_compares((_directory, mut store): Opened) {
    let limits = LimitSettings { bytes: 215, ..*store.admission.settings() };
    store.admission = std::sync::Arc::new(Admission::new(limits));
    built(&store, &["alpha"], true).await;
    built(&store, &["alpha"], true).await;
    let usage = store.usage_of(&DEFAULT_TENANT).await.expect("adds");
    assert_eq!(usage.bytes, 10 + 100 + 100, "one artifact of two scenes, and two bundles");
    assert_eq!(store.full_quota(&DEFAULT_TENANT).await, None);
    let other = "other".parse().expect("an id");
    assert_eq!(store.usage_of(&other).await.expect("adds").bytes, 0);
    let scene = built(&store, &["beta"], true).await;
    assert_eq!(store.full_quota(&DEFAULT_TENANT).await, None, "the sum is not so new");
    store.quota.forget();
    let full = store.full_quota(&DEFAULT_TENANT).await.expect("there are too many bytes");
    assert_eq!((full.limit, full.max, full.used), (Limit::Bytes, 215, 320));
    store.quota.forget();
    store.delete_scene(&DEFAULT_TENANT, &scene).await.expect("deletes");
    assert_eq!(store.full_quota(&DEFAULT_TENANT).await, None);
    // Bytes of datasets and executions count, too, and a limit of the tenant replaces that of all.
    let added = store.writer.write("add bytes", |connection| {
        Box::pin(async move {
            sqlx::raw_sql(
                "INSERT INTO datasets (id, tenant_id, name, state, request, body_digest, created_at)
                     VALUES ('d', 'default', 'set', 'finished', '{}', 'b', 0);
                 INSERT INTO dataset_files (dataset_id, path, digest, size, media_type)
                     VALUES ('d', 'a', 'x', 1000, 't'), ('d', 'b', 'x', 1000, 't');
                 INSERT INTO jobs (id, tenant_id, kind, state, created_at)
                     VALUES ('j', 'default', 'execute_task', 'succeeded', 0);
                 INSERT INTO executions (job_id, tenant_id, scene_id, request, bundle, answer, media_type, size)
                     VALUES ('j', 'default', 's', '{}', 'b', 'y', 't', 30)",
            )
            .execute(&mut *connection)
            .await?;
            let change = LimitChange { limit: Limit::Bytes, value: Some(1240) };
            crate::limits::set(connection, &DEFAULT_TENANT, &[change]).await
        })
    });
    added.await.expect("adds");
    store.quota.forget();
    let full = store.full_quota(&DEFAULT_TENANT).await.expect("there are too many bytes");
    assert_eq!((full.max, full.used), (1240, 1240));
}

async fn one_process_at_a_time_takes_the_turn((_directory, store): Opened) {
    let hour = Duration::from_secs(3600);
    assert!(store.takes_turn(hour).await.expect("answers"));
    assert!(!store.takes_turn(hour).await.expect("answers"), "the hour is not over");
    let over = store.writer.write("let the hour pass", |connection| {
        Box::pin(async move {
            sqlx::query("UPDATE upkeep SET next_at = 0").execute(connection).await?;
            Ok(())
        })
    });
    over.await.expect("passes");
    assert!(store.takes_turn(hour).await.expect("answers"));
}

async fn the_database_shrinks_with_its_scenes((directory, store): Opened) {
    let file = directory.path().join("tabletopgen.sqlite");
    // In PostgreSQL the rows go, and the pages are its own affair.
    let size = || std::fs::metadata(&file).map_or(0, |meta| meta.len());
    let text = "x".repeat(20_000);
    let mut scenes = Vec::new();
    for _ in 0..50 {
        scenes.push(submitted(&store, json!({ "text": text })).await);
    }
    for (scene_id, _) in &scenes {
        store.delete_scene(&DEFAULT_TENANT, scene_id).await.expect("deletes");
    }
    let settings = RetentionSettings { deleted_hours: 0, ..retention() };
    let report = sweep(&store, &settings).await;
    assert_eq!((report.stripped_scenes, report.purged_scenes), (50, 50));
    for (scene_id, job_id) in &scenes {
        assert_eq!(store.scene(&DEFAULT_TENANT, scene_id).await.expect("reads"), None);
        assert_eq!(store.job(&DEFAULT_TENANT, job_id).await.expect("reads"), None);
    }
    // A checkpoint of the write-ahead log moves the end of the file.
    if size() > 0 {
        let mut connection = store.readers.acquire().await.expect("connects");
        let free: i64 =
            sqlx::query_scalar("PRAGMA freelist_count").fetch_one(&mut *connection).await.expect("reads");
        let pages: i64 =
            sqlx::query_scalar("PRAGMA page_count").fetch_one(&mut *connection).await.expect("reads");
        assert!(free == 0 && pages < 160, "{free} of {pages} pages are free");
    }
}

async fn checkpoints_that_no_job_names_go((_directory, store): Opened) {
    let (_, job_id) = submitted(&store, json!({})).await;
    let claim =
        store.claim("worker", Duration::from_secs(60), 3, &Scope::Job(job_id.clone())).await.expect("claims");
    let lease = claim.expect("a job").lease;
    let (known, checkpoint) = stage(&store, &lease, "alpha").await;
    // The same stage with another key, as after an upgrade; its artifact is another too.
    let renewed = StageKey { key: Digest::of(b"renewed"), ..known.clone() };
    let output = store.blobs().put("renewed output").await.expect("puts");
    let other = Checkpoint { output, ..checkpoint };
    store.stage_finished(&lease, &renewed, &other, false).await.expect("commits");
    assert_eq!(
        sweep(&store, &RetentionSettings { grace_secs: 600, ..retention() }).await.orphaned_checkpoints,
        0
    );
    let report = sweep(&store, &retention()).await;
    assert_eq!((report.orphaned_checkpoints, report.removed.blobs), (1, 1));
    assert_eq!(store.checkpoint(&known).await.expect("reads"), None);
    assert!(store.checkpoint(&renewed).await.expect("reads").is_some());
}
