//! Outages of storage: detection, logging and recovery.
//!
//! A full disk fails every write of every job and request. Writers report failures here. The log gets one line with
//! advice at the start of an outage and one at its end; retry loops wait for the end. Database and blobs are tracked
//! separately, because either may work without the other.

use std::sync::Arc;
use std::time::Instant;

use tokio::sync::watch;

use super::StoreError;

/// Reason why storage accepts no writes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outage {
    /// No space left.
    Full,
    /// Read-only, unreachable, locked by another process, or corrupt.
    Other,
}

/// Part of the storage.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Part {
    Database,
    Blobs,
}

/// Health of the storage; cloning shares it.
#[derive(Clone)]
pub(super) struct Health {
    parts: [Arc<watch::Sender<Option<OngoingOutage>>>; 2],
    outage: Arc<watch::Sender<Option<Outage>>>,
}

#[derive(Clone, Debug)]
struct OngoingOutage {
    why: Outage,
    since: Instant,
    tries: u64,
}

impl Health {
    pub(super) fn new() -> Self {
        Self {
            parts: [(); 2].map(|()| Arc::new(watch::Sender::new(None))),
            outage: Arc::new(watch::Sender::new(None)),
        }
    }

    /// The present outage, and its changes.
    pub(super) fn outage(&self) -> watch::Receiver<Option<Outage>> {
        self.outage.subscribe()
    }

    pub(super) fn is_failing(&self, part: Part) -> bool {
        self.parts[part as usize].borrow().is_some()
    }

    /// A write failed.
    pub(super) fn failed(&self, part: Part, error: &StoreError) {
        let Some(why) = error.outage() else { return };
        let mut first = false;
        self.parts[part as usize].send_modify(|failing| {
            first = failing.is_none();
            let failing = failing.get_or_insert(OngoingOutage { why, since: Instant::now(), tries: 0 });
            failing.tries += 1;
        });
        if first {
            let advice = match why {
                Outage::Full => {
                    "a disk is full: that of the data directory or of the database; free space on it"
                }
                Outage::Other => "see that the database answers and that blobs can be written",
            };
            tracing::error!(
                error = error.chain(),
                "storage takes no writes: {advice}. Jobs wait meanwhile; the next line about this says when \
                 it works again"
            );
        }
        self.publish();
    }

    /// A write with an effect succeeded.
    pub(super) fn succeeded(&self, part: Part) {
        if !self.is_failing(part) {
            return;
        }
        if let Some(OngoingOutage { since, tries, .. }) = self.parts[part as usize].send_replace(None) {
            let seconds = since.elapsed().as_secs();
            tracing::info!(seconds, failed_tries = tries, "storage takes writes again");
        }
        self.publish();
    }

    fn publish(&self) {
        // The state is read under the lock of the published value, so the last publication is current.
        self.outage.send_if_modified(|known| {
            let now = self.parts.iter().find_map(|part| part.borrow().as_ref().map(|failing| failing.why));
            std::mem::replace(known, now) != now
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn full() -> StoreError {
        StoreError::Commit { doing: "test", reason: "disk full".into(), outage: Some(Outage::Full) }
    }

    #[test]
    fn outage_lasts_until_the_failed_part_recovers() {
        let health = Health::new();
        let outage = health.outage();
        health.failed(Part::Database, &StoreError::WriterStopped);
        health.failed(Part::Database, &StoreError::LeaseLost { job_id: "j".parse().expect("an id") });
        assert_eq!(*outage.borrow(), Some(Outage::Other), "a lost lease is none");
        health.succeeded(Part::Database);
        assert_eq!(*outage.borrow(), None);

        health.failed(Part::Blobs, &full());
        health.failed(Part::Blobs, &full());
        health.succeeded(Part::Database);
        assert_eq!(*outage.borrow(), Some(Outage::Full));
        health.succeeded(Part::Blobs);
        assert_eq!(*outage.borrow(), None);
    }
}
