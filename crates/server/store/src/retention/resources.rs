//! Removals of a sweep from datasets, batches and recordings.
//!
//! One that is deleted, and that no job works on any more, loses its contents: the rows that are many, or that refer to
//! blobs. Rows go a page at a time, so that no other writer waits for a hundred thousand. Its last rows go when it has
//! been deleted for long enough. Nothing brings a deleted one back.

use serde::Serialize;
use sqlx::{AssertSqlSafe, Row};

use super::{Store, StoreError, SweepReport};
use crate::database;

/// Resources that one query finds, or that one transaction deletes.
const PAGE_RESOURCES: i64 = 100;
/// Rows that one transaction removes.
const PAGE_ROWS: i64 = 1000;

/// Removals from resources of one kind; in a dry run, what they would be.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct ResourceRemovals {
    /// Resources whose time was over, which are deleted now.
    pub expired: u64,
    /// Deleted resources that lost their contents.
    pub emptied: u64,
    /// Deleted resources whose last rows were removed.
    pub purged: u64,
}

/// Times, milliseconds since 1970: resources that ended before are deleted.
pub(super) struct EndTimes {
    pub(super) batches: i64,
    pub(super) datasets: i64,
    pub(super) recordings: i64,
}

/// A table whose rows belong to resources: its name, the column with the id of the resource, and the column that makes
/// the key together with that.
type Owned = (&'static str, &'static str, &'static str);

/// A kind of resource. Conditions are on a row of its table.
struct Resource {
    table: &'static str,
    /// Resources that end by their time.
    may_expire: &'static str,
    /// No work on it is left.
    is_idle: &'static str,
    contents: &'static [Owned],
    /// No row has to remember it.
    may_be_forgotten: &'static str,
    /// Tables of last rows of which one resource can have many.
    many_last_rows: &'static [Owned],
    /// The statements that remove the others, in the order that their references want.
    last_rows: &'static [&'static str],
}

const BATCHES: Resource = Resource {
    table: "batches",
    may_expire: "state IN ('finished', 'cancelled')",
    is_idle: "state IN ('finished', 'cancelled')",
    contents: &[("batch_items", "batch_id", "place")],
    may_be_forgotten: "TRUE",
    many_last_rows: &[],
    last_rows: &["DELETE FROM batches WHERE id = $1"],
};

const DATASETS: Resource = Resource {
    table: "datasets",
    may_expire: "state = 'failed'",
    is_idle: "NOT EXISTS (SELECT 1 FROM jobs WHERE jobs.dataset_id = datasets.id
                          AND jobs.state IN ('queued', 'running', 'cancelling'))",
    contents: &[("dataset_files", "dataset_id", "path")],
    // The highest number is not given to another version while an earlier version of the name stays. Of several rows
    // with that number one is enough.
    may_be_forgotten: "(version IS NULL
        OR EXISTS (SELECT 1 FROM datasets AS other WHERE other.tenant_id = datasets.tenant_id
                   AND other.name = datasets.name AND other.version >= datasets.version
                   AND other.id <> datasets.id)
        OR NOT EXISTS (SELECT 1 FROM datasets AS earlier WHERE earlier.tenant_id = datasets.tenant_id
                       AND earlier.name = datasets.name AND earlier.version < datasets.version
                       AND earlier.deleted_at IS NULL))",
    many_last_rows: &[],
    last_rows: &[
        "DELETE FROM events WHERE job_id IN (SELECT id FROM jobs WHERE dataset_id = $1)",
        "DELETE FROM jobs WHERE dataset_id = $1",
        "DELETE FROM datasets WHERE id = $1",
    ],
};

const RECORDINGS: Resource = Resource {
    table: "recordings",
    may_expire: "state IN ('failed', 'cancelled')",
    is_idle: "state IN ('finished', 'failed', 'cancelled')",
    contents: &[
        ("recording_files", "recording_id", "place"),
        ("recording_archives", "recording_id", "format"),
        ("recording_attempts", "recording_id", "number"),
    ],
    may_be_forgotten: "TRUE",
    many_last_rows: &[("recording_events", "recording_id", "seq")],
    last_rows: &[
        "DELETE FROM events WHERE job_id IN (SELECT id FROM jobs WHERE recording_id = $1)",
        "DELETE FROM jobs WHERE recording_id = $1",
        "DELETE FROM recordings WHERE id = $1",
    ],
};

