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
#[cfg(test)]
mod tests;

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use tokio::sync::oneshot;
use tokio_util::sync::CancellationToken;
use tokio_util::task::AbortOnDropHandle;

use crate::worker::Settings;
use crate::worker::verdict::{Verdict, setback};
use datasets::DatasetError;
use store::datasets::{DatasetClaim, DatasetLease, DatasetTask, FreezeResult};
use store::{AfterSetback, Store, StoreError};

pub use request::{DatasetRequest, DatasetSource};

/// Folder of the work in a data directory.
const FOLDER: &str = "datasets";

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
    #[error("a bug stopped the work on this dataset; the server's log has the details")]
    Panicked,
    /// The process ends, or another one has the lease.
    #[error("the work was given up")]
    GivenUp,
}

impl FreezeError {
    fn file(attempt: &'static str, path: &Path) -> impl FnOnce(std::io::Error) -> Self {
        let path = path.to_owned();
        move |source| Self::File { attempt, path, source }
    }

    fn verdict(&self) -> Verdict {
        match self {
            Self::GivenUp | Self::Store(StoreError::DatasetLeaseLost { .. }) => Verdict::GivenUp,
            Self::Panicked => Verdict::of_panic(),
            Self::Store(error) => Verdict::of_store(error),
            Self::File { source, .. } | Self::Dataset(DatasetError::File { source, .. }) => {
                Verdict::of_work_folder(source.kind())
            }
            Self::Dataset(DatasetError::EmptySplits(message)) => {
                Verdict::Refused { code: "empty_split", message: message.clone() }
            }
            Self::Dataset(DatasetError::Request(message)) | Self::Request(message) => {
                Verdict::Refused { code: "no_dataset", message: message.clone() }
            }
            Self::Dataset(error) => Verdict::Refused { code: "bundle_unusable", message: error.to_string() },
        }
    }
}

/// Freezes datasets of a store.
#[derive(Clone)]
pub struct Freezer {
    store: Store,
    folder: PathBuf,
    owner: String,
    settings: Arc<Settings>,
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
    /// A freezer that works below `data_dir`, as the process `owner`. Leases, attempts, deaths and delays are those of
    /// jobs.
    pub fn new(store: Store, data_dir: &Path, owner: &str, settings: Arc<Settings>) -> Self {
        Self { store, folder: data_dir.join(FOLDER), owner: owner.to_owned(), settings }
    }

    fn lease(&self) -> Duration {
        Duration::from_secs(self.settings.lease_secs)
    }

    /// Works until `shutdown`.
    pub async fn run(self, shutdown: CancellationToken) {
        let mut changes = self.store.changes();
        while !shutdown.is_cancelled() {
            changes.mark_unchanged();
            match self.store.claim_dataset(&self.owner, self.lease(), self.settings.max_deaths).await {
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
                () = tokio::time::sleep(Duration::from_millis(self.settings.poll_ms)) => {}
            }
        }
    }

    /// Works on one dataset, and writes down what came of it.
    async fn work(&self, claim: DatasetClaim, shutdown: &CancellationToken) {
        let steps = Steps::default();
        let folder = self.folder.join(claim.lease.id.as_str());
        let task = {
            let (freezer, claim, folder, steps) =
                (self.clone(), claim.clone(), folder.clone(), steps.clone());
            async move {
                match claim.task {
                    DatasetTask::Freeze => freezer.freeze(&claim, &folder, &steps).await,
                    DatasetTask::Verify => freezer.verify(&claim, &folder, &steps).await,
                }
            }
        };
        let worked = tokio::select! {
            worked = guarded(task) => worked,
            () = self.hold(&claim.lease, &steps) => Err(FreezeError::GivenUp),
            () = shutdown.cancelled() => Err(FreezeError::GivenUp),
        };
        self.conclude(&claim, &folder, worked).await;
    }

    /// Writes down what came of the work.
    async fn conclude(&self, claim: &DatasetClaim, folder: &Path, worked: Result<(), FreezeError>) {
        let Err(error) = worked else { return remove(folder) };
        let (lease, id) = (&claim.lease, &claim.lease.id);
        let is_over = match (error.verdict(), claim.task) {
            (Verdict::Refused { code, message }, DatasetTask::Freeze) => {
                tracing::info!(dataset_id = %id, code, message, "a dataset cannot be frozen");
                let result = FreezeResult::Failed { code: code.to_owned(), message };
                self.store.finish_freeze(lease, result).await.map(|()| true)
            }
            (Verdict::Refused { code, .. }, DatasetTask::Verify) => {
                self.set_back(claim, &error, code, true).await
            }
            (Verdict::Again { code, charged }, _) => self.set_back(claim, &error, code, charged).await,
            (Verdict::GivenUp, _) => self.store.release_dataset(lease).await.map(|()| false),
        };
        match is_over {
            Ok(true) => remove(folder),
            // What was copied so far is used again.
            Ok(false) => {}
            Err(error) => {
                tracing::warn!(
                    dataset_id = %id, error = error.chain(),
                    "the end of work on a dataset was not recorded; its lease will run out"
                );
            }
        }
    }

    /// Writes down that an attempt failed; whether it was the last one.
    async fn set_back(
        &self,
        claim: &DatasetClaim,
        error: &FreezeError,
        code: &'static str,
        charged: bool,
    ) -> Result<bool, StoreError> {
        let setback = setback(code, error.to_string(), charged, claim.attempt, &self.settings);
        let delay = setback.delay;
        let after = self.store.set_dataset_back(&claim.lease, setback).await?;
        tracing::error!(
            dataset_id = %claim.lease.id,
            error = runtime::error_chain(error),
            attempt = claim.attempt,
            delay_secs = delay.as_secs_f32(),
            is_last = after == AfterSetback::Ended,
            "work on a dataset broke off; it is begun again unless this was the last attempt"
        );
        Ok(after == AfterSetback::Ended)
    }

    /// Renews the lease; returns when it is lost.
    async fn hold(&self, lease: &DatasetLease, steps: &Steps) {
        loop {
            tokio::time::sleep(self.lease() / 4).await;
            match self.store.renew_dataset(lease, self.lease(), steps.get()).await {
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

/// Runs work in a task of its own, so that a panic is an outcome, not the end of the freezer.
async fn guarded(
    work: impl Future<Output = Result<(), FreezeError>> + Send + 'static,
) -> Result<(), FreezeError> {
    AbortOnDropHandle::new(tokio::spawn(work)).await.unwrap_or(Err(FreezeError::Panicked))
}

/// Removes the work folder of a dataset that needs it no more.
fn remove(folder: &Path) {
    if folder.exists()
        && let Err(error) = std::fs::remove_dir_all(folder)
    {
        tracing::warn!(%error, folder = %folder.display(), "a work folder was not removed; remove it");
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
    // The thread sends unless it panics.
    result.await.unwrap_or(Err(FreezeError::Panicked))
}
