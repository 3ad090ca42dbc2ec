//! The recorder: it makes attempts of recordings in the background, several at a time, and assembles their datasets.
//!
//! Each attempt is claimed from the store with a lease, which is renewed while it is made ([`attempts`]), and kept
//! there as soon as it is finished. So any number of processes work on one recording, and a process that dies costs
//! the attempts that it was making. What attempts share takes seconds to find; a process does that once for a
//! recording. When enough have succeeded, one process assembles the dataset in a work folder, and stores it
//! ([`assembly`]).

mod assembly;
mod attempts;
mod packing;
#[cfg(test)]
mod tests;

use std::collections::VecDeque;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use serde_json::Value;
use tokio::sync::{OnceCell, OwnedSemaphorePermit, Semaphore, oneshot};
use tokio_util::sync::CancellationToken;
use tokio_util::task::AbortOnDropHandle;

use crate::worker::Settings;
use crate::worker::verdict::{Verdict, setback};
use demonstrations::Setup;
use episodes::EpisodeError;
use episodes::card::DatasetCard;
use scene::RecordingId;
use store::recordings::{RecordingClaim, RecordingRow, RecordingWork};
use store::{Setback, Store, StoreError};

/// Folder of the work in a data directory.
const FOLDER: &str = "episodes";
/// Recordings whose shared part is kept in memory.
const KEPT_PREPARATIONS: usize = 2;

/// What all attempts of a recording share.
pub struct Preparation {
    pub setup: Setup,
    pub card: DatasetCard,
    /// Whether failures become episodes, too.
    pub keeps_failures: bool,
}

/// Why there is no such preparation.
#[derive(Clone, Debug, thiserror::Error)]
#[error("{message}")]
pub struct Refusal {
    /// Stable, `[a-z0-9_]+`.
    pub code: &'static str,
    /// A sentence with advice.
    pub message: String,
}

/// Prepares attempts in the scene of an archive, for a stored request. It computes for seconds, so it blocks. Made by
/// `app::recording::prepare`.
pub type Prepare = Arc<dyn Fn(&[u8], &Value) -> Result<Preparation, Refusal> + Send + Sync>;

/// A preparation with the digest of everything that attempts depend on.
struct Prepared {
    preparation: Preparation,
    identity: String,
}

type PreparedCell = Arc<OnceCell<Result<Arc<Prepared>, Refusal>>>;

