//! Recording demonstrations: the work of the jobs `record_attempt` and `assemble_recording`.
//!
//! Each attempt of a recording is a job ([`attempts`]), so any number of processes work on one recording, and a process
//! that dies costs the attempts that it was making. What attempts share takes seconds to find; a process does that once
//! for a recording. When enough have succeeded, or no more are allowed, one job assembles the dataset in a work
//! folder, and stores it ([`assembly`]); it fails where too few have succeeded.

mod assembly;
mod attempts;
mod packing;
#[cfg(test)]
mod tests;

use std::collections::VecDeque;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use futures::future::BoxFuture;
use serde_json::Value;
use tokio::sync::OnceCell;

use crate::pipeline::error::StageError;
use crate::problem::{Problem, ProblemType};
use crate::worker::work::remove_work_folder;
use crate::worker::{Settings, Work, WorkAttempt};
use demonstrations::Setup;
use episodes::EpisodeError;
use episodes::card::DatasetCard;
use runtime::{ComputationFailed, CpuPool};
use scene::RecordingId;
use store::lifecycle::{Failure, FailureClass, JobKind};
use store::queue::{AttemptOutcome, Claim, ClaimedWork};
use store::recordings::RecordingRow;
use store::{Store, StoreError};

/// Folder of the work in a data directory.
const FOLDER: &str = "episodes";
/// Recordings whose shared part is kept in memory.
const KEPT_PREPARATIONS: usize = 2;

/// Data that all attempts of a recording share.
pub struct Preparation {
    pub setup: Setup,
    pub card: DatasetCard,
    /// Whether failures become episodes, too.
    pub keeps_failures: bool,
}

/// Prepares attempts in the scene of an archive, for a stored order. It computes for seconds, so it blocks.
/// `service::worker` passes `App::prepare_recording` of `app::episodes`.
pub type Prepare = Arc<dyn Fn(&[u8], &Value) -> Result<Preparation, Problem> + Send + Sync>;

/// A preparation with the digest of everything that attempts depend on.
struct Prepared {
    preparation: Preparation,
    identity: String,
}

type PreparedCell = Arc<OnceCell<Result<Arc<Prepared>, Problem>>>;

