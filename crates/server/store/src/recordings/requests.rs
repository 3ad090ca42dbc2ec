//! Requests of clients: to record demonstrations, and to stop that.

use serde_json::{Map, Value};
use sqlx::{AnyConnection, AssertSqlSafe, Row};
use uuid::Uuid;

use super::events::append;
use super::schedule::enqueue_missing;
use super::{RecordingEventKind, RecordingState, ending, stored};
use crate::boxed;
use crate::database::Dialect;
use crate::limits::{Admission, LimitReached};
use crate::{Digest, Store, StoreError, database};
use scene::{RecordingId, SceneId, TenantId};

/// A recording to be made.
#[derive(Clone, Debug)]
pub struct NewRecording {
    pub tenant_id: TenantId,
    pub scene_id: SceneId,
    /// Request of the recording, as JSON.
    pub request: Value,
    /// The blob of the scene's archive.
    pub bundle: Digest,
    /// Attempts that are to succeed.
    pub wanted: u64,
    pub max_attempts: u64,
    pub idempotency_key: Option<String>,
    pub body_digest: Digest,
}

/// Result of a submission.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum SubmitRecordingOutcome {
    Created(RecordingId),
    /// The key was used before with the same body.
    Replayed(RecordingId),
    /// The key was used before with another body; nothing was enqueued.
    KeyReused,
    /// A limit of the tenant leaves no room; nothing was enqueued.
    Refused(LimitReached),
}

/// Result of a cancellation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CancelRecordingOutcome {
    /// Recording that is cancelled now.
    Accepted,
    /// Recording that had ended already.
    TooLate(RecordingState),
    NotFound,
}

impl Store {
    /// Enqueues a recording, once for each idempotency key.
    #[boxed]
    pub async fn submit_recording(&self, new: NewRecording) -> Result<SubmitRecordingOutcome, StoreError> {
        let admission = self.admission.clone();
        let submitted = self
            .writer
            .write("enqueue a recording", move |connection| {
                Box::pin(async move { submit(connection, new, &admission).await })
            })
            .await?;
        self.announce();
        Ok(submitted)
    }

    /// Cancels a recording that has not ended. Attempts that are being made lose their leases.
    #[boxed]
    pub async fn cancel_recording(
        &self,
        tenant_id: &TenantId,
        id: &RecordingId,
    ) -> Result<CancelRecordingOutcome, StoreError> {
        let (tenant_id, id) = (tenant_id.clone(), id.clone());
        let outcome = self
            .writer
            .write("cancel a recording", move |connection| {
                Box::pin(async move { cancel(connection, &tenant_id, &id).await })
            })
            .await?;
        self.announce_cancellation();
        Ok(outcome)
    }
}

async fn submit(
    connection: &mut AnyConnection,
    new: NewRecording,
    admission: &Admission,
) -> Result<SubmitRecordingOutcome, StoreError> {
    if let Some(key) = &new.idempotency_key {
        let query = "SELECT id, body_digest FROM recordings WHERE tenant_id = $1 AND idempotency_key = $2";
        let earlier = sqlx::query(query)
            .bind(new.tenant_id.as_str())
            .bind(key)
            .fetch_optional(&mut *connection)
            .await?;
        if let Some(earlier) = earlier {
            let is_same = earlier.try_get::<String, _>("body_digest")? == new.body_digest.as_str();
            let id = database::id(&earlier, "recordings", "id")?;
            return Ok(if is_same {
                SubmitRecordingOutcome::Replayed(id)
            } else {
                SubmitRecordingOutcome::KeyReused
            });
        }
    }
    let now = database::now_ms(connection).await?;
    if let Err(reached) = admission.work(connection, &new.tenant_id, now).await? {
        return Ok(SubmitRecordingOutcome::Refused(reached));
    }
    let id: RecordingId = database::parse_id(&Uuid::now_v7().to_string(), "recordings")?;
    sqlx::query(
        "INSERT INTO recordings (id, tenant_id, scene_id, state, request, bundle, wanted, max_attempts, idempotency_key,
                                 body_digest, created_at)
         VALUES ($1, $2, $3, 'queued', $4, $5, $6, $7, $8, $9, $10)",
    )
    .bind(id.as_str())
    .bind(new.tenant_id.as_str())
    .bind(new.scene_id.as_str())
    .bind(new.request.to_string())
    .bind(new.bundle.as_str())
    .bind(stored(new.wanted))
    .bind(stored(new.max_attempts))
    .bind(new.idempotency_key)
    .bind(new.body_digest.as_str())
    .bind(now)
    .execute(&mut *connection)
    .await?;
    append(connection, &id, now, RecordingEventKind::Queued, Map::new()).await?;
    enqueue_missing(connection, &id, now).await?;
    Ok(SubmitRecordingOutcome::Created(id))
}

async fn cancel(
    connection: &mut AnyConnection,
    tenant_id: &TenantId,
    id: &RecordingId,
) -> Result<CancelRecordingOutcome, StoreError> {
    let lock = Dialect::of(connection).lock();
    let query = format!(
        "SELECT state FROM recordings WHERE id = $1 AND tenant_id = $2 AND deleted_at IS NULL {lock}"
    );
    let state: Option<String> = sqlx::query_scalar(AssertSqlSafe(query))
        .bind(id.as_str())
        .bind(tenant_id.as_str())
        .fetch_optional(&mut *connection)
        .await?;
    let Some(state) = state.as_deref().and_then(RecordingState::parse) else {
        return Ok(CancelRecordingOutcome::NotFound);
    };
    if state.is_final() {
        return Ok(CancelRecordingOutcome::TooLate(state));
    }
    let now = database::now_ms(connection).await?;
    ending::cancel(connection, id, None, now).await?;
    Ok(CancelRecordingOutcome::Accepted)
}
