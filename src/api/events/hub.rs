//! One reader for all event streams: it asks the store how far the followed jobs are, and wakes the streams of those
//! that moved.
//!
//! Streams that each read rows after every change would load the store with their number times the rate of changes;
//! here a change costs one query for 500 followed jobs, however many streams follow each.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard};
use std::time::Duration;

use tokio::sync::{Notify, watch};
use tokio_util::sync::CancellationToken;

use scene::JobId;
use store::events::EventHead;
use store::{DEFAULT_TENANT, Store, StoreError};

/// Least time between two readings; changes in between are read together.
const PAUSE: Duration = Duration::from_millis(20);

/// A change whose announcement did not reach this process is read after this long.
const PERIOD: Duration = Duration::from_secs(5);

/// Jobs of one query.
const JOBS_PER_QUERY: usize = 500;

/// How far a job is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct JobProgress {
    pub last_seq: i64,
    /// No event will follow.
    pub is_final: bool,
}

/// Progress of one job; `None` until it has been read.
pub type Progress = watch::Receiver<Option<JobProgress>>;

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
    by_job: BTreeMap<JobId, watch::Sender<Option<JobProgress>>>,
    has_reader: bool,
}

impl EventHub {
    pub fn new(store: Store, shutdown: CancellationToken) -> Self {
        Self { store, shutdown, followed: Arc::default(), wake: Arc::default() }
    }

    /// Follows a job until the receiver is dropped. What is received was read after this call, or shortly before.
    pub fn follow(&self, job_id: &JobId) -> Progress {
        let mut followed = self.lock();
        let sender = followed.by_job.entry(job_id.clone()).or_insert_with(|| watch::Sender::new(None));
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
            let Some(jobs) = self.followed_jobs() else { return };
            if let Err(error) = self.read(&jobs).await {
                tracing::error!(%error, "cannot read the progress of followed jobs; streams wait");
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

    /// The jobs that have followers; `None` ends the reader.
    fn followed_jobs(&self) -> Option<Vec<JobId>> {
        let mut followed = self.lock();
        followed.by_job.retain(|_, sender| sender.receiver_count() > 0);
        followed.has_reader = !followed.by_job.is_empty();
        followed.has_reader.then(|| followed.by_job.keys().cloned().collect())
    }

    async fn read(&self, jobs: &[JobId]) -> Result<(), StoreError> {
        for jobs in jobs.chunks(JOBS_PER_QUERY) {
            let mut heads: BTreeMap<JobId, EventHead> = BTreeMap::new();
            for head in self.store.event_heads(&DEFAULT_TENANT, jobs).await? {
                heads.insert(head.job_id.clone(), head);
            }
            let followed = self.lock();
            for job in jobs {
                // A job without a row has no more events.
                let progress = heads.get(job).map_or(JobProgress { last_seq: 0, is_final: true }, |head| {
                    JobProgress { last_seq: head.last_seq, is_final: head.state.is_final() }
                });
                if let Some(sender) = followed.by_job.get(job) {
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
