//! Events of all jobs and recordings of a tenant, in one order.
//!
//! A sequence that writers took numbers from would not do: of two transactions, the one with the smaller number may
//! commit later, and a reader that has seen the greater one would skip it. Writers that waited for each other would be
//! slow. So an event is written without a position, and a reader numbers what was committed meanwhile
//! ([`Store::number_events`]): one transaction at a time, as each holds the row of the counter until it has committed.
//! Positions become visible in their order, and a reader that has seen position `n` has seen all before it. Within a
//! job and within a recording, positions follow the numbers of the events.

use sqlx::{AnyConnection, AssertSqlSafe, Row};

use super::database::Dialect;
use super::events::{Event, event_of};
use super::{Store, StoreError, database};
use crate::boxed;
use crate::lifecycle::JobKind;
use scene::{DatasetId, JobId, RecordingId, SceneId, TenantId};

/// Events that one transaction numbers at most, of each table.
const NUMBERED_AT_ONCE: i64 = 1_000;

/// An event of a tenant.
#[derive(Clone, Debug, PartialEq)]
pub struct TenantEvent {
    /// Ascending within the tenant, with gaps.
    pub position: i64,
    /// The event as its job or its recording has it.
    pub event: Event,
    /// The job, and its kind; `None` for an event of a recording.
    pub job: Option<(JobId, JobKind)>,
    pub scene_id: Option<SceneId>,
    pub dataset_id: Option<DatasetId>,
    pub recording_id: Option<RecordingId>,
}

/// A table of events: its name, the column with the id of what they belong to, and the table of that.
const TABLES: [(&str, &str, &str); 2] =
    [("events", "job_id", "jobs"), ("recording_events", "recording_id", "recordings")];

impl Store {
    /// Gives every event that is committed and has no position yet the next one.
    #[boxed]
    pub async fn number_events(&self) -> Result<(), StoreError> {
        // Without new events, no transaction holds the counter.
        while self.has_unnumbered().await? {
            self.writer.write("number events", |connection| Box::pin(number(connection))).await?;
        }
        Ok(())
    }

    async fn has_unnumbered(&self) -> Result<bool, StoreError> {
        for (table, ..) in TABLES {
            let query = format!("SELECT 1 FROM {table} WHERE position IS NULL LIMIT 1");
            if sqlx::query(AssertSqlSafe(query)).fetch_optional(&self.readers).await?.is_some() {
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// The greatest position of an event of the tenant; 0 where there is none.
    #[boxed]
    pub async fn last_position(&self, tenant_id: &TenantId) -> Result<i64, StoreError> {
        let mut last = 0;
        for (table, ..) in TABLES {
            let query = format!(
                "SELECT position FROM {table} WHERE tenant_id = $1 AND position IS NOT NULL
                 ORDER BY position DESC LIMIT 1"
            );
            let position: Option<i64> = sqlx::query_scalar(AssertSqlSafe(query))
                .bind(tenant_id.as_str())
                .fetch_optional(&self.readers)
                .await?;
            last = last.max(position.unwrap_or(0));
        }
        Ok(last)
    }

    /// At most `limit` events of the tenant after a position, in order.
    #[boxed]
    pub async fn tenant_events(
        &self,
        tenant_id: &TenantId,
        after: i64,
        limit: u32,
    ) -> Result<Vec<TenantEvent>, StoreError> {
        // One statement: of two, the second would see what was numbered after the first, and the page skip it.
        let of_table = |table: &str, key: &str, owners: &str, columns: &str| {
            format!(
                "SELECT * FROM (SELECT position, seq, at, kind, data, {key} AS owner_id FROM {table}
                                WHERE tenant_id = $1 AND position > $2 AND position IS NOT NULL
                                ORDER BY position LIMIT $3) AS page
                 JOIN (SELECT id, {columns} FROM {owners}) AS owner ON owner.id = page.owner_id"
            )
        };
        let [(events, job_id, jobs), (recording_events, recording_id, recordings)] = TABLES;
        let of_jobs = of_table(events, job_id, jobs, "kind AS job_kind, scene_id, dataset_id, recording_id");
        let of_recordings = of_table(
            recording_events,
            recording_id,
            recordings,
            "NULL AS job_kind, scene_id, NULL AS dataset_id, id AS recording_id",
        );
        let query = format!("{of_jobs} UNION ALL {of_recordings} ORDER BY position LIMIT $3");
        let rows = sqlx::query(AssertSqlSafe(query))
            .bind(tenant_id.as_str())
            .bind(after)
            .bind(i64::from(limit))
            .fetch_all(&self.readers)
            .await?;
        rows.iter()
            .map(|row| {
                let kind: Option<String> = row.try_get("job_kind")?;
                let corrupt =
                    |kind: &str| StoreError::Corrupt { table: "jobs", reason: format!("kind {kind}") };
                let kind =
                    kind.map(|kind| JobKind::parse(&kind).ok_or_else(|| corrupt(&kind))).transpose()?;
                let job = match kind {
                    Some(kind) => Some((database::id(row, "events", "owner_id")?, kind)),
                    None => None,
                };
                Ok(TenantEvent {
                    position: row.try_get("position")?,
                    event: event_of(row, "events")?,
                    job,
                    scene_id: database::optional_id(row, "jobs", "scene_id")?,
                    dataset_id: database::optional_id(row, "jobs", "dataset_id")?,
                    recording_id: database::optional_id(row, "jobs", "recording_id")?,
                })
            })
            .collect()
    }
}

async fn number(connection: &mut AnyConnection) -> Result<(), StoreError> {
    let lock = Dialect::of(connection).lock();
    // In PostgreSQL each statement sees what was committed before it: these see the events of all who held the counter
    // before.
    let counter = format!("SELECT last FROM event_counter WHERE id = 1 {lock}");
    let mut last: i64 = sqlx::query_scalar(AssertSqlSafe(counter)).fetch_one(&mut *connection).await?;
    for (table, key, owners) in TABLES {
        let query = format!(
            "UPDATE {table} SET position = $1 + numbered.place, tenant_id = numbered.owner_tenant
             FROM (SELECT unnumbered.{key} AS owner_id, unnumbered.seq AS seq,
                          (SELECT tenant_id FROM {owners} WHERE id = unnumbered.{key}) AS owner_tenant,
                          ROW_NUMBER() OVER (ORDER BY unnumbered.{key}, unnumbered.seq) AS place
                   FROM (SELECT {key}, seq FROM {table} WHERE position IS NULL ORDER BY {key}, seq LIMIT $2)
                        AS unnumbered) AS numbered
             WHERE {table}.{key} = numbered.owner_id AND {table}.seq = numbered.seq"
        );
        let numbered = sqlx::query(AssertSqlSafe(query))
            .bind(last)
            .bind(NUMBERED_AT_ONCE)
            .execute(&mut *connection)
            .await?
            .rows_affected();
        last += numbered as i64;
    }
    sqlx::query("UPDATE event_counter SET last = $1 WHERE id = 1").bind(last).execute(connection).await?;
    Ok(())
}
