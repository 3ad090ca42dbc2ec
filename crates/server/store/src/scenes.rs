//! Rows of scenes. A submission writes the scene, its job, its first event and the idempotency row in one transaction.

mod labels;
mod listing;

use std::collections::BTreeMap;

use serde_json::{Value, json};
use sqlx::any::AnyRow;
use sqlx::{AnyConnection, Row};
use uuid::Uuid;

use super::audit::{self, AuditEntry};
use super::jobs::JobRow;
use super::limits::{Admission, LimitReached};
use super::queue::{NewJob, QueueColumns, Schedule, cancel_jobs_of};
use super::{Store, StoreError, database};
use crate::boxed;
use crate::deletion::DeleteOutcome;
use crate::lifecycle::SceneState;
use scene::{JobId, SceneId, TenantId};

pub use labels::LabelsOutcome;
pub use listing::{MAX_COUNTED, SceneCounts, SceneFilter, SceneKind};

/// Lifetime of an idempotency key.
const IDEMPOTENCY_MS: i64 = 24 * 3600 * 1000;

/// A scene to submit.
#[derive(Clone, Debug)]
pub struct NewScene {
    pub tenant_id: TenantId,
    /// The scene that it is made from, of the same tenant.
    pub parent_id: Option<SceneId>,
    /// The versioned request, as JSON.
    pub request: Value,
    pub labels: BTreeMap<String, String>,
    /// Maximum total cost of remote calls, millionths of a US dollar.
    pub budget_micro_usd: i64,
    /// The client's idempotency key, and a digest of the request body.
    pub idempotency: Option<(String, String)>,
}

/// Result of a submission.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum SubmitOutcome {
    Created {
        scene_id: SceneId,
        job_id: JobId,
        /// Rows that were written, so that an answer need not read them.
        rows: Box<NewRows>,
    },
    /// The key was used before with the same body; these are the ids of the first submission.
    Replayed { scene_id: SceneId, job_id: JobId },
    /// The key was used before with another body; nothing was enqueued.
    KeyReused,
    /// A limit leaves no room; nothing was enqueued.
    Refused(LimitReached),
}

/// The rows of a new scene, as they were committed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NewRows {
    pub scene: SceneRow,
    pub job: JobRow,
    /// Jobs of the tenant that wait, with this one; `None` where its schedule puts it before or behind others.
    pub(super) last_place: Option<i64>,
}

/// A scene's row.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SceneRow {
    pub id: SceneId,
    pub parent_id: Option<SceneId>,
    pub state: SceneState,
    /// `pass` or `quarantine`, once certified.
    pub verdict: Option<String>,
    pub failure_code: Option<String>,
    pub failure_message: Option<String>,
    pub request: Value,
    pub labels: BTreeMap<String, String>,
    pub summary: Option<Value>,
    pub metrics: Option<Value>,
    pub created_at_ms: i64,
    pub updated_at_ms: i64,
}

impl Store {
    /// Stores a scene and enqueues its job, once per idempotency key: for now, without a deadline, however long the
    /// queue is.
    #[boxed]
    pub async fn submit(&self, new: NewScene) -> Result<SubmitOutcome, StoreError> {
        self.enqueue(new, None, None).await
    }

    /// The same with a schedule, if the limits leave room. A new scene is recorded by `entry`, in its transaction.
    #[boxed]
    pub async fn submit_scheduled(
        &self,
        new: NewScene,
        schedule: Schedule,
        entry: Option<AuditEntry>,
    ) -> Result<SubmitOutcome, StoreError> {
        self.enqueue(new, Some(schedule), entry).await
    }

