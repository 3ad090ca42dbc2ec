//! The rows that a sweep removes: one transaction for each scene, so that no other writer waits long.

use sqlx::{AnyConnection, AssertSqlSafe, Row};

use super::super::database;
use super::super::database::Dialect;
use super::resources::EndTimes;
use super::{RetentionSettings, Store, StoreError, SweepReport};
use scene::SceneId;

/// Scenes that one query finds.
const PAGE_SCENES: i64 = 100;
/// Idempotency keys, deliveries, or checkpoints, of one transaction.
const PAGE_KEYS: i64 = 1000;
/// Pages that one transaction returns, 4 KiB each.
const RETURNED_PAGES: i64 = 500;
/// Ended jobs that one transaction removes.
const MAX_JOBS: i64 = 100;
const HOUR_MS: i64 = 3_600_000;

/// Condition on a scene that no job works on.
const IS_IDLE: &str = "NOT EXISTS (SELECT 1 FROM jobs WHERE jobs.scene_id = scenes.id
                                   AND jobs.state IN ('queued', 'running', 'cancelling'))";

/// Jobs that a sweep removes once they have ended long ago.
struct JobRemoval {
    /// On a row of `jobs`.
    condition: &'static str,
    /// The statements that remove a job, in the order that their references want.
    statements: &'static [&'static str],
}

const EXECUTIONS: JobRemoval = JobRemoval {
    condition: "kind = 'execute_task'",
    statements: &[
        "DELETE FROM executions WHERE job_id = $1",
        "DELETE FROM events WHERE job_id = $1",
        "DELETE FROM jobs WHERE id = $1",
    ],
};

/// The newest job of a dataset stays, and what it repeats.
const JOBS_OF_DATASETS: JobRemoval = JobRemoval {
    condition: "dataset_id IS NOT NULL
        AND id <> COALESCE((SELECT job_id FROM datasets WHERE datasets.id = jobs.dataset_id), '')
        AND NOT EXISTS (SELECT 1 FROM jobs AS later WHERE later.retry_of = jobs.id)",
    statements: &["DELETE FROM events WHERE job_id = $1", "DELETE FROM jobs WHERE id = $1"],
};

/// Rows that a sweep removes at a time.
struct ExpiredRows {
    table: &'static str,
    /// Columns of the primary key.
    key: &'static str,
    /// On a row, with the time `$1`.
    condition: &'static str,
}

const IDEMPOTENCY_KEYS: ExpiredRows =
    ExpiredRows { table: "idempotency", key: "tenant_id, key", condition: "expires_at <= $1" };

/// One that waits for its next attempt stays, as long as its webhook sends.
const DELIVERIES: ExpiredRows = ExpiredRows {
    table: "deliveries",
    key: "id",
    condition: "created_at <= $1
        AND (state <> 'waiting' OR NOT EXISTS (SELECT 1 FROM webhooks WHERE webhooks.id = deliveries.webhook_id
                                               AND webhooks.disabled_reason IS NULL))",
};

/// The statements that remove the last rows of a scene, in the order that their references want.
const PURGES: [&str; 9] = [
    "DELETE FROM events WHERE job_id IN (SELECT id FROM jobs WHERE scene_id = $1)",
    "DELETE FROM stages WHERE job_id IN (SELECT id FROM jobs WHERE scene_id = $1)",
    "DELETE FROM calls WHERE scene_id = $1",
    "DELETE FROM idempotency WHERE scene_id = $1",
    "DELETE FROM artifacts WHERE scene_id = $1",
    "DELETE FROM bundle_files WHERE scene_id = $1",
    "DELETE FROM bundle_archives WHERE scene_id = $1",
    "DELETE FROM jobs WHERE scene_id = $1",
    "DELETE FROM scenes WHERE id = $1",
];

