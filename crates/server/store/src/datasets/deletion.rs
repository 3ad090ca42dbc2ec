//! Deletion of a dataset: of one freeze with its version. Other versions of the name keep their files, as each has rows
//! of its own.

use sqlx::AnyConnection;

use crate::boxed;
use crate::deletion::DeleteOutcome;
use crate::queue::cancel_jobs_of;
use crate::{Store, StoreError, database};
use scene::{DatasetId, TenantId};

impl Store {
    /// Marks a dataset as deleted and cancels its active job.
    #[boxed]
    pub async fn delete_dataset(
        &self,
        tenant_id: &TenantId,
        id: &DatasetId,
    ) -> Result<DeleteOutcome, StoreError> {
        let (tenant_id, id) = (tenant_id.clone(), id.clone());
        let deleted = self
            .writer
            .write("delete a dataset", move |connection| {
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
    id: &DatasetId,
) -> Result<DeleteOutcome, StoreError> {
    let now = database::now_ms(connection).await?;
    let marked = sqlx::query(
        "UPDATE datasets SET deleted_at = COALESCE(deleted_at, $1) WHERE id = $2 AND tenant_id = $3",
    )
    .bind(now)
    .bind(id.as_str())
    .bind(tenant_id.as_str())
    .execute(&mut *connection)
    .await?;
    if marked.rows_affected() == 0 {
        return Ok(DeleteOutcome::NotFound);
    }
    cancel_jobs_of(connection, "dataset_id", id.as_str(), now).await?;
    Ok(DeleteOutcome::Done)
}