    async fn enqueue(
        &self,
        new: NewScene,
        schedule: Option<Schedule>,
        entry: Option<AuditEntry>,
    ) -> Result<SubmitOutcome, StoreError> {
        let admission = self.admission.clone();
        // A repeated key is answered with its scene, so only the database can tell what to answer.
        if let (Some(_), None) = (&schedule, &new.idempotency)
            && let Some(reached) = admission.recent_refusal(&new.tenant_id)
        {
            return Ok(SubmitOutcome::Refused(reached));
        }
        let submitted = self
            .writer
            .write("enqueue a scene", move |connection| {
                Box::pin(async move {
                    let outcome = submit(connection, new, schedule, Some(&admission)).await?;
                    if let (SubmitOutcome::Created { .. }, Some(entry)) = (&outcome, &entry) {
                        audit::insert(connection, entry).await?;
                    }
                    Ok(outcome)
                })
            })
            .await?;
        if matches!(submitted, SubmitOutcome::Created { .. }) {
            self.announce();
        }
        Ok(submitted)
    }

    /// A scene of the tenant, including deleted scenes.
    #[boxed]
    pub async fn scene(&self, tenant_id: &TenantId, id: &SceneId) -> Result<Option<SceneRow>, StoreError> {
        let row = sqlx::query("SELECT * FROM scenes WHERE id = $1 AND tenant_id = $2")
            .bind(id.as_str())
            .bind(tenant_id.as_str())
            .fetch_optional(&self.readers)
            .await?;
        row.as_ref().map(scene_of).transpose()
    }

    /// Marks a scene as deleted and cancels its active jobs.
    #[boxed]
    pub async fn delete_scene(
        &self,
        tenant_id: &TenantId,
        id: &SceneId,
    ) -> Result<DeleteOutcome, StoreError> {
        let (tenant_id, id) = (tenant_id.clone(), id.clone());
        let deleted = self
            .writer
            .write("delete a scene", move |connection| Box::pin(delete(connection, tenant_id, id)))
            .await?;
        self.announce_cancellation();
        Ok(deleted)
    }
}

/// Writes the rows of a new scene. With a schedule and an admission its limits are held.
pub(super) async fn submit(
    connection: &mut AnyConnection,
    new: NewScene,
    schedule: Option<Schedule>,
    admission: Option<&Admission>,
) -> Result<SubmitOutcome, StoreError> {
    let now = database::now_ms(connection).await?;
    if let Some((key, body_digest)) = &new.idempotency {
        sqlx::query("DELETE FROM idempotency WHERE expires_at <= $1")
            .bind(now)
            .execute(&mut *connection)
            .await?;
        let earlier = sqlx::query(
            "SELECT body_digest, scene_id, job_id FROM idempotency WHERE tenant_id = $1 AND key = $2",
        )
        .bind(new.tenant_id.as_str())
        .bind(key)
        .fetch_optional(&mut *connection)
        .await?;
        if let Some(earlier) = earlier {
            return Ok(if earlier.try_get::<String, _>("body_digest")? == *body_digest {
                SubmitOutcome::Replayed {
                    scene_id: database::id(&earlier, "idempotency", "scene_id")?,
                    job_id: database::id(&earlier, "idempotency", "job_id")?,
                }
            } else {
                SubmitOutcome::KeyReused
            });
        }
    }
    // A repeated key is answered with its scene, also where a limit is reached.
    let mut last_place = None;
    if let (Some(schedule), Some(admission)) = (&schedule, admission) {
        let max_scenes = schedule.queue.max_jobs;
        match admission.scene(connection, &new.tenant_id, max_scenes, now).await? {
            Ok(place) => last_place = schedule.is_usual().then_some(place),
            Err(reached) => return Ok(SubmitOutcome::Refused(reached)),
        }
    }
    let columns = QueueColumns::of_new(schedule.as_ref(), &new.request, now);
    let scene_id: SceneId = database::parse_id(&Uuid::now_v7().to_string(), "scenes")?;
    sqlx::query(
        "INSERT INTO scenes (id, tenant_id, parent_id, state, request, labels, budget_micro_usd, created_at, updated_at)
         VALUES ($1, $2, $3, 'pending', $4, $5, $6, $7, $8)",
    )
    .bind(scene_id.as_str())
    .bind(new.tenant_id.as_str())
    .bind(new.parent_id.as_ref().map(SceneId::as_str))
    .bind(new.request.to_string())
    .bind(json!(new.labels).to_string())
    .bind(new.budget_micro_usd)
    .bind(now)
    .bind(now)
    .execute(&mut *connection)
    .await?;
    let job = NewJob::of_scene(&new.tenant_id, &scene_id, columns).insert(connection, now).await?;
    let job_id = job.id.clone();
    if let Some((key, body_digest)) = new.idempotency {
        sqlx::query(
            "INSERT INTO idempotency (tenant_id, key, body_digest, scene_id, job_id, expires_at)
             VALUES ($1, $2, $3, $4, $5, $6)",
        )
        .bind(new.tenant_id.as_str())
        .bind(key)
        .bind(body_digest)
        .bind(scene_id.as_str())
        .bind(job_id.as_str())
        .bind(now + IDEMPOTENCY_MS)
        .execute(connection)
        .await?;
    }
    let scene = SceneRow {
        id: scene_id.clone(),
        parent_id: new.parent_id,
        state: SceneState::Pending,
        verdict: None,
        failure_code: None,
        failure_message: None,
        request: new.request,
        labels: new.labels,
        summary: None,
        metrics: None,
        created_at_ms: now,
        updated_at_ms: now,
    };
    Ok(SubmitOutcome::Created { scene_id, job_id, rows: Box::new(NewRows { scene, job, last_place }) })
}

