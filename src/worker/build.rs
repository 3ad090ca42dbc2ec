//! What the worker is given to build scenes with: the pipeline, as a function.

use std::sync::Arc;

use futures::future::BoxFuture;

use crate::pipeline::checkpoint::{CancelFlag, Checkpoints};
use crate::pipeline::error::StageError;
use scene::{JobId, SceneId, SceneRequest};

/// The finished scene's blobs (stored already) and its summary.
pub use store::artifacts::{ArchiveRow, BuiltScene, FileRow};

/// The whole pipeline: a request in, a stored bundle out. Made by `app::pipeline::build_pipeline`; calls
/// `pipeline::build_scene`.
pub type BuildScene =
    Arc<dyn Fn(JobContext) -> BoxFuture<'static, Result<BuiltScene, StageError>> + Send + Sync>;

/// One job, as the pipeline sees it.
pub struct JobContext {
    pub job_id: JobId,
    pub scene_id: SceneId,
    pub request: SceneRequest,
    /// Runs the stages; give it the stages and the ports with `for_stages`.
    pub checkpoints: Checkpoints,
    /// Raised when the job is to stop.
    pub cancel: CancelFlag,
}