impl Store {
    pub(super) async fn sweep_rows(
        &self,
        settings: &RetentionSettings,
        report: &mut SweepReport,
    ) -> Result<(), StoreError> {
        let now = self.readers.now_ms().await?;
        // The beginning of time finds nothing.
        let before = |hours: u64| match i64::try_from(hours) {
            Ok(0) => i64::MIN / 2,
            Ok(hours) => now.saturating_sub(hours.saturating_mul(HOUR_MS)),
            Err(_) => i64::MIN / 2,
        };
        let dry_run = report.is_dry_run;

        let times = EndTimes {
            batches: before(settings.ended_batch_hours),
            datasets: before(settings.failed_dataset_hours),
            recordings: before(settings.failed_recording_hours),
        };
        // First, as scenes may go with their batch.
        self.empty_resources(&times, report).await?;

        // All deleted scenes, whatever the time.
        let deleted =
            Selection::unchanged_since(&format!("state = 'deleted' AND stripped_at IS NULL AND {IS_IDLE}"));
        let finished = Selection::unchanged_since(&format!(
            "state IN ('ready', 'failed') AND stripped_at IS NULL AND {IS_IDLE}"
        ));
        report.stripped_scenes = self.each_scene(&deleted, i64::MAX, dry_run, Treatment::Strip).await?
            + self
                .each_scene(&finished, before(settings.intermediate_hours), dry_run, Treatment::Strip)
                .await?;

        let grace_ms = i64::try_from(settings.grace_secs).unwrap_or(i64::MAX / 1000).saturating_mul(1000);
        report.orphaned_checkpoints =
            self.remove_orphaned_checkpoints(now.saturating_sub(grace_ms), dry_run).await?;

        let quarantined = Selection::unchanged_since(&format!(
            "state = 'failed' AND failure_code = 'quarantined' AND {IS_IDLE}
             AND EXISTS (SELECT 1 FROM bundle_archives WHERE bundle_archives.scene_id = scenes.id)"
        ));
        report.quarantined_bundles = self
            .each_scene(&quarantined, before(settings.quarantined_hours), dry_run, Treatment::RemoveBundle)
            .await?;

        report.idempotency_keys = self.remove_pages(&IDEMPOTENCY_KEYS, now, dry_run).await?;
        report.deliveries = self.remove_pages(&DELIVERIES, before(settings.delivery_hours), dry_run).await?;
        report.executions =
            self.remove_jobs(&EXECUTIONS, before(settings.intermediate_hours), dry_run).await?;
        report.dataset_jobs =
            self.remove_jobs(&JOBS_OF_DATASETS, before(settings.dataset_job_hours), dry_run).await?;

        let purged = Selection::unchanged_since(&format!(
            "state = 'deleted' AND stripped_at IS NOT NULL AND {IS_IDLE}
             AND NOT EXISTS (SELECT 1 FROM idempotency WHERE idempotency.scene_id = scenes.id)
             AND NOT EXISTS (SELECT 1 FROM scenes AS child WHERE child.parent_id = scenes.id)"
        ));
        let end =
            now.saturating_sub(i64::try_from(settings.deleted_hours).unwrap_or(i64::MAX / HOUR_MS) * HOUR_MS);
        report.purged_scenes = self.each_scene(&purged, end, dry_run, Treatment::Purge).await?;
        self.purge_resources(end, report).await?;
        if dry_run {
            return Ok(());
        }
        self.discard_abandoned_batches().await?;
        self.return_free_pages().await
    }

