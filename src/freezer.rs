//! The freezer: it freezes datasets and verifies versions in the background, one at a time in each process.
//!
//! A dataset is claimed with a lease, which is renewed while the work goes on. Bundles are copied from the blobs into
//! a work folder ([`sources`]), frozen there by `datasets::freeze`, and the files of the version become blobs
//! ([`versions`]). After a death of the process the work begins again; in the same data directory it goes on where it
//! was, as an interrupted freeze does. Disk: the bundles and the shards together, until the work is done.

mod request;
mod sources;
mod verification;
mod versions;

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use tokio::sync::oneshot;
use tokio_util::sync::CancellationToken;
use uuid::Uuid;

use datasets::DatasetError;
use store::datasets::{DatasetClaim, DatasetLease, DatasetTask, FreezeResult};
use store::{Store, StoreError};

pub use request::{DatasetRequest, DatasetSource};

/// Folder of the work in a data directory.
const FOLDER: &str = "datasets";
/// Pause after the store failed.
const PAUSE: Duration = Duration::from_secs(5);

/// Why work on a dataset did not come to its end.
#[derive(Debug, thiserror::Error)]
pub(crate) enum FreezeError {
    #[error(transparent)]
    Store(#[from] StoreError),
    #[error(transparent)]
    Dataset(#[from] DatasetError),
    #[error("cannot {attempt} {path}; free space or correct the permissions there")]
    File { attempt: &'static str, path: PathBuf, source: std::io::Error },
    #[error("{0}")]
    Request(String),
    /// The process ends, or another one has the lease.
    #[error("the work was given up")]
    GivenUp,
}

impl FreezeError {
    fn file(attempt: &'static str, path: &Path) -> impl FnOnce(std::io::Error) -> Self {
        let path = path.to_owned();
        move |source| Self::File { attempt, path, source }
    }

    /// Code and message for clients; `None` where the work is to be begun again.
    fn failure(&self) -> Option<(&'static str, String)> {
        match self {
            Self::Store(_) | Self::File { .. } | Self::GivenUp | Self::Dataset(DatasetError::File { .. }) => {
                None
            }
            Self::Dataset(DatasetError::EmptySplits(message)) => Some(("empty_split", message.clone())),
            Self::Dataset(DatasetError::Request(message)) => Some(("no_dataset", message.clone())),
            Self::Dataset(error) => Some(("bundle_unusable", error.to_string())),
            Self::Request(message) => Some(("no_dataset", message.clone())),
        }
    }
}

/// Freezes datasets of a store.
#[derive(Clone)]
pub struct Freezer {
    store: Store,
    folder: PathBuf,
    owner: String,
    lease: Duration,
    poll: Duration,
}

/// Steps of the work in progress, done and all.
#[derive(Clone, Default)]
pub(crate) struct Steps(Arc<(AtomicU64, AtomicU64)>);

impl Steps {
    pub(crate) fn set(&self, done: usize, all: usize) {
        self.0.0.store(done as u64, Ordering::Relaxed);
        self.0.1.store(all as u64, Ordering::Relaxed);
    }

    fn get(&self) -> (i64, i64) {
        let number = |count: &AtomicU64| i64::try_from(count.load(Ordering::Relaxed)).unwrap_or(i64::MAX);
        (number(&self.0.0), number(&self.0.1))
    }
}

impl Freezer {
    /// A freezer that works below `data_dir`. A dataset of a dead process is taken over after `lease`.
    pub fn new(store: Store, data_dir: &Path, lease: Duration, poll: Duration) -> Self {
        Self { store, folder: data_dir.join(FOLDER), owner: Uuid::new_v4().to_string(), lease, poll }
    }

    /// Works until `shutdown`.
    pub async fn run(self, shutdown: CancellationToken) {
        let mut changes = self.store.changes();
        while !shutdown.is_cancelled() {
            changes.mark_unchanged();
            match self.store.claim_dataset(&self.owner, self.lease).await {
                Ok(Some(claim)) => {
                    self.work(claim, &shutdown).await;
                    continue;
                }
                Ok(None) => {}
                // The store itself reports outages, once.
                Err(error) if error.outage().is_some() => {}
                Err(error) => {
                    tracing::error!(error = error.chain(), "cannot claim a dataset; trying again later")
                }
            }
            tokio::select! {
                () = shutdown.cancelled() => {}
                _ = changes.changed() => {}
                () = tokio::time::sleep(self.poll) => {}
            }
        }
    }

    /// Works on one dataset, and writes down what came of it.
    async fn work(&self, claim: DatasetClaim, shutdown: &CancellationToken) {
        let (lease, id) = (claim.lease.clone(), claim.lease.id.clone());
        let steps = Steps::default();
        let folder = self.folder.join(id.as_str());
        let task = async {
            match claim.task {
                DatasetTask::Freeze => self.freeze(&claim, &folder, &steps).await,
                DatasetTask::Verify => self.verify(&claim, &folder, &steps).await,
            }
        };
        let worked = tokio::select! {
            worked = task => worked,
            () = self.hold(&lease, &steps) => Err(FreezeError::GivenUp),
            () = shutdown.cancelled() => Err(FreezeError::GivenUp),
        };
        let ended = match worked {
            Ok(()) => Ok(()),
            Err(error) => match (error.failure(), claim.task) {
                (Some((code, message)), DatasetTask::Freeze) => {
                    tracing::info!(dataset_id = %id, code, message, "a dataset cannot be frozen");
                    let result = FreezeResult::Failed { code: code.to_owned(), message };
                    self.store.finish_freeze(&lease, result).await
                }
                _ => {
                    if !matches!(error, FreezeError::GivenUp) {
                        let error = runtime::error_chain(&error);
                        tracing::error!(dataset_id = %id, error, "work on a dataset broke off; it is begun again");
                        tokio::time::sleep(PAUSE).await;
                    }
                    // What was copied so far is used again.
                    return self.release(&lease).await;
                }
            },
        };
        if let Err(error) = ended {
            tracing::warn!(dataset_id = %id, error = error.chain(), "the end of a dataset was not recorded");
        }
        if folder.exists()
            && let Err(error) = std::fs::remove_dir_all(&folder)
        {
            tracing::warn!(%error, folder = %folder.display(), "a work folder was not removed; remove it");
        }
    }

    async fn release(&self, lease: &DatasetLease) {
        if let Err(error) = self.store.release_dataset(lease).await {
            tracing::debug!(error = error.chain(), "a dataset was not given back; its lease will run out");
        }
    }

    /// Renews the lease; returns when it is lost.
    async fn hold(&self, lease: &DatasetLease, steps: &Steps) {
        loop {
            tokio::time::sleep(self.lease / 4).await;
            match self.store.renew_dataset(lease, self.lease, steps.get()).await {
                Ok(true) => {}
                Ok(false) => return,
                // The next renewal may succeed before the lease has run out.
                Err(error) => {
                    tracing::debug!(error = error.chain(), "the lease of a dataset was not renewed")
                }
            }
        }
    }
}

/// Runs work that blocks for long on a thread of its own, which the end of the process does not wait for.
pub(crate) async fn apart<T: Send + 'static>(
    work: impl FnOnce() -> Result<T, FreezeError> + Send + 'static,
) -> Result<T, FreezeError> {
    let (answer, result) = oneshot::channel();
    let spawned = std::thread::Builder::new().name("freezer".into()).spawn(move || {
        // The receiver is gone where the work was given up.
        let _ = answer.send(work());
    });
    spawned.map_err(FreezeError::file("start a thread for", Path::new(FOLDER)))?;
    result.await.unwrap_or(Err(FreezeError::GivenUp))
}
