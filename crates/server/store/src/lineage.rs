//! The scenes that a scene was made from.

use sqlx::AssertSqlSafe;

use super::scenes::{SceneRow, scene_of};
use super::{Store, StoreError};
use crate::boxed;
use scene::{SceneId, TenantId};

impl Store {
    /// The scenes that a scene was made from, directly or through others, oldest first; deleted scenes too. Of a longer
    /// chain the nearest `limit`.
    ///
    /// # Errors
    ///
    /// A [`StoreError`] if the database does not answer, or a row cannot be read.
    #[boxed]
    pub async fn ancestors(
        &self,
        tenant_id: &TenantId,
        id: &SceneId,
        limit: u32,
    ) -> Result<Vec<SceneRow>, StoreError> {
        // Ids grow with time, and a parent is older than its children: no chain leads back to where it came from.
        let join = self.readers.dialect().join_to_first();
        let query = format!(
            "WITH RECURSIVE chain (id, depth) AS (
                 SELECT parent_id, 1 FROM scenes WHERE id = $1 AND tenant_id = $2
                 UNION ALL
                 SELECT scenes.parent_id, chain.depth + 1 FROM chain {join} scenes ON scenes.id = chain.id
                 WHERE scenes.tenant_id = $3 AND chain.depth < $4
             )
             SELECT scenes.* FROM chain {join} scenes ON scenes.id = chain.id
             WHERE scenes.tenant_id = $5 ORDER BY chain.depth DESC"
        );
        let rows = sqlx::query(AssertSqlSafe(query))
            .bind(id.as_str())
            .bind(tenant_id.as_str())
            .bind(tenant_id.as_str())
            .bind(i64::from(limit))
            .bind(tenant_id.as_str())
            .fetch_all(&self.readers)
            .await?;
        rows.iter().map(scene_of).collect()
    }
}
