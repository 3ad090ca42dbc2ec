//! Items whose scene has come to its end get their final state, their error and their cost.

use ::batches::{OutputError, RequestState};
use sqlx::any::AnyRow;
use sqlx::{AnyConnection, Row};

use super::{corrupt_item, error_text};
use crate::StoreError;
use crate::lifecycle::{JobState, SceneState};
use scene::BatchId;

/// Final state of an item, as it is written.
struct Settlement {
    state: RequestState,
    error: Option<OutputError>,
}

/// Settles every submitted item whose scene is no longer pending; their number.
pub(super) async fn settle(
    connection: &mut AnyConnection,
    id: &BatchId,
    now_ms: i64,
) -> Result<u64, StoreError> {
    let rows = sqlx::query(
        "SELECT i.place AS place, i.spent_micro_usd AS settled, s.state AS scene_state,
                s.failure_code AS scene_code, s.failure_message AS scene_message,
                j.state AS job_state, j.failure_code AS job_code, j.failure_message AS job_message, j.epoch AS epoch,
                (SELECT CAST(COALESCE(SUM(settled_micro_usd), 0) AS BIGINT) FROM calls
                 WHERE calls.scene_id = i.scene_id) AS spent,
                (SELECT CAST(COALESCE(SUM(elapsed_ms), 0) AS BIGINT) FROM stages
                 WHERE stages.job_id = i.job_id AND stages.runs > 0) AS cpu_ms
         FROM batch_items AS i
         LEFT JOIN scenes AS s ON s.id = i.scene_id
         LEFT JOIN jobs AS j ON j.id = i.job_id
         WHERE i.batch_id = $1 AND i.state = 'submitted' AND (s.state IS NULL OR s.state <> 'pending')
         ORDER BY i.place",
    )
    .bind(id.as_str())
    .fetch_all(&mut *connection)
    .await?;
    let mut spent_more = 0_i64;
    for row in &rows {
        let place: i64 = row.try_get("place")?;
        let (settled, spent): (i64, i64) = (row.try_get("settled")?, row.try_get("spent")?);
        // Rows of a purged scene are gone, and what it spent with them.
        let spent = spent.max(settled);
        spent_more = spent_more.saturating_add(spent - settled);
        let Settlement { state, error } = settlement(row)?;
        let error = error.map(|error| error.on_line(u64::try_from(place).unwrap_or(0)));
        sqlx::query(
            "UPDATE batch_items SET state = $1, error = $2, spent_micro_usd = $3, cpu_ms = $4, attempts = $5,
                                    settled_at = $6
             WHERE batch_id = $7 AND place = $8",
        )
        .bind(state.as_str())
        .bind(error.as_ref().map(error_text))
        .bind(spent)
        .bind(row.try_get::<i64, _>("cpu_ms")?)
        .bind(row.try_get::<Option<i64>, _>("epoch")?.unwrap_or(0))
        .bind(now_ms)
        .bind(id.as_str())
        .bind(place)
        .execute(&mut *connection)
        .await?;
    }
    if spent_more > 0 {
        sqlx::query("UPDATE batches SET spent_micro_usd = spent_micro_usd + $1 WHERE id = $2")
            .bind(spent_more)
            .bind(id.as_str())
            .execute(connection)
            .await?;
    }
    Ok(rows.len() as u64)
}

/// Final state of an item, by the rows of its scene and its job.
fn settlement(row: &AnyRow) -> Result<Settlement, StoreError> {
    let text = |column: &str| row.try_get::<Option<String>, _>(column);
    let scene_state = text("scene_state")?;
    let scene_state = scene_state.as_deref().map(|word| {
        SceneState::parse(word).ok_or_else(|| corrupt_item(format!("its scene has the state {word}")))
    });
    let is_cancelled = text("job_state")?.as_deref() == Some(JobState::Cancelled.as_str());
    let scene_code = text("scene_code")?;
    Ok(match scene_state.transpose()? {
        Some(SceneState::Ready) => Settlement { state: RequestState::Succeeded, error: None },
        Some(SceneState::Failed) if scene_code.as_deref() == Some("quarantined") => {
            let message = text("scene_message")?;
            let message = message.unwrap_or_else(|| "the certificate says quarantine".to_owned());
            let error = OutputError::new("quarantined", message);
            Settlement { state: RequestState::Quarantined, error: Some(error) }
        }
        Some(SceneState::Failed | SceneState::Pending) => {
            let code = text("job_code")?.or(scene_code).unwrap_or_else(|| "failed".to_owned());
            let message = text("job_message")?.or(text("scene_message")?).unwrap_or_default();
            let state = if is_cancelled { RequestState::Cancelled } else { RequestState::Failed };
            Settlement { state, error: Some(OutputError::new(&code, message)) }
        }
        Some(SceneState::Deleted) | None => {
            let message = "the scene was deleted before it was finished; submit the request again";
            let error = OutputError::new("scene_deleted", message);
            Settlement { state: RequestState::Cancelled, error: Some(error) }
        }
    })
}