/// Why work on a recording did not come to its end.
#[derive(Debug, thiserror::Error)]
enum RecordError {
    #[error(transparent)]
    Store(#[from] StoreError),
    #[error(transparent)]
    Episode(#[from] EpisodeError),
    #[error("cannot {attempt} {path}; free space or correct the permissions there")]
    File { attempt: &'static str, path: PathBuf, source: std::io::Error },
    #[error(transparent)]
    Refused(#[from] Refusal),
    #[error("a bug stopped the work on this recording; the server's log has the details")]
    Panicked,
    /// An episode is lost or damaged; its attempt is made again.
    #[error("the episode of attempt {number} is lost or damaged; see whether the disk of the blobs is sound")]
    Episodeless { number: u64 },
    /// The process ends, or another one has the lease.
    #[error("the work was given up")]
    GivenUp,
}

impl RecordError {
    fn file(attempt: &'static str, path: &Path) -> impl FnOnce(std::io::Error) -> Self {
        let path = path.to_owned();
        move |source| Self::File { attempt, path, source }
    }

    fn verdict(&self) -> Verdict {
        match self {
            Self::GivenUp | Self::Store(StoreError::RecordingLeaseLost { .. }) => Verdict::GivenUp,
            Self::Panicked => Verdict::of_panic(),
            Self::Store(error) => Verdict::of_store(error),
            Self::File { source, .. } | Self::Episode(EpisodeError::Write { source, .. }) => {
                Verdict::of_work_folder(source.kind())
            }
            Self::Episode(EpisodeError::DiskFull { .. }) => {
                Verdict::of_work_folder(std::io::ErrorKind::StorageFull)
            }
            Self::Episodeless { .. } => Verdict::Again { code: "episode_lost", charged: true },
            Self::Episode(error) => Verdict::Refused { code: "episode_unusable", message: error.to_string() },
            Self::Refused(refusal) => {
                Verdict::Refused { code: refusal.code, message: refusal.message.clone() }
            }
        }
    }
}

/// Records demonstrations of a store.
#[derive(Clone)]
pub struct Recorder {
    store: Store,
    folder: PathBuf,
    prepare: Prepare,
    owner: String,
    settings: Arc<Settings>,
    /// Attempts at a time.
    slots: Arc<Semaphore>,
    prepared: Arc<Mutex<VecDeque<(RecordingId, PreparedCell)>>>,
}

impl Recorder {
    /// A recorder that works below `data_dir`, as the process `owner`. Leases, tries, deaths and delays are those of
    /// jobs, and there are as many attempts at a time as CPU threads.
    pub fn new(
        store: Store,
        data_dir: &Path,
        prepare: Prepare,
        owner: &str,
        settings: Arc<Settings>,
    ) -> Self {
        let attempts = match settings.cpu_threads {
            0 => std::thread::available_parallelism().map_or(1, std::num::NonZero::get),
            threads => threads,
        };
        Self {
            store,
            folder: data_dir.join(FOLDER),
            prepare,
            owner: owner.to_owned(),
            settings,
            slots: Arc::new(Semaphore::new(attempts.clamp(1, Semaphore::MAX_PERMITS))),
            prepared: Arc::default(),
        }
    }

    fn lease(&self) -> Duration {
        Duration::from_secs(self.settings.lease_secs)
    }

    /// Works until `shutdown`.
    pub async fn run(self, shutdown: CancellationToken) {
        let mut changes = self.store.changes();
        while !shutdown.is_cancelled() {
            let slot = tokio::select! {
                () = shutdown.cancelled() => return,
                slot = self.slots.clone().acquire_owned() => slot,
            };
            let Ok(slot) = slot else { return };
            changes.mark_unchanged();
            match self.store.claim_recording(&self.owner, self.lease(), self.settings.max_deaths).await {
                Ok(Some(claim)) => {
                    let (recorder, shutdown) = (self.clone(), shutdown.clone());
                    tokio::spawn(async move { recorder.work(claim, Arc::new(slot), &shutdown).await });
                    continue;
                }
                Ok(None) => {}
                // The store itself reports outages, once.
                Err(error) if error.outage().is_some() => {}
                Err(error) => {
                    tracing::error!(
                        error = error.chain(),
                        "cannot claim work of a recording; trying again later"
                    )
                }
            }
            drop(slot);
            tokio::select! {
                () = shutdown.cancelled() => {}
                _ = changes.changed() => {}
                () = tokio::time::sleep(Duration::from_millis(self.settings.poll_ms)) => {}
            }
        }
    }

    async fn work(
        &self,
        claim: RecordingClaim,
        slot: Arc<OwnedSemaphorePermit>,
        shutdown: &CancellationToken,
    ) {
        match &claim.work {
            RecordingWork::Attempt(lease) => self.attempt(&claim, lease, slot, shutdown).await,
            RecordingWork::Assembly(lease) => self.assembly(&claim, lease, slot, shutdown).await,
        }
    }

    /// What attempts of a recording share: found once, also by several attempts at a time.
    async fn prepared(
        &self,
        recording: &RecordingRow,
        slot: &Arc<OwnedSemaphorePermit>,
    ) -> Result<Arc<Prepared>, RecordError> {
        let cell = self.cell(&recording.id);
        let found = cell.get_or_try_init(async || {
            let Some(archive) = self.store.blobs().get(&recording.bundle).await? else {
                let message = "the bundle of the scene is lost or damaged; download it once, which makes it again, and \
                               order the episodes then";
                return Ok(Err(Refusal { code: "bundle_lost", message: message.into() }));
            };
            let (prepare, request) = (self.prepare.clone(), recording.request.clone());
            apart(slot, move || {
                Ok(prepare(&archive, &request).map(|preparation| {
                    let identity = preparation.setup.identity();
                    Arc::new(Prepared { preparation, identity })
                }))
            })
            .await
        });
        let found: Result<&Result<Arc<Prepared>, Refusal>, RecordError> = found.await;
        Ok(found?.clone()?)
    }

    fn cell(&self, id: &RecordingId) -> PreparedCell {
        let mut prepared = self.prepared.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(place) = prepared.iter().position(|(known, _)| known == id)
            && let Some(found) = prepared.remove(place)
        {
            prepared.push_back(found.clone());
            return found.1;
        }
        let cell = PreparedCell::default();
        prepared.push_back((id.clone(), cell.clone()));
        while prepared.len() > KEPT_PREPARATIONS {
            prepared.pop_front();
        }
        cell
    }

    /// What follows a try that failed and is made again; the log has the reason.
    fn setback(
        &self,
        claim: &RecordingClaim,
        error: &RecordError,
        code: &'static str,
        charged: bool,
    ) -> Setback {
        let setback = setback(code, error.to_string(), charged, claim.tries, &self.settings);
        tracing::error!(
            recording_id = %claim.recording.id,
            error = runtime::error_chain(error),
            tries = claim.tries,
            delay_secs = setback.delay.as_secs_f32(),
            "work on a recording broke off; it is begun again unless this was the last try"
        );
        setback
    }
}

/// Runs work in a task of its own, so that a panic is an outcome.
async fn guarded(
    work: impl Future<Output = Result<(), RecordError>> + Send + 'static,
) -> Result<(), RecordError> {
    AbortOnDropHandle::new(tokio::spawn(work)).await.unwrap_or(Err(RecordError::Panicked))
}

/// Runs work that blocks for long on a thread of its own, which the end of the process does not wait for. The slot is
/// taken until the work ends, also if its result is not waited for any more.
async fn apart<T: Send + 'static>(
    slot: &Arc<OwnedSemaphorePermit>,
    work: impl FnOnce() -> Result<T, RecordError> + Send + 'static,
) -> Result<T, RecordError> {
    let (answer, result) = oneshot::channel();
    let slot = slot.clone();
    let spawned = std::thread::Builder::new().name("recorder".into()).spawn(move || {
        let done = work();
        drop(slot);
        // The receiver is gone where the work was given up.
        let _ = answer.send(done);
    });
    spawned.map_err(RecordError::file("start a thread for", Path::new(FOLDER)))?;
    result.await.unwrap_or(Err(RecordError::Panicked))
}
