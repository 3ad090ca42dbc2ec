//! What the worker is given to build scenes with: the pipeline, as a function.

use std::sync::Arc;

use futures::future::BoxFuture;

use crate::pipeline::checkpoint::{Checkpoints, Interrupt};
use crate::pipeline::error::StageError;
use scene::job::SceneRequest;

/// The finished scene's blobs (put already) and what is told about it.
pub use store::artifacts::{ArchiveRow, BuiltRows as BuiltScene, FileRow};

/// The whole pipeline: a request in, a stored bundle out.
pub type BuildScene =
    Arc<dyn Fn(JobContext) -> BoxFuture<'static, Result<BuiltScene, StageError>> + Send + Sync>;

/// One job, as the pipeline sees it.
pub struct JobContext {
    pub job_id: String,
    pub scene_id: String,
    pub request: SceneRequest,
    /// Runs the stages; give it the ports with `with_services`.
    pub checkpoints: Checkpoints,
    /// Raised when the job is to stop.
    pub interrupt: Interrupt,
}
