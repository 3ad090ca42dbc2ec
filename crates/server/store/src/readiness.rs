//! Readiness: whether the store does now what submissions, claims and stages ask of it.
//!
//! A probe takes the same locks on the same tables as they do (by statements that change no row), commits a write, and
//! puts a blob. So a locked table, a full disk and a bucket without rights are noticed, not only a server that is away.
//! Probes share a verdict of the last second, and blobs are put every half a minute, so that any number of probes costs
//! one small transaction a second at most.

use std::time::{Duration, Instant};

use tokio::sync::Mutex;

use super::outage::Part;
use super::{Store, StoreError, database};
use crate::boxed;

/// A good verdict serves other probes for this long.
const FRESH: Duration = Duration::from_secs(1);
/// Time between blobs that probes put while all is well.
const BLOB_INTERVAL: Duration = Duration::from_secs(30);
/// Longest wait for the place of blobs, whose own tries may last longer.
const BLOB_LIMIT: Duration = Duration::from_secs(5);

/// Statements of the work, on rows that are not there: what a submission, a claim, a stage and their events lock.
const WORK: [&str; 8] = [
    "UPDATE idempotency SET expires_at = expires_at WHERE tenant_id = '' AND key = ''",
    "UPDATE scenes SET updated_at = updated_at WHERE id = ''",
    "UPDATE jobs SET lease_until = lease_until WHERE id = ''",
    "UPDATE events SET at = at WHERE job_id = ''",
    "UPDATE stages SET epoch = epoch WHERE job_id = ''",
    "UPDATE stage_claims SET epoch = epoch WHERE tenant_id = '' AND key = ''",
    "UPDATE checkpoints SET created_at = created_at WHERE tenant_id = '' AND key = ''",
    "UPDATE artifacts SET created_at = created_at WHERE scene_id = ''",
];

/// The newest verdicts; the lock is held while one is found, so that probes at once ask once.
#[derive(Debug, Default)]
pub(super) struct Readiness(Mutex<Verdicts>);

#[derive(Debug, Default)]
struct Verdicts {
    /// Time of the last check that succeeded.
    well: Option<Instant>,
    /// Time of the last put of a blob.
    blob: Option<Instant>,
}

impl Store {
    /// Checks that reads, the writes of the work, and blobs succeed.
    ///
    /// # Errors
    ///
    /// The [`StoreError`] that work would meet now.
    #[boxed]
    pub async fn is_healthy(&self) -> Result<(), StoreError> {
        let mut verdicts = self.readiness.0.lock().await;
        let is_out = self.health.is_failing(Part::Database) || self.health.is_failing(Part::Blobs);
        if !is_out && verdicts.well.is_some_and(|well| well.elapsed() < FRESH) {
            return Ok(());
        }
        verdicts.well = None;
        sqlx::query("SELECT 1 FROM jobs LIMIT 1").fetch_optional(&self.readers).await?;
        let worked = self.writer.write("take writes", |connection| {
            Box::pin(async move {
                for statement in WORK {
                    sqlx::query(statement).execute(&mut *connection).await?;
                }
                let now = database::now_ms(connection).await?;
                sqlx::query(
                    "INSERT INTO upkeep (name, next_at) VALUES ('readiness', $1)
                     ON CONFLICT (name) DO UPDATE SET next_at = excluded.next_at",
                )
                .bind(now)
                .execute(connection)
                .await?;
                Ok(())
            })
        });
        worked.await?;
        let is_due = verdicts.blob.is_none_or(|blob| blob.elapsed() >= BLOB_INTERVAL);
        if is_due || self.health.is_failing(Part::Blobs) {
            self.put_probe().await?;
            verdicts.blob = Some(Instant::now());
        }
        verdicts.well = Some(Instant::now());
        Ok(())
    }

    async fn put_probe(&self) -> Result<(), StoreError> {
        tokio::time::timeout(BLOB_LIMIT, self.blobs.probe()).await.unwrap_or_else(|late| {
            let source = object_store::Error::Generic { store: "probe", source: Box::new(late) };
            Err(StoreError::Blob { name: "of the probe".to_owned(), doing: "written", source })
        })
    }
}