impl Resource {
    /// Whether it has contents.
    fn has_contents(&self) -> String {
        let has = |(table, owner, _): &Owned| {
            format!("EXISTS (SELECT 1 FROM {table} WHERE {table}.{owner} = {}.id)", self.table)
        };
        format!("({})", self.contents.iter().map(has).collect::<Vec<_>>().join(" OR "))
    }
}

/// Removal from a deleted resource.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Removal {
    Contents,
    LastRows,
}

impl Store {
    /// Deletes what has ended before the times, and empties what is deleted.
    pub(super) async fn empty_resources(
        &self,
        times: &EndTimes,
        report: &mut SweepReport,
    ) -> Result<(), StoreError> {
        let dry_run = report.is_dry_run;
        for (resource, end_ms, removals) in [
            (&BATCHES, times.batches, &mut report.batches),
            (&DATASETS, times.datasets, &mut report.datasets),
            (&RECORDINGS, times.recordings, &mut report.recordings),
        ] {
            removals.expired = self.expire(resource, end_ms, dry_run).await?;
            let condition = format!("{} AND {}", resource.is_idle, resource.has_contents());
            removals.emptied =
                self.each_deleted(resource, &condition, i64::MAX, dry_run, Removal::Contents).await?;
        }
        Ok(())
    }

    /// Removes the last rows of what has been deleted before a time.
    pub(super) async fn purge_resources(
        &self,
        end_ms: i64,
        report: &mut SweepReport,
    ) -> Result<(), StoreError> {
        let dry_run = report.is_dry_run;
        for (resource, removals) in [
            (&BATCHES, &mut report.batches),
            (&DATASETS, &mut report.datasets),
            (&RECORDINGS, &mut report.recordings),
        ] {
            let Resource { is_idle, may_be_forgotten, .. } = resource;
            let condition = format!("{is_idle} AND {may_be_forgotten} AND NOT {}", resource.has_contents());
            removals.purged =
                self.each_deleted(resource, &condition, end_ms, dry_run, Removal::LastRows).await?;
        }
        Ok(())
    }

    /// Deletes resources that ended before a time; their number.
    async fn expire(&self, resource: &Resource, end_ms: i64, dry_run: bool) -> Result<u64, StoreError> {
        let Resource { table, may_expire, .. } = resource;
        let is_over = format!("{may_expire} AND deleted_at IS NULL AND finished_at <= $1");
        if dry_run {
            let count = format!("SELECT COUNT(*) FROM {table} WHERE {is_over}");
            let count: i64 =
                sqlx::query_scalar(AssertSqlSafe(count)).bind(end_ms).fetch_one(&self.readers).await?;
            return Ok(count.unsigned_abs());
        }
        // The condition stands twice: a batch may be retried before its row is locked.
        let statement = format!(
            "UPDATE {table} SET deleted_at = $2
             WHERE {is_over} AND id IN (SELECT id FROM {table} WHERE {is_over} LIMIT $3)"
        );
        let mut expired = 0;
        loop {
            let statement = statement.clone();
            let page = self.writer.write("delete what has ended long ago", move |connection| {
                Box::pin(async move {
                    let now = database::now_ms(connection).await?;
                    let done = sqlx::query(AssertSqlSafe(statement))
                        .bind(end_ms)
                        .bind(now)
                        .bind(PAGE_RESOURCES)
                        .execute(connection)
                        .await?;
                    Ok(done.rows_affected())
                })
            });
            let page = page.await?;
            expired += page;
            if page < PAGE_RESOURCES.unsigned_abs() {
                return Ok(expired);
            }
        }
    }

