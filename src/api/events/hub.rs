//! One reader for all event streams: it asks the store how far the followed subjects are, and wakes the streams of
//! those that moved.
//!
//! Streams that each read rows after every change would load the store with their number times the rate of changes;
//! here a change costs one query for 500 followed jobs or recordings, however many streams follow each.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard};
use std::time::Duration;

use tokio::sync::{Notify, watch};
use tokio_util::sync::CancellationToken;

use super::subject::{Subject, SubjectProgress};
use scene::TenantId;
use store::{Store, StoreError};

/// Least time between two readings; changes in between are read together.
const PAUSE: Duration = Duration::from_millis(20);

/// A change whose announcement did not reach this process is read after this long.
const PERIOD: Duration = Duration::from_secs(5);

/// Subjects that are read together.
const SUBJECTS_AT_ONCE: usize = 500;

/// Progress of one subject; `None` until it has been read.
pub type Progress = watch::Receiver<Option<SubjectProgress>>;

/// A subject of a tenant. Followers of another tenant's subject follow nothing.
pub type Followed = (TenantId, Subject);

/// The hub; clones share it.
#[derive(Clone)]
pub struct EventHub {
    store: Store,
    shutdown: CancellationToken,
    followed: Arc<Mutex<Followers>>,
    wake: Arc<Notify>,
}

#[derive(Default)]
struct Followers {
    by_subject: BTreeMap<Followed, watch::Sender<Option<SubjectProgress>>>,
    has_reader: bool,
}

impl EventHub {
    pub fn new(store: Store, shutdown: CancellationToken) -> Self {
        Self { store, shutdown, followed: Arc::default(), wake: Arc::default() }
    }

    /// Follows a subject of a tenant until the receiver is dropped. What is received was read after this call, or
    /// shortly before.
    pub fn follow(&self, tenant_id: &TenantId, subject: &Subject) -> Progress {
        let mut followed = self.lock();
        let key = (tenant_id.clone(), subject.clone());
        let sender = followed.by_subject.entry(key).or_insert_with(|| watch::Sender::new(None));
        let progress = sender.subscribe();
        if !std::mem::replace(&mut followed.has_reader, true) {
            tokio::spawn(self.clone().read_while_followed());
        }
        self.wake.notify_one();
        progress
    }

    async fn read_while_followed(self) {
        let mut changes = self.store.changes();
        loop {
            changes.mark_unchanged();
            let Some(subjects) = self.followed_subjects() else { return };
            if let Err(error) = self.read(&subjects).await {
                tracing::error!(%error, "cannot read how far followed jobs and recordings are; streams wait");
            }
            let next = async {
                tokio::time::sleep(PAUSE).await;
                tokio::select! {
                    changed = changes.changed() => if changed.is_err() {
                        tokio::time::sleep(PERIOD).await;
                    },
                    () = self.wake.notified() => {}
                    () = tokio::time::sleep(PERIOD) => {}
                }
            };
            tokio::select! {
                () = next => {}
                () = self.shutdown.cancelled() => return,
            }
        }
    }

    /// The subjects that have followers; `None` ends the reader.
    fn followed_subjects(&self) -> Option<Vec<Followed>> {
        let mut followed = self.lock();
        followed.by_subject.retain(|_, sender| sender.receiver_count() > 0);
        followed.has_reader = !followed.by_subject.is_empty();
        followed.has_reader.then(|| followed.by_subject.keys().cloned().collect())
    }

    async fn read(&self, subjects: &[Followed]) -> Result<(), StoreError> {
        for subjects in subjects.chunks(SUBJECTS_AT_ONCE) {
            let known = Subject::progress_of(&self.store, subjects).await?;
            let followed = self.lock();
            for subject in subjects {
                // A subject without a row has no more events.
                let progress =
                    known.get(subject).copied().unwrap_or(SubjectProgress { last_seq: 0, is_final: true });
                if let Some(sender) = followed.by_subject.get(subject) {
                    sender.send_if_modified(|known| {
                        let is_new = *known != Some(progress);
                        *known = Some(progress);
                        is_new
                    });
                }
            }
        }
        Ok(())
    }

    fn lock(&self) -> MutexGuard<'_, Followers> {
        self.followed.lock().expect("no code panics while it holds this lock")
    }
}
