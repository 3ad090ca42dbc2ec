//! Events become deliveries here, inside the transaction of the change that they tell of.
//!
//! Each place that writes a final state calls this file: a job ends ([`job_ended`]), be it by its worker, a
//! cancellation, a deadline or deaths; a recording ends; a batch ends. Jobs of scenes and datasets tell of those, the
//! jobs of a recording of nothing. A tenant without webhooks costs one search of an index.

use sqlx::{AnyConnection, AssertSqlSafe, Row};
use uuid::Uuid;

use super::MAX_WEBHOOKS;
use super::event::{self, EventType, Message, MessageData};
use crate::lifecycle::{JobKind, JobState};
use crate::{StoreError, database};
use scene::{BatchId, DeliveryId, JobId, RecordingId};

/// A webhook that may want an event.
struct Subscriber {
    tenant_id: String,
    webhook_id: String,
    /// Empty = all.
    events: Vec<EventType>,
}

/// Tells of the end of a job, which the transaction has written with its failure, and the state of its scene.
pub(crate) async fn job_ended(
    connection: &mut AnyConnection,
    job_id: &JobId,
    now_ms: i64,
) -> Result<(), StoreError> {
    let subscribers = subscribers(connection, "jobs", job_id.as_str()).await?;
    if subscribers.is_empty() {
        return Ok(());
    }
    let row = sqlx::query(
        "SELECT jobs.kind AS kind, jobs.state AS state, jobs.failure_code AS code, jobs.scene_id AS scene_id,
                jobs.dataset_id AS dataset_id, scenes.failure_code AS scene_code
         FROM jobs LEFT JOIN scenes ON scenes.id = jobs.scene_id WHERE jobs.id = $1",
    )
    .bind(job_id.as_str())
    .fetch_one(&mut *connection)
    .await?;
    let text = |column: &str| row.try_get::<Option<String>, _>(column);
    let corrupt =
        || StoreError::Corrupt { table: "jobs", reason: format!("kind or state of the ended {job_id}") };
    let kind = text("kind")?.as_deref().and_then(JobKind::parse).ok_or_else(corrupt)?;
    let state = text("state")?.as_deref().and_then(JobState::parse).ok_or_else(corrupt)?;
    let is_quarantined =
        state == JobState::Succeeded && text("scene_code")?.as_deref() == Some("quarantined");
    let failure_code = match state {
        JobState::Cancelled => Some("cancelled".to_owned()),
        JobState::Succeeded if is_quarantined => Some("quarantined".to_owned()),
        _ => text("code")?,
    };
    let (event, id, folder) = match kind {
        JobKind::Generate | JobKind::Retry => {
            let event = match state {
                JobState::Succeeded if is_quarantined => EventType::SceneQuarantined,
                JobState::Succeeded => EventType::SceneSucceeded,
                JobState::Cancelled => EventType::SceneCancelled,
                _ => EventType::SceneFailed,
            };
            (event, text("scene_id")?, "scenes")
        }
        JobKind::FreezeDataset => (EventType::DatasetEnded, text("dataset_id")?, "datasets"),
        JobKind::ExecuteTask | JobKind::VerifyDataset => {
            let event = match state {
                JobState::Succeeded => EventType::JobSucceeded,
                JobState::Cancelled => EventType::JobCancelled,
                _ => EventType::JobFailed,
            };
            (event, Some(job_id.to_string()), "jobs")
        }
        JobKind::RecordAttempt | JobKind::AssembleRecording => return Ok(()),
    };
    let id = id.ok_or_else(corrupt)?;
    let state = match event {
        EventType::DatasetEnded if state == JobState::Succeeded => "finished",
        EventType::DatasetEnded => "failed",
        event => event.as_str().rsplit('.').next().unwrap_or_default(),
    };
    let job_id = (id != job_id.as_str()).then(|| job_id.to_string());
    let path = format!("/{folder}/{id}");
    let data = MessageData { id, state: state.to_owned(), failure_code, job_id, path };
    tell(connection, &subscribers, event, data, now_ms).await
}