    /// Removes something from every resource that was deleted before a time and that meets a condition; their number.
    async fn each_deleted(
        &self,
        resource: &'static Resource,
        condition: &str,
        end_ms: i64,
        dry_run: bool,
        removal: Removal,
    ) -> Result<u64, StoreError> {
        let sql = format!(
            "SELECT id, deleted_at FROM {}
             WHERE deleted_at IS NOT NULL AND deleted_at <= $1 AND (deleted_at, id) > ($2, $3) AND {condition}
             ORDER BY deleted_at, id LIMIT $4",
            resource.table
        );
        let readers = self.readers.unhurried();
        let (mut last, mut last_ms, mut count) = (String::new(), i64::MIN, 0);
        loop {
            let rows = sqlx::query(AssertSqlSafe(sql.as_str()))
                .bind(end_ms)
                .bind(last_ms)
                .bind(&last)
                .bind(PAGE_RESOURCES)
                .fetch_all(&readers)
                .await?;
            let Some(newest) = rows.last() else { return Ok(count) };
            (last, last_ms) = (newest.try_get("id")?, newest.try_get("deleted_at")?);
            if dry_run {
                count += rows.len() as u64;
                continue;
            }
            for row in &rows {
                let id: String = row.try_get("id")?;
                count += match removal {
                    Removal::Contents => {
                        self.remove_contents(resource, &id).await?;
                        1
                    }
                    Removal::LastRows => u64::from(self.remove_last_rows(resource, condition, &id).await?),
                };
            }
        }
    }

    async fn remove_contents(&self, resource: &Resource, id: &str) -> Result<(), StoreError> {
        if resource.table == BATCHES.table {
            self.delete_scenes_left(id).await?;
        }
        for owned in resource.contents {
            self.remove_owned(owned, id).await?;
        }
        Ok(())
    }

    /// Goes on with the deletion of the scenes of a batch, where they go with it.
    async fn delete_scenes_left(&self, id: &str) -> Result<(), StoreError> {
        let deletes: Option<i64> = sqlx::query_scalar("SELECT deletes_scenes FROM batches WHERE id = $1")
            .bind(id)
            .fetch_optional(&self.readers)
            .await?;
        if deletes == Some(1) {
            self.delete_scenes_of_batch(&database::parse_id(id, "batches")?).await?;
        }
        Ok(())
    }

    /// Removes the last rows of a resource if the condition still holds; whether it did.
    async fn remove_last_rows(
        &self,
        resource: &'static Resource,
        condition: &str,
        id: &str,
    ) -> Result<bool, StoreError> {
        for owned in resource.many_last_rows {
            self.remove_owned(owned, id).await?;
        }
        let check = format!("SELECT id FROM {} WHERE id = $1 AND {condition}", resource.table);
        let id = id.to_owned();
        self.writer
            .unhurried()
            .write("remove the last rows of what is deleted", move |connection| {
                Box::pin(async move {
                    // It may have changed by the removal of another one of the same page.
                    let found: Option<String> = sqlx::query_scalar(AssertSqlSafe(check))
                        .bind(&id)
                        .fetch_optional(&mut *connection)
                        .await?;
                    if found.is_none() {
                        return Ok(false);
                    }
                    for statement in resource.last_rows {
                        sqlx::query(*statement).bind(&id).execute(&mut *connection).await?;
                    }
                    Ok(true)
                })
            })
            .await
    }

    /// Removes the rows of a table that belong to a resource, page by page.
    async fn remove_owned(&self, (table, owner, key): &Owned, id: &str) -> Result<(), StoreError> {
        let statement = format!(
            "DELETE FROM {table} WHERE {owner} = $1
             AND {key} IN (SELECT {key} FROM {table} WHERE {owner} = $1 LIMIT $2)"
        );
        let writer = self.writer.unhurried();
        loop {
            let (statement, id) = (statement.clone(), id.to_owned());
            let removed = writer.write("remove rows of what is deleted", move |connection| {
                Box::pin(async move {
                    let done = sqlx::query(AssertSqlSafe(statement))
                        .bind(id)
                        .bind(PAGE_ROWS)
                        .execute(connection)
                        .await?;
                    Ok(done.rows_affected())
                })
            });
            if removed.await? < PAGE_ROWS.unsigned_abs() {
                return Ok(());
            }
        }
    }
}
