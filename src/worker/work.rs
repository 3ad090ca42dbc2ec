//! The one interface between the worker and what it works on: a `Work` carries out the jobs of some kinds.
//!
//! The worker owns everything that is the same for all kinds (claims, leases, heartbeats, cancellation, deadlines,
//! retries, draining, panics); an implementation owns the work alone.

use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use futures::future::BoxFuture;

use super::Settings;
use crate::pipeline::checkpoint::CancelFlag;
use crate::pipeline::error::StageError;
use store::lifecycle::JobKind;
use store::queue::{AttemptOutcome, Claim, ClaimedWork};

/// Carries out jobs of some kinds: `worker::build::SceneBuilder`, `freezer::Freezer`, `recorder::Recorder` and
/// `executor::Executor`, which `service::worker` and `app::worker` give to the worker.
pub trait Work: Send + Sync {
    /// The kinds of jobs that it carries out.
    fn kinds(&self) -> &'static [JobKind];

    /// Jobs that a process carries out at the same time.
    fn slots(&self, settings: &Settings) -> usize;

    /// Carries out one attempt. A panic is a failed attempt.
    ///
    /// # Errors
    ///
    /// Its class decides whether the job is tried again (see [`super::backoff`]).
    fn run(self: Arc<Self>, attempt: WorkAttempt) -> BoxFuture<'static, Result<AttemptOutcome, StageError>>;

    /// Removes what attempts have left for the next one: the job has ended.
    fn ended(&self, _work: &ClaimedWork) {}
}

/// Interval of the checks whether an attempt is to stop.
const TICK: Duration = Duration::from_millis(100);

/// One attempt at a job.
pub struct WorkAttempt {
    pub claim: Claim,
    /// Raised when the attempt is to stop now: computations poll it.
    pub cancel: CancelFlag,
    /// Raised when the attempt is to stop at the next point where it can go on later.
    pub drain: CancelFlag,
}

impl WorkAttempt {
    /// Returns when the attempt is to stop; for work that cannot go on later where it was.
    pub async fn stopped(&self) {
        while self.cancel.check().and(self.drain.check()).is_ok() {
            tokio::time::sleep(TICK).await;
        }
    }
}

/// Removes the work folder of a job that needs it no more.
pub(crate) fn remove_work_folder(folder: &Path) {
    if folder.exists()
        && let Err(error) = std::fs::remove_dir_all(folder)
    {
        tracing::warn!(%error, folder = %folder.display(), "a work folder was not removed; remove it");
    }
}