pub(super) async fn delete(
    connection: &mut AnyConnection,
    tenant_id: TenantId,
    id: SceneId,
) -> Result<DeleteOutcome, StoreError> {
    let now = database::now_ms(connection).await?;
    // Deleted again, it is removed no later.
    let changed = sqlx::query(
        "UPDATE scenes SET state = 'deleted',
                           stripped_at = CASE WHEN state = 'deleted' THEN stripped_at END,
                           updated_at = CASE WHEN state = 'deleted' THEN updated_at ELSE $1 END
         WHERE id = $2 AND tenant_id = $3",
    )
    .bind(now)
    .bind(id.as_str())
    .bind(tenant_id.as_str())
    .execute(&mut *connection)
    .await?;
    if changed.rows_affected() == 0 {
        return Ok(DeleteOutcome::NotFound);
    }
    cancel_jobs_of(connection, "scene_id", id.as_str(), now).await?;
    Ok(DeleteOutcome::Done)
}

pub(super) fn scene_of(row: &AnyRow) -> Result<SceneRow, StoreError> {
    let state: String = row.try_get("state")?;
    let json = |column: &'static str| -> Result<Option<Value>, StoreError> {
        let text: Option<String> = row.try_get(column)?;
        text.map(|text| serde_json::from_str(&text))
            .transpose()
            .map_err(|error| corrupt(format!("{column}: {error}")))
    };
    let labels = json("labels")?.unwrap_or_else(|| json!({}));
    Ok(SceneRow {
        id: database::id(row, "scenes", "id")?,
        parent_id: database::optional_id(row, "scenes", "parent_id")?,
        state: SceneState::parse(&state).ok_or_else(|| corrupt(format!("state {state}")))?,
        verdict: row.try_get("verdict")?,
        failure_code: row.try_get("failure_code")?,
        failure_message: row.try_get("failure_message")?,
        request: json("request")?.unwrap_or_default(),
        labels: serde_json::from_value(labels).map_err(|error| corrupt(format!("labels: {error}")))?,
        summary: json("summary")?,
        metrics: json("metrics")?,
        created_at_ms: row.try_get("created_at")?,
        updated_at_ms: row.try_get("updated_at")?,
    })
}

fn corrupt(reason: String) -> StoreError {
    StoreError::Corrupt { table: "scenes", reason }
}