/// Reason why work on a recording did not come to its end.
#[derive(Debug, thiserror::Error)]
enum RecordError {
    #[error(transparent)]
    Store(#[from] StoreError),
    #[error(transparent)]
    Episode(#[from] EpisodeError),
    #[error("cannot {attempt} {path}; free space or correct the permissions there")]
    File { attempt: &'static str, path: PathBuf, source: std::io::Error },
    #[error(transparent)]
    Refused(#[from] Problem),
    #[error("a bug stopped the work on this recording; the server's log has the details")]
    Panicked(#[from] ComputationFailed),
    /// An episode is lost or damaged; its attempt is made again.
    #[error("the episode of attempt {number} is lost or damaged; see whether the disk of the blobs is sound")]
    Episodeless { number: u64 },
    /// The attempt was asked to stop.
    #[error("the work was stopped")]
    Stopped,
}

impl RecordError {
    fn file(attempt: &'static str, path: &Path) -> impl FnOnce(std::io::Error) -> Self {
        let path = path.to_owned();
        move |source| Self::File { attempt, path, source }
    }
}

impl From<RecordError> for StageError {
    fn from(error: RecordError) -> Self {
        let message = error.to_string();
        match error {
            RecordError::Stopped => Self::cancelled(),
            RecordError::Panicked(died) => {
                Self { code: "internal_error", ..Self::crashed(message).because(died) }
            }
            RecordError::Store(error) => error.into(),
            RecordError::File { source, .. } | RecordError::Episode(EpisodeError::Write { source, .. }) => {
                Self::transient("work_folder_unusable", message).because(source)
            }
            RecordError::Episode(EpisodeError::DiskFull { .. }) => {
                let full = std::io::Error::from(std::io::ErrorKind::StorageFull);
                Self::transient("work_folder_unusable", message).because(full)
            }
            RecordError::Episodeless { .. } => Self::transient("episode_lost", message),
            RecordError::Episode(_) => Self::permanent("episode_unusable", message),
            RecordError::Refused(problem) => Self::permanent(problem.own_code(), problem.message()),
        }
    }
}

/// Records demonstrations of a store.
pub struct Recorder {
    store: Store,
    cpu: CpuPool,
    folder: PathBuf,
    prepare: Prepare,
    /// Times that the episode of an attempt may be lost.
    max_losses: u32,
    prepared: Mutex<VecDeque<(RecordingId, PreparedCell)>>,
}

impl Recorder {
    /// A recorder that works below `data_dir` and computes on `cpu`.
    pub fn new(store: Store, cpu: CpuPool, data_dir: &Path, prepare: Prepare, settings: &Settings) -> Self {
        let folder = data_dir.join(FOLDER);
        Self { store, cpu, folder, prepare, max_losses: settings.max_attempts, prepared: Mutex::default() }
    }

    fn folder_of(&self, recording: &RecordingRow) -> PathBuf {
        self.folder.join(recording.id.as_str())
    }

    async fn attempt(&self, claim: &Claim) -> Result<AttemptOutcome, RecordError> {
        match &claim.work {
            ClaimedWork::RecordAttempt(attempt) => {
                Ok(AttemptOutcome::Attempted(self.make(&claim.lease, attempt).await?))
            }
            ClaimedWork::AssembleRecording(recording) => {
                let folder = self.folder_of(recording);
                match self.assemble(&claim.lease, recording, &folder).await {
                    Ok(summary) => Ok(AttemptOutcome::Assembled(summary)),
                    Err(RecordError::Episodeless { number }) => {
                        let failure = Failure {
                            class: FailureClass::Transient,
                            code: "episode_lost".into(),
                            message: RecordError::Episodeless { number }.to_string(),
                        };
                        let max_losses = self.max_losses;
                        Ok(AttemptOutcome::EpisodeLost { number, failure, max_losses })
                    }
                    Err(error) => Err(error),
                }
            }
            _ => {
                let message = "a job of another kind came to the recorder; report this";
                Err(Problem::new(ProblemType::Internal, "internal_error", message).into())
            }
        }
    }

    /// Data that attempts of a recording share: found once, also by several attempts at a time.
    async fn prepared(&self, recording: &RecordingRow) -> Result<Arc<Prepared>, RecordError> {
        let cell = self.cell(&recording.id);
        let found = cell.get_or_try_init(async || {
            let Some(archive) = self.store.blobs().get(&recording.bundle).await? else {
                let message = "the bundle of the scene is lost or damaged; download it once, which makes it again, and \
                               order the episodes then";
                return Ok(Err(Problem::new(ProblemType::Conflict, "bundle_lost", message)));
            };
            let (prepare, request) = (self.prepare.clone(), recording.request.clone());
            let preparing = self.cpu.run(move || {
                prepare(&archive, &request).map(|preparation| {
                    let identity = preparation.setup.identity();
                    Arc::new(Prepared { preparation, identity })
                })
            });
            Ok(preparing.await?)
        });
        let found: Result<&Result<Arc<Prepared>, Problem>, RecordError> = found.await;
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
}

impl Work for Recorder {
    fn kinds(&self) -> &'static [JobKind] {
        &[JobKind::RecordAttempt, JobKind::AssembleRecording]
    }

    /// One for each thread that computes: an attempt keeps one busy.
    fn slots(&self, settings: &Settings) -> usize {
        settings.threads()
    }

    fn run(self: Arc<Self>, attempt: WorkAttempt) -> BoxFuture<'static, Result<AttemptOutcome, StageError>> {
        Box::pin(async move {
            let worked = tokio::select! {
                worked = self.attempt(&attempt.claim) => worked,
                () = attempt.stopped() => Err(RecordError::Stopped),
            };
            Ok(worked?)
        })
    }

    fn ended(&self, work: &ClaimedWork) {
        if let ClaimedWork::AssembleRecording(recording) = work {
            remove_work_folder(&self.folder_of(recording));
        }
    }
}
