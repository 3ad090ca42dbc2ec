//! Labels of a scene that is there already. A trigger of the database has them found by their new values.

use std::collections::BTreeMap;

use serde_json::json;
use sqlx::{AnyConnection, AssertSqlSafe};

use super::{SceneRow, scene_of};
use crate::boxed;
use crate::database::Dialect;
use crate::{Store, StoreError, database};
use scene::TenantId;

/// Result of a change of labels.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum LabelsOutcome {
    /// The scene with its new labels.
    Replaced(Box<SceneRow>),
    /// The scene is no longer as the caller has read it; nothing was changed.
    Differs,
}

impl Store {
    /// Gives a scene of the tenant other labels, if it is still as the caller has read it.
    #[boxed]
    pub async fn replace_labels(
        &self,
        tenant_id: &TenantId,
        read: SceneRow,
        labels: BTreeMap<String, String>,
    ) -> Result<LabelsOutcome, StoreError> {
        let tenant_id = tenant_id.clone();
        self.writer
            .write("change the labels of a scene", move |connection| {
                Box::pin(async move { replace(connection, &tenant_id, read, labels).await })
            })
            .await
    }
}

async fn replace(
    connection: &mut AnyConnection,
    tenant_id: &TenantId,
    read: SceneRow,
    labels: BTreeMap<String, String>,
) -> Result<LabelsOutcome, StoreError> {
    let lock = Dialect::of(connection).lock();
    let query = format!("SELECT * FROM scenes WHERE id = $1 AND tenant_id = $2 {lock}");
    let present = sqlx::query(AssertSqlSafe(query))
        .bind(read.id.as_str())
        .bind(tenant_id.as_str())
        .fetch_optional(&mut *connection)
        .await?;
    if present.as_ref().map(scene_of).transpose()?.as_ref() != Some(&read) {
        return Ok(LabelsOutcome::Differs);
    }
    let now = database::now_ms(connection).await?;
    sqlx::query("UPDATE scenes SET labels = $1, updated_at = $2 WHERE id = $3")
        .bind(json!(labels).to_string())
        .bind(now)
        .bind(read.id.as_str())
        .execute(connection)
        .await?;
    Ok(LabelsOutcome::Replaced(Box::new(SceneRow { labels, updated_at_ms: now, ..read })))
}
