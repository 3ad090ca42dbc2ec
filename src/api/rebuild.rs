//! The answer where stored bytes of a scene are gone or damaged: a job makes them again.

use super::extract::TenantApi;
use crate::problem::{Problem, ProblemType};
use scene::SceneId;
use store::rebuild::RebuildOutcome;

/// Enqueues the job, unless there is one; the answer to the client.
pub async fn missing_bytes(api: &TenantApi, scene_id: &SceneId) -> Problem {
    match api.store.rebuild(&api.tenant_id, scene_id).await {
        Ok(RebuildOutcome::Enqueued(job_id) | RebuildOutcome::Active(job_id)) => Problem::new(
            ProblemType::Unavailable,
            "being_rebuilt",
            format!(
                "the stored bytes are gone, and job {job_id} makes them again; ask again when it has ended"
            ),
        ),
        Ok(RebuildOutcome::Unsuccessful(job_id)) => Problem::new(
            ProblemType::Internal,
            "stored_data_missing",
            format!(
                "the stored bytes are gone, and job {job_id} did not make them; see its failure, then retry it"
            ),
        ),
        Ok(RebuildOutcome::NotFound) => Problem::not_found("scene", scene_id.as_str()),
        Err(error) => error.into(),
    }
}
