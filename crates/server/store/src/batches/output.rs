//! Results of a batch, in the order of its requests.

use ::batches::{OutputError, OutputLine, RequestState};
use sqlx::any::AnyRow;
use sqlx::{AssertSqlSafe, Row};

use super::corrupt_item;
use crate::boxed;
use crate::{Store, StoreError};
use scene::BatchId;

/// Kind of results.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OutputKind {
    /// Of requests with a scene, their own or that of the request which they duplicate.
    Output,
    /// Of requests without one.
    Errors,
}

/// A request that has come to its end.
#[derive(Clone, Debug, PartialEq)]
pub struct ItemRow {
    /// Line of the body, or number of the request of a recipe, from 1.
    pub place: u64,
    /// The result; `bundle` is `None`, because the store knows no addresses.
    pub line: OutputLine,
}

impl Store {
    /// Results of the requests after `after_place`, at most `limit` of them. The caller checks the tenant.
    #[boxed]
    pub async fn batch_output(
        &self,
        id: &BatchId,
        kind: OutputKind,
        after_place: u64,
        limit: u32,
    ) -> Result<Vec<ItemRow>, StoreError> {
        let states = match kind {
            OutputKind::Output => "'succeeded', 'quarantined', 'duplicate'",
            OutputKind::Errors => "'failed', 'cancelled', 'invalid'",
        };
        let query = format!(
            "SELECT place, custom_id, state, scene_id, duplicate_of, error, cpu_ms, attempts FROM batch_items
             WHERE batch_id = $1 AND state IN ({states}) AND place > $2 ORDER BY place LIMIT $3"
        );
        let rows = sqlx::query(AssertSqlSafe(query))
            .bind(id.as_str())
            .bind(i64::try_from(after_place).unwrap_or(i64::MAX))
            .bind(i64::from(limit))
            .fetch_all(&self.readers)
            .await?;
        rows.iter().map(item).collect()
    }
}

fn item(row: &AnyRow) -> Result<ItemRow, StoreError> {
    let number = |column: &str| -> Result<u64, StoreError> {
        Ok(u64::try_from(row.try_get::<i64, _>(column)?).unwrap_or(0))
    };
    let state: String = row.try_get("state")?;
    let state = RequestState::parse(&state).ok_or_else(|| corrupt_item(format!("state {state}")))?;
    let error: Option<String> = row.try_get("error")?;
    let error: Option<OutputError> = error
        .map(|text| serde_json::from_str(&text))
        .transpose()
        .map_err(|error| corrupt_item(format!("error: {error}")))?;
    let verdict = match state {
        RequestState::Succeeded => Some("pass".to_owned()),
        RequestState::Quarantined => Some("quarantine".to_owned()),
        _ => None,
    };
    let line = OutputLine {
        custom_id: row.try_get("custom_id")?,
        scene_id: row.try_get("scene_id")?,
        state,
        verdict,
        bundle: None,
        error,
        stages_s: number("cpu_ms")? as f64 / 1000.0,
        attempts: number("attempts")?,
        duplicate_of: row.try_get("duplicate_of")?,
    };
    Ok(ItemRow { place: number("place")?, line })
}
