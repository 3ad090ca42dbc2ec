//! Building scenes: the pipeline as the work of the jobs `generate` and `retry`.

use std::sync::Arc;

use futures::future::BoxFuture;

use super::Settings;
use super::work::{Work, WorkAttempt};
use crate::pipeline::checkpoint::{Checkpoints, JobScope, StageRuntime};
use crate::pipeline::error::StageError;
use scene::SceneRequest;
use store::lifecycle::JobKind;
use store::queue::{AttemptOutcome, ClaimedWork};

/// The finished scene's blobs (stored already) and its summary.
pub use store::artifacts::{ArchiveRow, BuiltScene, FileRow};

/// The whole pipeline: a request in, a stored bundle out. Made by `app::pipeline::build_pipeline`; calls
/// `pipeline::build_scene`.
pub type BuildScene =
    Arc<dyn Fn(JobContext) -> BoxFuture<'static, Result<BuiltScene, StageError>> + Send + Sync>;

/// One job, as the pipeline sees it.
pub struct JobContext {
    pub request: SceneRequest,
    /// Runs the stages; give it the stages and the ports with `for_stages`.
    pub checkpoints: Checkpoints,
}

/// Builds scenes.
pub struct SceneBuilder {
    pub runtime: StageRuntime,
    pub build: BuildScene,
}

impl Work for SceneBuilder {
    fn kinds(&self) -> &'static [JobKind] {
        &[JobKind::Generate, JobKind::Retry]
    }

    fn slots(&self, settings: &Settings) -> usize {
        settings.concurrency
    }

    fn run(self: Arc<Self>, attempt: WorkAttempt) -> BoxFuture<'static, Result<AttemptOutcome, StageError>> {
        Box::pin(async move {
            let WorkAttempt { claim, cancel, drain } = attempt;
            let ClaimedWork::BuildScene(scene) = claim.work else {
                return Err(StageError::crashed("a job of another kind came to the builder of scenes"));
            };
            let request: SceneRequest = serde_json::from_value(scene.request).map_err(|error| {
                let message = "the stored request belongs to another version; submit it again";
                StageError::permanent("request_unreadable", message).because(error)
            })?;
            let checkpoints = self.runtime.open(JobScope {
                lease: claim.lease,
                tenant_id: claim.tenant_id,
                salt: scene.salt,
                cancel,
                drain,
            });
            let built = (self.build)(JobContext { request, checkpoints }).await?;
            Ok(AttemptOutcome::Built(Box::new(built)))
        })
    }
}
