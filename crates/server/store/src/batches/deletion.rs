//! Deletion of a batch, on demand with its scenes.
//!
//! One that has not ended is cancelled first; feeders bring it to its end, and then a sweep removes its items. Scenes
//! are deleted a few at a time, so that no other writer waits for a hundred thousand of them. A process that dies in
//! between leaves the mark on the batch, and the next sweep goes on.

use sqlx::{AnyConnection, Row};

use super::{control, locked};
use crate::boxed;
use crate::deletion::DeleteOutcome;
use crate::{Store, StoreError, database, scenes};
use scene::{BatchId, SceneId, TenantId};

/// Scenes that one transaction deletes.
const PAGE_SCENES: i64 = 100;

/// Fate of the scenes of a batch that is deleted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BatchScenes {
    Keep,
    Delete,
}

impl Store {
    /// Marks a batch as deleted, cancels it if it has not ended, and deletes its scenes if that is wanted.
    #[boxed]
    pub async fn delete_batch(
        &self,
        tenant_id: &TenantId,
        id: &BatchId,
        scenes: BatchScenes,
    ) -> Result<DeleteOutcome, StoreError> {
        let (tenant_id, batch) = (tenant_id.clone(), id.clone());
        let deleted = self
            .writer
            .unhurried()
            .write("delete a batch", move |connection| {
                Box::pin(async move { delete(connection, &tenant_id, &batch, scenes).await })
            })
            .await?;
        self.announce_cancellation();
        if deleted == DeleteOutcome::Done && scenes == BatchScenes::Delete {
            self.delete_scenes_of_batch(id).await?;
        }
        Ok(deleted)
    }

    /// Deletes the scenes of a batch, page by page.
    pub(crate) async fn delete_scenes_of_batch(&self, id: &BatchId) -> Result<(), StoreError> {
        let (writer, mut last_place) = (self.writer.unhurried(), Some(0));
        while let Some(after_place) = last_place {
            let id = id.clone();
            let page = writer.write("delete scenes of a batch", move |connection| {
                Box::pin(async move { delete_page(connection, &id, after_place).await })
            });
            last_place = page.await?;
            self.announce_cancellation();
        }
        Ok(())
    }
}

async fn delete(
    connection: &mut AnyConnection,
    tenant_id: &TenantId,
    id: &BatchId,
    scenes: BatchScenes,
) -> Result<DeleteOutcome, StoreError> {
    let Some(batch) = locked(connection, id).await?.filter(|batch| batch.tenant_id == *tenant_id) else {
        return Ok(DeleteOutcome::NotFound);
    };
    let now = database::now_ms(connection).await?;
    if !batch.state.is_final() {
        control::cancel_items(connection, &batch, now).await?;
    }
    sqlx::query(
        "UPDATE batches SET deleted_at = COALESCE(deleted_at, $1),
                            deletes_scenes = CASE WHEN $2 = 1 THEN 1 ELSE deletes_scenes END
         WHERE id = $3",
    )
    .bind(now)
    .bind(i64::from(scenes == BatchScenes::Delete))
    .bind(id.as_str())
    .execute(connection)
    .await?;
    Ok(DeleteOutcome::Done)
}

/// Deletes scenes of the first items after a place; the place of the last one, or `None` if there was none.
async fn delete_page(
    connection: &mut AnyConnection,
    id: &BatchId,
    after_place: i64,
) -> Result<Option<i64>, StoreError> {
    let rows = sqlx::query(
        "SELECT items.place AS place, items.scene_id AS scene_id, batches.tenant_id AS tenant_id
         FROM batch_items AS items JOIN batches ON batches.id = items.batch_id
         WHERE items.batch_id = $1 AND items.place > $2 AND items.scene_id IS NOT NULL
         ORDER BY items.place LIMIT $3",
    )
    .bind(id.as_str())
    .bind(after_place)
    .bind(PAGE_SCENES)
    .fetch_all(&mut *connection)
    .await?;
    let Some(last) = rows.last() else { return Ok(None) };
    let last_place = last.try_get("place")?;
    for row in &rows {
        let scene_id: SceneId = database::id(row, "batch_items", "scene_id")?;
        // One that was deleted before stays deleted; its time counts from then.
        scenes::delete(connection, database::id(row, "batches", "tenant_id")?, scene_id).await?;
    }
    Ok(Some(last_place))
}