    /// Removes jobs that ended before `end_ms`, at most [`MAX_JOBS`] in one transaction; their number.
    async fn remove_jobs(
        &self,
        jobs: &'static JobRemoval,
        end_ms: i64,
        dry_run: bool,
    ) -> Result<u64, StoreError> {
        let ended = format!("SELECT id FROM jobs WHERE {} AND finished_at <= $1 LIMIT $2", jobs.condition);
        if dry_run {
            let ended = format!("SELECT COUNT(*) FROM ({ended}) AS ended");
            let count: i64 = sqlx::query_scalar(AssertSqlSafe(ended))
                .bind(end_ms)
                .bind(i64::MAX)
                .fetch_one(&self.readers)
                .await?;
            return Ok(count.unsigned_abs());
        }
        let mut removed = 0;
        loop {
            let ended = ended.clone();
            let ended = self.writer.write("remove ended jobs", move |connection| {
                Box::pin(async move {
                    let ended: Vec<String> = sqlx::query_scalar(AssertSqlSafe(ended))
                        .bind(end_ms)
                        .bind(MAX_JOBS)
                        .fetch_all(&mut *connection)
                        .await?;
                    for id in &ended {
                        for query in jobs.statements {
                            sqlx::query(*query).bind(id).execute(&mut *connection).await?;
                        }
                    }
                    Ok(ended.len() as u64)
                })
            });
            let ended = ended.await?;
            removed += ended;
            if ended < MAX_JOBS.unsigned_abs() {
                return Ok(removed);
            }
        }
    }

    /// Gives the free pages of a SQLite file back to the file system. Files of earlier versions keep and reuse them, as
    /// PostgreSQL does.
    async fn return_free_pages(&self) -> Result<(), StoreError> {
        let mut before = i64::MAX;
        loop {
            let free = self.writer.write("return free pages", |connection| {
                Box::pin(async move {
                    if Dialect::of(connection) != Dialect::Sqlite {
                        return Ok(0);
                    }
                    let step = format!("PRAGMA incremental_vacuum({RETURNED_PAGES})");
                    sqlx::query(AssertSqlSafe(step)).fetch_all(&mut *connection).await?;
                    Ok(sqlx::query_scalar::<_, i64>("PRAGMA freelist_count").fetch_one(connection).await?)
                })
            });
            let free = free.await?;
            if free == 0 || free >= before {
                return Ok(());
            }
            before = free;
        }
    }

    /// Treats every selected scene, with `$1` = `time_ms`; their number.
    async fn each_scene(
        &self,
        selection: &Selection,
        time_ms: i64,
        dry_run: bool,
        treatment: Treatment,
    ) -> Result<u64, StoreError> {
        let Selection { condition } = selection;
        let sql = format!(
            "SELECT id, updated_at FROM scenes
             WHERE ({condition}) AND (updated_at, id) > ($2, $3) ORDER BY updated_at, id LIMIT $4"
        );
        let (readers, writer) = (self.readers.unhurried(), self.writer.unhurried());
        let (mut last, mut last_ms, mut count) = (String::new(), i64::MIN, 0);
        loop {
            let rows = sqlx::query(AssertSqlSafe(sql.as_str()))
                .bind(time_ms)
                .bind(last_ms)
                .bind(&last)
                .bind(PAGE_SCENES)
                .fetch_all(&readers)
                .await?;
            let Some(newest) = rows.last() else { return Ok(count) };
            (last, last_ms) = (newest.try_get("id")?, newest.try_get("updated_at")?);
            if dry_run {
                count += rows.len() as u64;
                continue;
            }
            for row in rows {
                let check = format!("SELECT tenant_id, state FROM scenes WHERE ({condition}) AND id = $2");
                let id: SceneId = database::id(&row, "scenes", "id")?;
                let treated = writer.write("remove rows of a scene", move |connection| {
                    let (check, id) = (check.clone(), id.clone());
                    Box::pin(async move { treat(connection, &check, time_ms, &id, treatment).await })
                });
                count += u64::from(treated.await?);
            }
        }
    }

