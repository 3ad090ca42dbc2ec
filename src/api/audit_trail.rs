//! Writing of the record of changes.
//!
//! A change is answered when its row is written: with the change, where the handler knows its answer
//! ([`RequestRecord`]), and otherwise after it. The row of a client that leaves before its answer is written
//! afterwards, with status 499. Requests that were refused or failed changed nothing; of them a bounded number is
//! recorded each minute, so that refusals do not fill the database.

use std::sync::{Arc, Mutex, PoisonError};

use axum::http::StatusCode;
use tokio::sync::Semaphore;

use super::minute_counts::MinuteCounts;
use super::serve::client_address::ClientAddress;
use store::Store;
use store::audit::AuditEntry;

/// Refusals that are recorded in a minute, in all and per client address.
const REFUSALS_PER_MINUTE: u32 = 600;
const REFUSALS_PER_CLIENT: u32 = 60;
/// Rows that are written in the background at the same time.
const CONCURRENT_ROWS: usize = 32;
/// The client went before it was answered, or the handler panicked.
const CLIENT_WENT: u16 = 499;
/// Longest subject, characters.
const MAX_SUBJECT_CHARS: usize = 300;

/// The record; clones share it.
#[derive(Clone)]
pub struct AuditTrail {
    store: Store,
    refusals: Arc<MinuteCounts>,
    background: Arc<Semaphore>,
}

impl AuditTrail {
    pub fn new(store: Store) -> Self {
        let refusals = Arc::new(MinuteCounts::new(REFUSALS_PER_MINUTE, REFUSALS_PER_CLIENT));
        Self { store, refusals, background: Arc::new(Semaphore::new(CONCURRENT_ROWS)) }
    }

    /// Begins a request that is recorded; [`Recorded::end`] writes the row.
    pub fn begin(&self, mut entry: AuditEntry, client: Option<ClientAddress>) -> Recorded {
        if let Some((end, _)) = entry.subject.char_indices().nth(MAX_SUBJECT_CHARS) {
            entry.subject.truncate(end);
        }
        Recorded { trail: self.clone(), client, record: RequestRecord(Arc::new(Mutex::new(Some(entry)))) }
    }

    async fn write(&self, entry: AuditEntry) {
        if let Err(error) = self.store.record(entry).await {
            match error.outage() {
                // The store itself reports outages, once.
                Some(_) => tracing::debug!(error = error.chain(), "a change was not recorded"),
                None => tracing::error!(error = error.chain(), "a change was not recorded"),
            }
        }
    }

    /// Writes without a caller that waits for it.
    fn write_in_background(&self, entry: AuditEntry) {
        let Ok(permit) = self.background.clone().try_acquire_owned() else { return };
        let Ok(runtime) = tokio::runtime::Handle::try_current() else { return };
        let trail = self.clone();
        runtime.spawn(async move {
            let _permit = permit;
            trail.write(entry).await;
        });
    }
}

/// The row of a request until it is written. A handler may take it and write it in the transaction of its change.
#[derive(Clone, Default)]
pub struct RequestRecord(Arc<Mutex<Option<AuditEntry>>>);

impl RequestRecord {
    /// The row with the status of the answer, if it is not written yet.
    pub fn take(&self, status: StatusCode) -> Option<AuditEntry> {
        let entry = self.0.lock().unwrap_or_else(PoisonError::into_inner).take()?;
        Some(AuditEntry { status: status.as_u16(), ..entry })
    }

    /// Returns what was taken and not written.
    pub fn give_back(&self, entry: Option<AuditEntry>) {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) = entry;
    }
}

/// A request whose answer is recorded.
pub struct Recorded {
    trail: AuditTrail,
    client: Option<ClientAddress>,
    record: RequestRecord,
}

impl Recorded {
    /// The row, for the handler.
    pub fn record(&self) -> RequestRecord {
        self.record.clone()
    }

    /// Writes the row with the status of the answer.
    pub async fn end(self, status: StatusCode) {
        let Some(entry) = self.record.take(status) else { return };
        let changed_nothing = status.is_client_error() || status.is_server_error();
        if changed_nothing && !self.trail.refusals.admit(self.client) {
            return;
        }
        // A store that fails must not keep the answer that says so.
        match status.is_server_error() {
            true => self.trail.write_in_background(entry),
            false => self.trail.write(entry).await,
        }
    }
}

impl Drop for Recorded {
    fn drop(&mut self) {
        if let Some(mut entry) = self.record.take(StatusCode::OK) {
            entry.status = CLIENT_WENT;
            self.trail.write_in_background(entry);
        }
    }
}
