//! One item at a time: pending items are read, and get a scene and a job, or end without one.

use std::collections::BTreeMap;

use ::batches::{OutputError, RequestState};
use serde_json::Value;
use sqlx::any::AnyRow;
use sqlx::{AnyConnection, Row};

use super::{BatchRow, assign_job, corrupt_item, error_text};
use crate::jobs::{self, RetryOutcome};
use crate::lifecycle::SceneState;
use crate::queue::{self, Schedule};
use crate::scenes::{self, NewScene, SubmitOutcome};
use crate::{StoreError, database};
use scene::{BatchId, JobId, MicroUsd, SceneId};

/// A pending item.
pub(super) struct PendingItem {
    pub(super) place: i64,
    custom_id: Option<String>,
    request: Value,
    labels: Value,
    pub(super) budget: MicroUsd,
    /// By earlier runs.
    pub(super) spent: MicroUsd,
    /// Scene and newest job of an earlier run.
    earlier: Option<(SceneId, JobId)>,
}

/// The first pending items.
pub(super) async fn pending_items(
    connection: &mut AnyConnection,
    id: &BatchId,
    limit: i64,
) -> Result<Vec<PendingItem>, StoreError> {
    let rows = sqlx::query(
        "SELECT place, custom_id, request, labels, budget_micro_usd, spent_micro_usd, scene_id, job_id
         FROM batch_items WHERE batch_id = $1 AND state = 'pending' ORDER BY place LIMIT $2",
    )
    .bind(id.as_str())
    .bind(limit)
    .fetch_all(connection)
    .await?;
    rows.iter().map(pending_item).collect()
}

fn pending_item(row: &AnyRow) -> Result<PendingItem, StoreError> {
    let json = |column: &str| -> Result<Value, StoreError> {
        let text: Option<String> = row.try_get(column)?;
        serde_json::from_str(&text.unwrap_or_default())
            .map_err(|error| corrupt_item(format!("{column}: {error}")))
    };
    Ok(PendingItem {
        place: row.try_get("place")?,
        custom_id: row.try_get("custom_id")?,
        request: json("request")?,
        labels: json("labels")?,
        budget: MicroUsd(row.try_get("budget_micro_usd")?),
        spent: MicroUsd(row.try_get("spent_micro_usd")?),
        earlier: Option::zip(
            database::optional_id(row, "batch_items", "scene_id")?,
            database::optional_id(row, "batch_items", "job_id")?,
        ),
    })
}

/// Gives an item its scene and a job; `None` if its scene of an earlier run is deleted.
pub(super) async fn begin(
    connection: &mut AnyConnection,
    batch: &BatchRow,
    item: &PendingItem,
    granted: MicroUsd,
    queue: &queue::Settings,
) -> Result<Option<(SceneId, JobId)>, StoreError> {
    if let Some((scene_id, job_id)) = &item.earlier {
        return begin_again(connection, batch, scene_id, job_id, MicroUsd(item.spent.0 + granted.0)).await;
    }
    let mut labels: BTreeMap<String, String> = serde_json::from_value(item.labels.clone())
        .map_err(|error| corrupt_item(format!("labels: {error}")))?;
    labels.entry("batch".to_owned()).or_insert_with(|| batch.id.to_string());
    if let Some(custom_id) = &item.custom_id {
        labels.entry("custom_id".to_owned()).or_insert_with(|| custom_id.clone());
    }
    let new = NewScene {
        tenant_id: batch.tenant_id.clone(),
        parent_id: None,
        request: item.request.clone(),
        labels,
        budget_micro_usd: granted.0,
        idempotency: None,
    };
    let schedule = Schedule::usual(queue.clone());
    match scenes::submit(connection, new, Some(schedule), None).await? {
        SubmitOutcome::Created { scene_id, job_id, .. } => Ok(Some((scene_id, job_id))),
        other => Err(corrupt_item(format!("a submission without a key became {other:?}"))),
    }
}

/// Retries the newest job of a scene, which may spend so much in all.
async fn begin_again(
    connection: &mut AnyConnection,
    batch: &BatchRow,
    scene_id: &SceneId,
    job_id: &JobId,
    budget: MicroUsd,
) -> Result<Option<(SceneId, JobId)>, StoreError> {
    sqlx::query("UPDATE scenes SET budget_micro_usd = $1 WHERE id = $2")
        .bind(budget.0)
        .bind(scene_id.as_str())
        .execute(&mut *connection)
        .await?;
    let retried = jobs::retry(connection, batch.tenant_id.clone(), job_id.clone(), None, None).await?;
    Ok(match retried {
        RetryOutcome::Created { job_id } => Some((scene_id.clone(), job_id)),
        // Another client retried the job, and perhaps it has succeeded by now.
        RetryOutcome::StillActive | RetryOutcome::SceneIs(SceneState::Ready) => {
            Some((scene_id.clone(), job_id.clone()))
        }
        RetryOutcome::NotFound
        | RetryOutcome::SceneIs(_)
        | RetryOutcome::NothingToRepeat
        | RetryOutcome::NoSuchStage
        | RetryOutcome::Refused(_) => None,
    })
}

/// Notes that an item has its scene and its job.
pub(super) async fn submitted(
    connection: &mut AnyConnection,
    id: &BatchId,
    place: i64,
    scene_id: &SceneId,
    job_id: &JobId,
) -> Result<(), StoreError> {
    assign_job(connection, job_id, id.as_str()).await?;
    sqlx::query(
        "UPDATE batch_items SET state = 'submitted', scene_id = $1, job_id = $2 WHERE batch_id = $3 AND place = $4",
    )
    .bind(scene_id.as_str())
    .bind(job_id.as_str())
    .bind(id.as_str())
    .bind(place)
    .execute(connection)
    .await?;
    Ok(())
}

/// Ends an item that never began.
pub(super) async fn end_early(
    connection: &mut AnyConnection,
    id: &BatchId,
    place: i64,
    error: OutputError,
    now_ms: i64,
) -> Result<(), StoreError> {
    let error = error.on_line(u64::try_from(place).unwrap_or(0));
    sqlx::query(
        "UPDATE batch_items SET state = $1, error = $2, settled_at = $3 WHERE batch_id = $4 AND place = $5",
    )
    .bind(RequestState::Failed.as_str())
    .bind(error_text(&error))
    .bind(now_ms)
    .bind(id.as_str())
    .bind(place)
    .execute(connection)
    .await?;
    Ok(())
}