    /// Removes checkpoints that no stage of any job names: an upgrade gave the stages of a running job other keys.
    /// Readers search for them, a page at a time, so that the writer does not wait for the search.
    async fn remove_orphaned_checkpoints(&self, before_ms: i64, dry_run: bool) -> Result<u64, StoreError> {
        const IS_ORPHAN: &str = "created_at <= $1
            AND NOT EXISTS (SELECT 1 FROM stages WHERE stages.key = checkpoints.key)";
        let page = format!(
            "SELECT tenant_id, key, CASE WHEN {IS_ORPHAN} THEN 1 ELSE 0 END AS is_orphan FROM checkpoints
             WHERE (tenant_id, key) > ($2, $3) ORDER BY tenant_id, key LIMIT $4"
        );
        let removal = format!("DELETE FROM checkpoints WHERE tenant_id = $2 AND key = $3 AND {IS_ORPHAN}");
        let (readers, writer) = (self.readers.unhurried(), self.writer.unhurried());
        let (mut tenant, mut key, mut count) = (String::new(), String::new(), 0);
        loop {
            let rows = sqlx::query(AssertSqlSafe(page.as_str()))
                .bind(before_ms)
                .bind(&tenant)
                .bind(&key)
                .bind(PAGE_KEYS)
                .fetch_all(&readers)
                .await?;
            let Some(last) = rows.last() else { return Ok(count) };
            (tenant, key) = (last.try_get("tenant_id")?, last.try_get("key")?);
            let mut orphans: Vec<(String, String)> = Vec::new();
            for row in &rows {
                if row.try_get::<i64, _>("is_orphan")? != 0 {
                    orphans.push((row.try_get("tenant_id")?, row.try_get("key")?));
                }
            }
            if dry_run || orphans.is_empty() {
                count += orphans.len() as u64;
                continue;
            }
            let removal = removal.clone();
            let removed = writer.write("remove checkpoints", move |connection| {
                Box::pin(async move {
                    let mut removed = 0;
                    for (tenant, key) in &orphans {
                        let done = sqlx::query(AssertSqlSafe(removal.as_str()))
                            .bind(before_ms)
                            .bind(tenant)
                            .bind(key)
                            .execute(&mut *connection)
                            .await?;
                        removed += done.rows_affected();
                    }
                    Ok(removed)
                })
            });
            count += removed.await?;
        }
    }

    /// Removes the rows of a table that a condition selects, with `$1` = `time_ms`, a page at a time; their number.
    async fn remove_pages(
        &self,
        rows: &'static ExpiredRows,
        time_ms: i64,
        dry_run: bool,
    ) -> Result<u64, StoreError> {
        let ExpiredRows { table, key, condition } = rows;
        if dry_run {
            let query = format!("SELECT COUNT(*) FROM {table} WHERE {condition}");
            let count: i64 =
                sqlx::query_scalar(AssertSqlSafe(query)).bind(time_ms).fetch_one(&self.readers).await?;
            return Ok(count.unsigned_abs());
        }
        let removal = format!(
            "DELETE FROM {table} WHERE ({key}) IN (SELECT {key} FROM {table} WHERE {condition} LIMIT $2)"
        );
        let mut count = 0;
        loop {
            let removal = removal.clone();
            let removed = self.writer.write("remove rows whose time is over", move |connection| {
                Box::pin(async move {
                    let removed = sqlx::query(AssertSqlSafe(removal)).bind(time_ms).bind(PAGE_KEYS);
                    Ok(removed.execute(connection).await?.rows_affected())
                })
            });
            let removed = removed.await?;
            count += removed;
            if removed < PAGE_KEYS as u64 {
                return Ok(count);
            }
        }
    }
}

/// Scenes that a sweep treats.
struct Selection {
    /// On a row of `scenes`, with the time `$1`.
    condition: String,
}

impl Selection {
    /// Scenes that the condition holds for and that have not changed since the time.
    fn unchanged_since(condition: &str) -> Self {
        Self { condition: format!("{condition} AND updated_at <= $1") }
    }
}

/// Removal from a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Treatment {
    /// Artifacts, checkpoints, archives of single formats; the bundle too if it is deleted.
    Strip,
    RemoveBundle,
    /// Every row.
    Purge,
}

