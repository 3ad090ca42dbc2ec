//! Bytes that are gone or damaged are made again: a job of a finished scene computes what its checkpoints lack.
//!
//! Stages are functions of their keys, so the bytes, and with them the names, are the same as before.

use sqlx::{AnyConnection, Row};

use super::queue::{JobSubject, NewJob, QueueColumns};
use super::{Store, StoreError, database};
use crate::boxed;
use crate::lifecycle::{JobKind, JobState};
use scene::{JobId, SceneId, TenantId};

/// Result of a request to make a scene's bytes again.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum RebuildOutcome {
    /// A job was enqueued.
    Enqueued(JobId),
    /// A job of the scene is active already.
    Active(JobId),
    /// The newest job of the scene, which would have made them, did not succeed.
    Unsuccessful(JobId),
    NotFound,
}

impl Store {
    /// Enqueues a job that makes the missing bytes of a finished scene again. The scene stays as it is meanwhile.
    ///
    /// # Errors
    ///
    /// A [`StoreError`] if the database does not answer.
    #[boxed]
    pub async fn rebuild(
        &self,
        tenant_id: &TenantId,
        scene_id: &SceneId,
    ) -> Result<RebuildOutcome, StoreError> {
        let (tenant_id, scene_id) = (tenant_id.clone(), scene_id.clone());
        let outcome = self
            .writer
            .write("rebuild a scene", move |connection| {
                Box::pin(async move { rebuild(connection, &tenant_id, &scene_id).await })
            })
            .await?;
        if matches!(outcome, RebuildOutcome::Enqueued(_)) {
            self.announce();
        }
        Ok(outcome)
    }
}

async fn rebuild(
    connection: &mut AnyConnection,
    tenant_id: &TenantId,
    scene_id: &SceneId,
) -> Result<RebuildOutcome, StoreError> {
    let newest = sqlx::query(
        "SELECT jobs.id, jobs.state, jobs.from_stage, jobs.salt
         FROM jobs JOIN scenes ON scenes.id = jobs.scene_id
         WHERE jobs.scene_id = $1 AND jobs.tenant_id = $2 AND scenes.state <> 'deleted'
         ORDER BY jobs.id DESC LIMIT 1",
    )
    .bind(scene_id.as_str())
    .bind(tenant_id.as_str())
    .fetch_optional(&mut *connection)
    .await?;
    let Some(newest) = newest else { return Ok(RebuildOutcome::NotFound) };
    let job_id: JobId = database::id(&newest, "jobs", "id")?;
    match JobState::parse(&newest.try_get::<String, _>("state")?) {
        Some(JobState::Succeeded) => {}
        Some(state) if state.is_final() => return Ok(RebuildOutcome::Unsuccessful(job_id)),
        _ => return Ok(RebuildOutcome::Active(job_id)),
    }
    let now = database::now_ms(connection).await?;
    // With its salt, the new job finds the same checkpoints.
    let (stage, salt): (Option<String>, Option<String>) =
        (newest.try_get("from_stage")?, newest.try_get("salt")?);
    let salted_from = stage.as_deref().map(|stage| (stage, salt.as_deref()));
    let columns = QueueColumns::of_retry(connection, &job_id, now).await?;
    let new = NewJob {
        retry_of: Some(&job_id),
        salted_from,
        ..NewJob::new(tenant_id, JobKind::Retry, JobSubject::Scene(scene_id), columns)
    };
    let rebuilt = new.insert(connection, now).await?;
    tracing::warn!(%scene_id, job_id = %rebuilt.id, "stored bytes of a scene are gone; a job makes them again");
    Ok(RebuildOutcome::Enqueued(rebuilt.id))
}