/// Tells of the end of a recording, which the transaction has written.
pub(crate) async fn recording_ended(
    connection: &mut AnyConnection,
    id: &RecordingId,
    now_ms: i64,
) -> Result<(), StoreError> {
    let subscribers = subscribers(connection, "recordings", id.as_str()).await?;
    if subscribers.is_empty() {
        return Ok(());
    }
    let row = sqlx::query("SELECT state, failure_code FROM recordings WHERE id = $1")
        .bind(id.as_str())
        .fetch_one(&mut *connection)
        .await?;
    let data = MessageData {
        id: id.to_string(),
        state: row.try_get("state")?,
        failure_code: row.try_get("failure_code")?,
        job_id: None,
        path: format!("/episodes/{id}"),
    };
    tell(connection, &subscribers, EventType::RecordingEnded, data, now_ms).await
}

/// Tells of the end of a batch.
pub(crate) async fn batch_ended(
    connection: &mut AnyConnection,
    id: &BatchId,
    state: &str,
    now_ms: i64,
) -> Result<(), StoreError> {
    let subscribers = subscribers(connection, "batches", id.as_str()).await?;
    let data = MessageData {
        id: id.to_string(),
        state: state.to_owned(),
        failure_code: None,
        job_id: None,
        path: format!("/batches/{id}"),
    };
    tell(connection, &subscribers, EventType::BatchEnded, data, now_ms).await
}

/// Enabled webhooks of the tenant of a row of `table`.
async fn subscribers(
    connection: &mut AnyConnection,
    table: &'static str,
    id: &str,
) -> Result<Vec<Subscriber>, StoreError> {
    let query = format!(
        "SELECT webhooks.id AS webhook_id, webhooks.tenant_id AS tenant_id, webhooks.events AS events
         FROM webhooks WHERE tenant_id = (SELECT tenant_id FROM {table} WHERE id = $1) AND disabled_reason IS NULL
         ORDER BY webhooks.id LIMIT $2"
    );
    let rows =
        sqlx::query(AssertSqlSafe(query)).bind(id).bind(MAX_WEBHOOKS as i64).fetch_all(connection).await?;
    rows.iter()
        .map(|row| {
            Ok(Subscriber {
                tenant_id: row.try_get("tenant_id")?,
                webhook_id: row.try_get("webhook_id")?,
                events: event::of_words(&row.try_get::<String, _>("events")?)?,
            })
        })
        .collect()
}

/// Writes a delivery for each subscriber that wants the event.
async fn tell(
    connection: &mut AnyConnection,
    subscribers: &[Subscriber],
    event: EventType,
    data: MessageData,
    now_ms: i64,
) -> Result<(), StoreError> {
    let payload = Message::text(event, now_ms, data);
    for Subscriber { tenant_id, webhook_id, events } in subscribers {
        if events.is_empty() || events.contains(&event) {
            insert(connection, tenant_id, webhook_id, event, &payload, now_ms).await?;
        }
    }
    Ok(())
}

/// Writes a delivery that is due now.
pub(super) async fn insert(
    connection: &mut AnyConnection,
    tenant_id: &str,
    webhook_id: &str,
    event: EventType,
    payload: &str,
    now_ms: i64,
) -> Result<DeliveryId, StoreError> {
    let id = format!("{}{}", super::delivery::ID_PREFIX, Uuid::now_v7());
    sqlx::query(
        "INSERT INTO deliveries (id, tenant_id, webhook_id, event, payload, state, next_at, created_at)
         VALUES ($1, $2, $3, $4, $5, 'waiting', $6, $7)",
    )
    .bind(&id)
    .bind(tenant_id)
    .bind(webhook_id)
    .bind(event.as_str())
    .bind(payload)
    .bind(now_ms)
    .bind(now_ms)
    .execute(connection)
    .await?;
    database::parse_id(&id, "deliveries")
}