/// Whether the condition still held.
async fn treat(
    connection: &mut AnyConnection,
    check: &str,
    time_ms: i64,
    id: &SceneId,
    treatment: Treatment,
) -> Result<bool, StoreError> {
    let row = sqlx::query(AssertSqlSafe(check))
        .bind(time_ms)
        .bind(id.as_str())
        .fetch_optional(&mut *connection)
        .await?;
    let Some(row) = row else { return Ok(false) };
    match treatment {
        Treatment::Strip => {
            let tenant_id: String = row.try_get("tenant_id")?;
            let is_deleted = row.try_get::<String, _>("state")? == "deleted";
            strip(connection, &tenant_id, id, is_deleted).await?;
        }
        Treatment::RemoveBundle => remove_bundle(connection, id).await?,
        Treatment::Purge => {
            for statement in PURGES {
                sqlx::query(statement).bind(id.as_str()).execute(&mut *connection).await?;
            }
        }
    }
    Ok(true)
}

async fn strip(
    connection: &mut AnyConnection,
    tenant_id: &str,
    id: &SceneId,
    is_deleted: bool,
) -> Result<(), StoreError> {
    // A job that reuses one of them meanwhile holds its row until the job's own row is there, or finds it gone.
    let lock = Dialect::of(connection).lock();
    let of_scene = "tenant_id = $1 AND key IN (
        SELECT stages.key FROM stages JOIN jobs ON jobs.id = stages.job_id WHERE jobs.scene_id = $2)";
    sqlx::query(AssertSqlSafe(format!("SELECT key FROM checkpoints WHERE {of_scene} ORDER BY key {lock}")))
        .bind(tenant_id)
        .bind(id.as_str())
        .fetch_all(&mut *connection)
        .await?;
    // Another scene keeps a checkpoint while it has not been stripped itself. The search goes from the checkpoint to
    // its scenes: joined, SQLite begins with all scenes of the tenant, for each checkpoint.
    sqlx::query(
        "DELETE FROM checkpoints
         WHERE tenant_id = $1
           AND key IN (SELECT stages.key FROM stages JOIN jobs ON jobs.id = stages.job_id WHERE jobs.scene_id = $2)
           AND NOT EXISTS (
               SELECT 1 FROM stages JOIN jobs ON jobs.id = stages.job_id
               WHERE stages.key = checkpoints.key AND jobs.scene_id <> $3
                 AND EXISTS (SELECT 1 FROM scenes
                             WHERE scenes.id = jobs.scene_id AND scenes.tenant_id = $4
                               AND scenes.state <> 'deleted' AND scenes.stripped_at IS NULL))",
    )
    .bind(tenant_id)
    .bind(id.as_str())
    .bind(id.as_str())
    .bind(tenant_id)
    .execute(&mut *connection)
    .await?;
    for statement in [
        "DELETE FROM artifacts WHERE scene_id = $1",
        "DELETE FROM bundle_archives WHERE scene_id = $1 AND format <> 'all'",
        "UPDATE calls SET answer_file = NULL, task_file = NULL
         WHERE scene_id = $1 AND (answer_file IS NOT NULL OR task_file IS NOT NULL)",
    ] {
        sqlx::query(statement).bind(id.as_str()).execute(&mut *connection).await?;
    }
    if is_deleted {
        remove_bundle(connection, id).await?;
    }
    let now = database::now_ms(connection).await?;
    sqlx::query("UPDATE scenes SET stripped_at = $1 WHERE id = $2")
        .bind(now)
        .bind(id.as_str())
        .execute(connection)
        .await?;
    Ok(())
}

async fn remove_bundle(connection: &mut AnyConnection, id: &SceneId) -> Result<(), StoreError> {
    for statement in
        ["DELETE FROM bundle_files WHERE scene_id = $1", "DELETE FROM bundle_archives WHERE scene_id = $1"]
    {
        sqlx::query(statement).bind(id.as_str()).execute(&mut *connection).await?;
    }
    Ok(())
}
