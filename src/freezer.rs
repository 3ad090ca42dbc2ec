//! Freezing datasets and verifying their versions: the work of the jobs `freeze_dataset` and `verify_dataset`.
//!
//! Bundles are copied from the blobs into a work folder ([`sources`]), frozen there by `datasets::freeze`, and the
//! files of the version become blobs ([`versions`]). After a death of the process the work begins again; in the same
//! data directory it goes on where it was, as an interrupted freeze does. Disk: the bundles and the shards together,
//! until the work is done.

mod request;
mod sources;
mod verification;
mod versions;

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use futures::future::BoxFuture;

use crate::pipeline::error::StageError;
use crate::worker::work::remove_work_folder;
use crate::worker::{Settings, Work, WorkAttempt};
use datasets::DatasetError;
use runtime::{ComputationFailed, CpuPool};
use store::datasets::DatasetRow;
use store::lifecycle::JobKind;
use store::queue::{AttemptOutcome, Claim, ClaimedWork};
use store::{Lease, Store, StoreError};

pub use request::{DatasetRequest, DatasetSource};
pub use verification::VerificationResult;
pub use versions::DatasetSummary;

/// Folder of the work in a data directory.
const FOLDER: &str = "datasets";
/// Time between two notes of the progress.
const NOTE_INTERVAL: Duration = Duration::from_secs(1);

/// Reason why work on a dataset did not come to its end.
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
    Panicked(#[from] ComputationFailed),
    /// The attempt was asked to stop.
    #[error("the work was stopped")]
    Stopped,
}

impl FreezeError {
    fn file(attempt: &'static str, path: &Path) -> impl FnOnce(std::io::Error) -> Self {
        let path = path.to_owned();
        move |source| Self::File { attempt, path, source }
    }
}

impl From<FreezeError> for StageError {
    fn from(error: FreezeError) -> Self {
        let message = error.to_string();
        match error {
            FreezeError::Stopped => Self::cancelled(),
            FreezeError::Panicked(died) => {
                Self { code: "internal_error", ..Self::crashed(message).because(died) }
            }
            FreezeError::Store(error) => error.into(),
            FreezeError::File { source, .. } | FreezeError::Dataset(DatasetError::File { source, .. }) => {
                Self::transient("work_folder_unusable", message).because(source)
            }
            FreezeError::Dataset(DatasetError::EmptySplits(_)) => Self::permanent("empty_split", message),
            FreezeError::Dataset(DatasetError::Request(_)) | FreezeError::Request(_) => {
                Self::permanent("no_dataset", message)
            }
            FreezeError::Dataset(_) => Self::permanent("bundle_unusable", message),
        }
    }
}

/// Freezes datasets of a store.
pub struct Freezer {
    store: Store,
    cpu: CpuPool,
    folder: PathBuf,
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
    /// A freezer that works below `data_dir` and computes on `cpu`.
    pub fn new(store: Store, cpu: CpuPool, data_dir: &Path) -> Self {
        Self { store, cpu, folder: data_dir.join(FOLDER) }
    }

    fn folder_of(&self, dataset: &DatasetRow) -> PathBuf {
        self.folder.join(dataset.id.as_str())
    }

    async fn attempt(&self, claim: &Claim, steps: &Steps) -> Result<AttemptOutcome, FreezeError> {
        match &claim.work {
            ClaimedWork::FreezeDataset(dataset) => {
                let version = self.freeze(&claim.lease, dataset, &self.folder_of(dataset), steps).await?;
                Ok(AttemptOutcome::Frozen(version))
            }
            ClaimedWork::VerifyDataset(dataset) => {
                let found = self.verify(dataset, &self.folder_of(dataset), steps).await?;
                Ok(AttemptOutcome::Verified(found))
            }
            _ => Err(FreezeError::Request("a job of another kind came to the freezer; report this".into())),
        }
    }

    /// Notes the steps of an attempt every second, until the future is dropped.
    async fn note_steps(&self, lease: &Lease, steps: &Steps) {
        let mut noted = (0, 0);
        loop {
            tokio::time::sleep(NOTE_INTERVAL).await;
            let now = steps.get();
            if now == noted {
                continue;
            }
            noted = now;
            if let Err(error) = self.store.note_dataset_steps(lease, now).await {
                tracing::debug!(error = error.chain(), "the progress of a dataset was not noted");
            }
        }
    }
}

impl Work for Freezer {
    fn kinds(&self) -> &'static [JobKind] {
        &[JobKind::FreezeDataset, JobKind::VerifyDataset]
    }

    /// The disk holds the bundles and the shards of one dataset.
    fn slots(&self, _: &Settings) -> usize {
        1
    }

    fn run(self: Arc<Self>, attempt: WorkAttempt) -> BoxFuture<'static, Result<AttemptOutcome, StageError>> {
        Box::pin(async move {
            let (claim, steps) = (&attempt.claim, Steps::default());
            let worked = tokio::select! {
                worked = self.attempt(claim, &steps) => worked,
                () = self.note_steps(&claim.lease, &steps) => Err(FreezeError::Stopped),
                () = attempt.stopped() => Err(FreezeError::Stopped),
            };
            Ok(worked?)
        })
    }

    fn ended(&self, work: &ClaimedWork) {
        if let ClaimedWork::FreezeDataset(dataset) | ClaimedWork::VerifyDataset(dataset) = work {
            remove_work_folder(&self.folder_of(dataset));
        }
    }
}
