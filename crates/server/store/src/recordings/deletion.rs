//! Deletion of a recording. One that has not ended is cancelled first, which drops its jobs, attempts and files.

use sqlx::{AnyConnection, AssertSqlSafe};

use super::{RecordingState, corrupt, ending};
use crate::boxed;
use crate::database::Dialect;
use crate::deletion::DeleteOutcome;
use crate::{Store, StoreError, database};
use scene::{RecordingId, TenantId};

impl Store {
    /// Marks a recording as deleted, and cancels it if it has not ended.
    #[boxed]
    pub async fn delete_recording(
        &self,
        tenant_id: &TenantId,
        id: &RecordingId,
    ) -> Result<DeleteOutcome, StoreError> {
        let (tenant_id, id) = (tenant_id.clone(), id.clone());
        let deleted = self
            .writer
            .write("delete a recording", move |connection| {
                Box::pin(async move { delete(connection, &tenant_id, &id).await })
            })
            .await?;
        self.announce_cancellation();
        Ok(deleted)
    }
}

async fn delete(
    connection: &mut AnyConnection,
    tenant_id: &TenantId,
    id: &RecordingId,
) -> Result<DeleteOutcome, StoreError> {
    let lock = Dialect::of(connection).lock();
    let query = format!("SELECT state FROM recordings WHERE id = $1 AND tenant_id = $2 {lock}");
    let state: Option<String> = sqlx::query_scalar(AssertSqlSafe(query))
        .bind(id.as_str())
        .bind(tenant_id.as_str())
        .fetch_optional(&mut *connection)
        .await?;
    let Some(state) = state else { return Ok(DeleteOutcome::NotFound) };
    let state = RecordingState::parse(&state).ok_or_else(|| corrupt(format!("state {state}")))?;
    let now = database::now_ms(connection).await?;
    if !state.is_final() {
        ending::cancel(connection, id, None, now).await?;
    }
    sqlx::query("UPDATE recordings SET deleted_at = COALESCE(deleted_at, $1) WHERE id = $2")
        .bind(now)
        .bind(id.as_str())
        .execute(connection)
        .await?;
    Ok(DeleteOutcome::Done)
}
