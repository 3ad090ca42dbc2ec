//! Recipes of batches: requests that have no rows yet get them a group at a time, when few items wait, so that a short
//! recipe of many requests makes as many rows as are soon fed.
//!
//! The store knows the text of a recipe and the number of the first request without a row; the caller makes the
//! requests. Processes may expand the same recipe at once: a group counts only from the number where the rest begins.

use sqlx::{AnyConnection, Row};

use super::receive::insert;
use super::{ItemContent, NewItem, locked};
use crate::boxed;
use crate::{Store, StoreError};
use ::batches::BatchState;
use scene::BatchId;

/// Requests of a batch that have no rows yet.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RecipeRest {
    /// The recipe as it was submitted, JSON.
    pub recipe: String,
    /// Number of the first request without a row, from 1.
    pub first_place: u64,
    pub counts: RestCounts,
}

/// Requests without rows, by what becomes of them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RestCounts {
    /// Requests that are to be computed.
    pub pending: u64,
    pub duplicate: u64,
    pub invalid: u64,
}

impl RestCounts {
    /// Counts a further request.
    pub fn add(&mut self, content: &ItemContent) {
        *self.of(content) += 1;
    }

    fn take(&mut self, content: &ItemContent) {
        let count = self.of(content);
        *count = count.saturating_sub(1);
    }

    fn of(&mut self, content: &ItemContent) -> &mut u64 {
        match content {
            ItemContent::Request { .. } => &mut self.pending,
            ItemContent::Duplicate { .. } => &mut self.duplicate,
            ItemContent::Invalid(_) => &mut self.invalid,
        }
    }
}

impl Store {
    /// Keeps the rest of the recipe of a batch that is being received.
    #[boxed]
    pub async fn keep_recipe(&self, id: &BatchId, rest: RecipeRest) -> Result<(), StoreError> {
        let id = id.clone();
        self.writer
            .write("store the recipe of a batch", move |connection| {
                Box::pin(async move {
                    sqlx::query(
                        "INSERT INTO batch_recipes (batch_id, recipe, first_place, pending, duplicate, invalid)
                         VALUES ($1, $2, $3, $4, $5, $6)",
                    )
                    .bind(id.as_str())
                    .bind(rest.recipe)
                    .bind(number(rest.first_place))
                    .bind(number(rest.counts.pending))
                    .bind(number(rest.counts.duplicate))
                    .bind(number(rest.counts.invalid))
                    .execute(connection)
                    .await?;
                    Ok(())
                })
            })
            .await
    }

    /// The rest of a running batch of which fewer than `window` items wait.
    #[boxed]
    pub async fn recipe_to_expand(
        &self,
        id: &BatchId,
        window: i64,
    ) -> Result<Option<RecipeRest>, StoreError> {
        let row = sqlx::query(
            "SELECT recipe, first_place, pending, duplicate, invalid FROM batch_recipes
             WHERE batch_id = $1 AND is_stopped = 0 AND (SELECT state FROM batches WHERE id = $1) = 'running'
               AND (SELECT COUNT(*) FROM (SELECT 1 FROM batch_items
                                          WHERE batch_id = $1 AND state = 'pending' LIMIT $2) AS waiting) < $2",
        )
        .bind(id.as_str())
        .bind(window)
        .fetch_optional(&self.readers)
        .await?;
        let Some(row) = row else { return Ok(None) };
        let count = |column: &str| -> Result<u64, StoreError> {
            Ok(u64::try_from(row.try_get::<i64, _>(column)?).unwrap_or(0))
        };
        Ok(Some(RecipeRest {
            recipe: row.try_get("recipe")?,
            first_place: count("first_place")?,
            counts: RestCounts {
                pending: count("pending")?,
                duplicate: count("duplicate")?,
                invalid: count("invalid")?,
            },
        }))
    }

    /// Gives the next requests of a rest their rows, or nothing where another process was faster. With `is_last` no
    /// more follow.
    #[boxed]
    pub async fn expand_recipe(
        &self,
        id: &BatchId,
        rest: RecipeRest,
        items: Vec<NewItem>,
        is_last: bool,
    ) -> Result<bool, StoreError> {
        let id = id.clone();
        self.writer
            .write("expand the recipe of a batch", move |connection| {
                Box::pin(async move { expand(connection, &id, rest, items, is_last).await })
            })
            .await
    }
}

async fn expand(
    connection: &mut AnyConnection,
    id: &BatchId,
    rest: RecipeRest,
    items: Vec<NewItem>,
    is_last: bool,
) -> Result<bool, StoreError> {
    let is_running = locked(connection, id).await?.is_some_and(|batch| batch.state == BatchState::Running);
    let begins_at: Option<i64> =
        sqlx::query_scalar("SELECT first_place FROM batch_recipes WHERE batch_id = $1 AND is_stopped = 0")
            .bind(id.as_str())
            .fetch_optional(&mut *connection)
            .await?;
    if !is_running || begins_at != Some(number(rest.first_place)) {
        return Ok(false);
    }
    let mut counts = rest.counts;
    for group in items.chunks(super::receive::ITEMS_PER_STATEMENT) {
        insert(connection, id, group).await?;
        group.iter().for_each(|item| counts.take(&item.content));
    }
    let next_place = items.last().map_or(rest.first_place, |item| item.place + 1);
    let query = match is_last {
        true => sqlx::query("DELETE FROM batch_recipes WHERE batch_id = $1").bind(id.as_str()),
        false => sqlx::query(
            "UPDATE batch_recipes SET first_place = $1, pending = $2, duplicate = $3, invalid = $4 WHERE batch_id = $5",
        )
        .bind(number(next_place))
        .bind(number(counts.pending))
        .bind(number(counts.duplicate))
        .bind(number(counts.invalid))
        .bind(id.as_str()),
    };
    query.execute(connection).await?;
    Ok(true)
}

/// Stops the expansion: the rest is cancelled, and keeps no rows.
pub(super) async fn stop(connection: &mut AnyConnection, id: &BatchId) -> Result<(), StoreError> {
    sqlx::query("UPDATE batch_recipes SET is_stopped = 1 WHERE batch_id = $1")
        .bind(id.as_str())
        .execute(connection)
        .await?;
    Ok(())
}

/// Lets a rest that was cancelled wait again. Returns the number of requests that are to be computed.
pub(super) async fn go_on(connection: &mut AnyConnection, id: &BatchId) -> Result<u64, StoreError> {
    let pending: Option<i64> = sqlx::query_scalar(
        "UPDATE batch_recipes SET is_stopped = 0 WHERE batch_id = $1 AND is_stopped = 1 RETURNING pending",
    )
    .bind(id.as_str())
    .fetch_optional(connection)
    .await?;
    Ok(pending.and_then(|pending| u64::try_from(pending).ok()).unwrap_or(0))
}

/// Whether requests of a batch are still to get their rows.
pub(super) async fn is_expanding(connection: &mut AnyConnection, id: &BatchId) -> Result<bool, StoreError> {
    let found: Option<i64> = sqlx::query_scalar(
        "SELECT CAST(1 AS BIGINT) FROM batch_recipes WHERE batch_id = $1 AND is_stopped = 0",
    )
    .bind(id.as_str())
    .fetch_optional(connection)
    .await?;
    Ok(found.is_some())
}

/// A count as the database has it.
fn number(count: u64) -> i64 {
    i64::try_from(count).unwrap_or(i64::MAX)
}
