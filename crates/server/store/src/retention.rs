//! Retention: what deleted and finished scenes, datasets, batches and recordings give back, and when.
//!
//! A sweep removes rows first, in small transactions, and then every blob that no row refers to:
//!
//! 1. Batches, datasets and recordings whose time is over are deleted. Those that are deleted lose their contents:
//!    items, files, archives. Scenes of a batch that was deleted with them are deleted.
//! 2. A deleted scene loses its artifacts, bundle, answers of remote models, and the checkpoints that no other scene
//!    uses. A finished scene loses the same but its bundle, once it is old.
//! 3. Bundles of quarantined scenes, old jobs of datasets, executions, idempotency keys and deliveries to webhooks end
//!    after their time.
//! 4. The remaining rows of what is deleted end last.
//! 5. References are read (mark), then blobs are listed (sweep). A blob is removed if it has no reference and is older
//!    than the grace period, which is longer than any stage: a stage puts its blobs before its row.
//!
//! Memory is bounded: with many references, several passes each read the references to a part of the digests.

mod references;
mod resources;
mod rows;
pub(crate) mod usage;

use std::collections::HashSet;
use std::time::Duration;

use serde::{Deserialize, Serialize};

use super::blobs::sweeping::Volume;
use super::{Digest, Store, StoreError, database};
use crate::boxed;

pub use references::ReferenceKind;
pub(crate) use references::for_each_reference;
pub use resources::ResourceRemovals;
pub(crate) use usage::Quota;
pub use usage::TenantUsage;

/// References that are held in memory at once; one takes about 60 bytes.
const MAX_REFERENCES: u64 = 2_000_000;
const SHARDS: u64 = 256;

/// Section `[store.retention]`.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct RetentionSettings {
    /// Time between sweeps of a running service, seconds; 0 = only the command sweeps.
    pub sweep_interval_secs: u64,
    /// Blobs younger than this stay, seconds. It must exceed the longest stage.
    pub grace_secs: u64,
    /// Time that the artifacts and checkpoints of a finished scene stay, hours; 0 = as long as the scene.
    pub intermediate_hours: u64,
    /// Time that the bundle of a quarantined scene stays, hours; 0 = as long as the scene.
    pub quarantined_hours: u64,
    /// Time that the last rows of a deleted scene (its jobs, events and ledger), dataset, batch or recording stay,
    /// hours.
    pub deleted_hours: u64,
    /// Time that a batch stays that has ended, with its requests and results, hours; 0 = until it is deleted.
    pub ended_batch_hours: u64,
    /// Time that a recording stays that failed or was cancelled, hours; 0 = until it is deleted.
    pub failed_recording_hours: u64,
    /// Time that a dataset stays whose freeze failed, hours; 0 = until it is deleted.
    pub failed_dataset_hours: u64,
    /// Time that ended jobs of a dataset stay with their events, but its newest, hours; 0 = as long as the dataset.
    pub dataset_job_hours: u64,
    /// Time that deliveries to webhooks stay that have ended or cannot go on, hours.
    pub delivery_hours: u64,
}

/// Result of a sweep; in a dry run, what it would do.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct SweepReport {
    pub is_dry_run: bool,
    /// Scenes whose artifacts and checkpoints were removed.
    pub stripped_scenes: u64,
    /// Checkpoints that no job names any more.
    pub orphaned_checkpoints: u64,
    pub quarantined_bundles: u64,
    pub idempotency_keys: u64,
    /// Executions whose time was over.
    pub executions: u64,
    /// Deleted scenes whose last rows were removed.
    pub purged_scenes: u64,
    pub batches: ResourceRemovals,
    pub datasets: ResourceRemovals,
    pub recordings: ResourceRemovals,
    /// Ended jobs of datasets whose time was over.
    pub dataset_jobs: u64,
    /// Deliveries to webhooks whose time was over.
    pub deliveries: u64,
    /// Blobs without a reference.
    pub removed: Volume,
    pub kept: Volume,
}

impl Store {
    /// Removes what the settings do not keep. Returns `None` if a backup is under way.
    ///
    /// A dry run counts rows as they are; blobs whose rows it would remove count as kept.
    ///
    /// # Errors
    ///
    /// A [`StoreError`] if database or blobs do not answer; what was removed until then stays removed.
    #[boxed]
    pub async fn sweep(
        &self,
        settings: &RetentionSettings,
        dry_run: bool,
    ) -> Result<Option<SweepReport>, StoreError> {
        let Some(_no_backup) = self.blobs.lock_for_sweep()? else { return Ok(None) };
        let mut report = SweepReport { is_dry_run: dry_run, ..SweepReport::default() };
        self.sweep_rows(settings, &mut report).await?;
        self.sweep_blobs(Duration::from_secs(settings.grace_secs), &mut report).await?;
        Ok(Some(report))
    }

    /// Whether it is this process's turn to sweep; then no other has one for this long.
    ///
    /// # Errors
    ///
    /// A [`StoreError`] if the database does not answer.
    #[boxed]
    pub async fn takes_turn(&self, interval: Duration) -> Result<bool, StoreError> {
        let interval_ms = i64::try_from(interval.as_millis()).unwrap_or(i64::MAX / 4);
        self.writer
            .write("take a turn to sweep", move |connection| {
                Box::pin(async move {
                    let now = database::now_ms(connection).await?;
                    let taken = sqlx::query(
                        "INSERT INTO upkeep (name, next_at) VALUES ('sweep', $1)
                         ON CONFLICT (name) DO UPDATE SET next_at = excluded.next_at WHERE upkeep.next_at <= $2",
                    )
                    .bind(now.saturating_add(interval_ms))
                    .bind(now)
                    .execute(connection)
                    .await?;
                    Ok(taken.rows_affected() > 0)
                })
            })
            .await
    }

    async fn sweep_blobs(&self, grace: Duration, report: &mut SweepReport) -> Result<(), StoreError> {
        let count = references::estimate(&self.readers.unhurried()).await?;
        let passes = count.div_ceil(MAX_REFERENCES).clamp(1, SHARDS);
        let shards_per_pass = SHARDS.div_ceil(passes);
        for first in (0..SHARDS).step_by(shards_per_pass as usize) {
            let shards = first..(first + shards_per_pass).min(SHARDS);
            let mut references = HashSet::new();
            for_each_reference(&self.readers.unhurried(), |_, digest| {
                let key = key_of(&digest);
                if shards.contains(&u64::from(key[0])) {
                    references.insert(key);
                }
            })
            .await?;
            // In one pass all blobs are one list.
            let lists =
                if passes == 1 { vec![None] } else { shards.map(|shard| Some(shard as u8)).collect() };
            for shard in lists {
                let swept = self.blobs.sweep_shard(shard, grace, report.is_dry_run, |digest| {
                    references.contains(&key_of(digest))
                });
                let (removed, kept) = swept.await?;
                report.removed.extend(removed);
                report.kept.extend(kept);
            }
        }
        let damaged = self.blobs.sweep_damaged(grace, report.is_dry_run).await?;
        report.removed.extend(damaged);
        Ok(())
    }
}

/// A digest as bytes, half the size of its text.
fn key_of(digest: &Digest) -> [u8; 32] {
    let hex = digest.as_str().as_bytes();
    let nibble = |digit: u8| if digit <= b'9' { digit - b'0' } else { digit - b'a' + 10 };
    std::array::from_fn(|i| nibble(hex[2 * i]) << 4 | nibble(hex[2 * i + 1]))
}

#[cfg(test)]
mod tests;
