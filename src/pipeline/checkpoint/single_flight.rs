//! One computation of a stage key at a time: a lock among the jobs of this process, a claim among processes.
//!
//! The lock is taken first, so a process asks the store on behalf of one job at a time. The claim belongs to a job
//! under its lease and ends with the commit, with a failure of the stage, or when its job leaves its worker.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, Weak};
use std::time::{Duration, Instant};

use super::{Checkpoints, StageError, StageRuntime};
use scene::{JobId, TenantId};
use store::checkpoints::StageKey;

/// Keys being computed by this process. The holder of the inner lock computes; all others wait and then find the row.
pub(super) type InProgress = BTreeMap<(TenantId, String), Weak<tokio::sync::Mutex<()>>>;

/// Shortest and longest pause between two questions of a waiting job for the end of the other one's stage.
const PAUSES: [Duration; 2] = [Duration::from_millis(50), Duration::from_millis(500)];

impl StageRuntime {
    /// The lock of a key.
    pub(super) fn lock_of(&self, key: &StageKey) -> Arc<tokio::sync::Mutex<()>> {
        let in_progress: &Mutex<InProgress> = &self.in_progress;
        let mut in_progress = in_progress.lock().expect("no code panics while it holds this lock");
        in_progress.retain(|_, lock| lock.strong_count() > 0);
        let slot = in_progress.entry((key.tenant_id.clone(), key.key.to_string())).or_default();
        slot.upgrade().unwrap_or_else(|| {
            let lock = Arc::new(tokio::sync::Mutex::new(()));
            *slot = Arc::downgrade(&lock);
            lock
        })
    }
}

impl<S> Checkpoints<S> {
    /// Returns when the other job has finished the key, or has given it up.
    ///
    /// # Errors
    ///
    /// The job was asked to stop, or the store does not answer.
    pub(super) async fn wait_for(&self, key: &StageKey, other: &JobId) -> Result<(), StageError> {
        let (store, lease) = (&self.runtime.store, &self.job.lease);
        let [shortest, longest] = PAUSES;
        store.note(lease, &key.stage, format!("job {other} computes the same; waiting for it")).await?;
        loop {
            let changes = store.changes();
            if store.stage_computed_by(lease, key).await?.is_none() {
                return Ok(());
            }
            let asked = Instant::now();
            while asked.elapsed() < longest {
                self.job.cancel.check()?;
                self.job.drain.check()?;
                tokio::time::sleep(shortest).await;
                if changes.has_changed().unwrap_or(false) {
                    break;
                }
            }
        }
    }
}
