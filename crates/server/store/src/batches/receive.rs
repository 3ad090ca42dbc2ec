//! Storing a new batch: its row, its items in groups, and the moment from which it exists.
//!
//! Each group is a transaction of its own, so that other writers wait for none of a hundred thousand items. A process
//! that dies in between leaves a batch that no query finds; a later sweep removes it.

use std::collections::BTreeMap;

use ::batches::OutputError;
use serde_json::{Value, json};
use sqlx::{AnyConnection, AssertSqlSafe, Row};
use uuid::Uuid;

use super::{admission, error_text};
use crate::boxed;
use crate::limits::{LimitReached, LimitSettings};
use crate::{Digest, Store, StoreError, database};
use scene::{BatchId, MicroUsd, TenantId};

/// Items of one statement: each has nine parameters, and SQLite takes 32,766.
pub(super) const ITEMS_PER_STATEMENT: usize = 200;
/// Items of a refused batch that are removed in one transaction.
const DISCARDED_TOGETHER: i64 = 200;
/// A batch that is not complete after this long is of a process that died.
const MAX_RECEIVING_MS: i64 = 6 * 3600 * 1000;

/// A batch to be received.
#[derive(Clone, Debug)]
pub struct NewBatch {
    pub tenant_id: TenantId,
    pub name: String,
    /// The most that all requests may cost together; `None` leaves each its own budget.
    pub budget: Option<MicroUsd>,
    pub idempotency_key: Option<String>,
    /// Of everything that was asked for.
    pub body_digest: Digest,
}

/// An item of a new batch.
#[derive(Clone, Debug)]
pub struct NewItem {
    /// Line of the body, or number of the request of a recipe, from 1.
    pub place: u64,
    pub custom_id: Option<String>,
    pub content: ItemContent,
}

/// Request of an item, or the reason why it is not computed.
#[derive(Clone, Debug)]
pub enum ItemContent {
    Request {
        /// The versioned request, as JSON.
        request: Value,
        labels: BTreeMap<String, String>,
        /// The most that it asks to spend.
        budget: MicroUsd,
    },
    /// An earlier item, with the name `of`, asks for the same scene.
    Duplicate {
        of: String,
        error: OutputError,
    },
    Invalid(OutputError),
}

/// Result of the end of a reception.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum PublishOutcome {
    Published,
    /// The key was used before with the same body, for this batch; the new one is gone.
    Replayed(BatchId),
    /// The key was used before with another body; the new batch is gone.
    KeyReused,
    /// A limit of the tenant leaves no room; the new batch is gone.
    Refused(LimitReached),
}

impl Store {
    /// The batch that a tenant made with an idempotency key, and the digest of what was asked for.
    #[boxed]
    pub async fn batch_by_key(
        &self,
        tenant_id: &TenantId,
        key: &str,
    ) -> Result<Option<(BatchId, String)>, StoreError> {
        let read = async { by_key(&mut *self.readers.acquire().await?, tenant_id, key).await };
        self.readers.within_limit(read).await
    }

    /// Begins to receive a batch, which no query finds yet.
    #[boxed]
    pub async fn begin_batch(&self, new: NewBatch) -> Result<BatchId, StoreError> {
        self.writer
            .write("begin a batch", move |connection| {
                Box::pin(async move {
                    let now = database::now_ms(connection).await?;
                    let id: BatchId = database::parse_id(&Uuid::now_v7().to_string(), "batches")?;
                    sqlx::query(
                        "INSERT INTO batches (id, tenant_id, name, state, budget_micro_usd, idempotency_key, body_digest,
                                              created_at, started_at)
                         VALUES ($1, $2, $3, 'receiving', $4, $5, $6, $7, $8)",
                    )
                    .bind(id.as_str())
                    .bind(new.tenant_id.as_str())
                    .bind(new.name)
                    .bind(new.budget.map(|budget| budget.0))
                    .bind(new.idempotency_key)
                    .bind(new.body_digest.as_str())
                    .bind(now)
                    .bind(now)
                    .execute(connection)
                    .await?;
                    Ok(id)
                })
            })
            .await
    }

    /// Stores a group of items of a batch that is being received.
    #[boxed]
    pub async fn append_items(&self, id: &BatchId, items: Vec<NewItem>) -> Result<(), StoreError> {
        let id = id.clone();
        self.writer
            .write("store items of a batch", move |connection| {
                Box::pin(async move {
                    for group in items.chunks(ITEMS_PER_STATEMENT) {
                        insert(connection, &id, group).await?;
                    }
                    Ok(())
                })
            })
            .await
    }

    /// Ends the reception: from now on the batch exists and its items are fed, unless its key was used before or the
    /// limits of its tenant leave no room.
    #[boxed]
    pub async fn publish_batch(&self, id: &BatchId) -> Result<PublishOutcome, StoreError> {
        let (received, limits) = (id.clone(), *self.admission.settings());
        let published = self
            .writer
            .unhurried()
            .write("publish a batch", move |connection| {
                Box::pin(async move { publish(connection, &received, &limits).await })
            })
            .await?;
        match published {
            PublishOutcome::Published => self.announce(),
            _ => self.discard_batch(id).await?,
        }
        Ok(published)
    }

    /// Removes a batch that is being received, a group of items at a time.
    #[boxed]
    pub async fn discard_batch(&self, id: &BatchId) -> Result<(), StoreError> {
        loop {
            let id = id.clone();
            let is_gone = self
                .writer
                .write("discard a batch", move |connection| {
                    Box::pin(async move { discard(connection, &id).await })
                })
                .await?;
            if is_gone {
                return Ok(());
            }
        }
    }

    /// Removes batches whose reception was broken off; their number.
    pub(crate) async fn discard_abandoned_batches(&self) -> Result<u64, StoreError> {
        let now = self.readers.now_ms().await?;
        let ids: Vec<String> =
            sqlx::query_scalar("SELECT id FROM batches WHERE state = 'receiving' AND created_at <= $1")
                .bind(now - MAX_RECEIVING_MS)
                .fetch_all(&self.readers)
                .await?;
        for id in &ids {
            self.discard_batch(&database::parse_id(id, "batches")?).await?;
        }
        Ok(ids.len() as u64)
    }
}

async fn by_key(
    connection: &mut AnyConnection,
    tenant_id: &TenantId,
    key: &str,
) -> Result<Option<(BatchId, String)>, StoreError> {
    let row = sqlx::query(
        "SELECT id, body_digest FROM batches
         WHERE tenant_id = $1 AND idempotency_key = $2 AND state <> 'receiving'",
    )
    .bind(tenant_id.as_str())
    .bind(key)
    .fetch_optional(connection)
    .await?;
    row.map(|row| Ok((database::id(&row, "batches", "id")?, row.try_get("body_digest")?))).transpose()
}

/// Inserts a group of items.
pub(super) async fn insert(
    connection: &mut AnyConnection,
    id: &BatchId,
    items: &[NewItem],
) -> Result<(), StoreError> {
    const COLUMNS: usize = 9;
    let row = |k: usize| {
        let parameters: Vec<String> =
            (1..=COLUMNS).map(|column| format!("${}", k * COLUMNS + column)).collect();
        format!("({})", parameters.join(", "))
    };
    let rows: Vec<String> = (0..items.len()).map(row).collect();
    let statement = format!(
        "INSERT INTO batch_items
             (batch_id, place, custom_id, state, request, labels, budget_micro_usd, duplicate_of, error)
         VALUES {}",
        rows.join(", ")
    );
    let mut query = sqlx::query(AssertSqlSafe(statement));
    for NewItem { place, custom_id, content } in items {
        query = query
            .bind(id.as_str())
            .bind(i64::try_from(*place).unwrap_or(i64::MAX))
            .bind(custom_id.as_deref());
        query = match content {
            ItemContent::Request { request, labels, budget } => query
                .bind("pending")
                .bind(Some(request.to_string()))
                .bind(json!(labels).to_string())
                .bind(budget.0)
                .bind(None::<&str>)
                .bind(None::<String>),
            ItemContent::Duplicate { of, error } => query
                .bind("duplicate")
                .bind(None::<String>)
                .bind("{}".to_owned())
                .bind(0_i64)
                .bind(Some(of.as_str()))
                .bind(Some(error_text(error))),
            ItemContent::Invalid(error) => query
                .bind("invalid")
                .bind(None::<String>)
                .bind("{}".to_owned())
                .bind(0_i64)
                .bind(None::<&str>)
                .bind(Some(error_text(error))),
        };
    }
    query.execute(connection).await?;
    Ok(())
}

async fn publish(
    connection: &mut AnyConnection,
    id: &BatchId,
    limits: &LimitSettings,
) -> Result<PublishOutcome, StoreError> {
    let row = sqlx::query("SELECT tenant_id, idempotency_key, body_digest FROM batches WHERE id = $1")
        .bind(id.as_str())
        .fetch_one(&mut *connection)
        .await?;
    let tenant_id: TenantId = database::id(&row, "batches", "tenant_id")?;
    if let Some(key) = row.try_get::<Option<String>, _>("idempotency_key")?
        && let Some((earlier, body_digest)) = by_key(connection, &tenant_id, &key).await?
    {
        let is_same = body_digest == row.try_get::<String, _>("body_digest")?;
        return Ok(if is_same { PublishOutcome::Replayed(earlier) } else { PublishOutcome::KeyReused });
    }
    let now = database::now_ms(connection).await?;
    let requests = admission::pending(connection, id).await?;
    if let Some(reached) = admission::full(connection, &tenant_id, limits, requests, now).await? {
        return Ok(PublishOutcome::Refused(reached));
    }
    sqlx::query(
        "UPDATE batches SET state = 'running', started_at = $1 WHERE id = $2 AND state = 'receiving'",
    )
    .bind(now)
    .bind(id.as_str())
    .execute(connection)
    .await?;
    Ok(PublishOutcome::Published)
}

/// Removes some items of a batch that is being received, and the batch after its last. Whether it is gone.
async fn discard(connection: &mut AnyConnection, id: &BatchId) -> Result<bool, StoreError> {
    let removed = sqlx::query(
        "DELETE FROM batch_items
         WHERE batch_id = $1 AND place IN
             (SELECT place FROM batch_items
              WHERE batch_id = (SELECT id FROM batches WHERE id = $1 AND state = 'receiving') LIMIT $2)",
    )
    .bind(id.as_str())
    .bind(DISCARDED_TOGETHER)
    .execute(&mut *connection)
    .await?
    .rows_affected();
    if removed > 0 {
        return Ok(false);
    }
    sqlx::query("DELETE FROM batches WHERE id = $1 AND state = 'receiving'")
        .bind(id.as_str())
        .execute(&mut *connection)
        .await?;
    Ok(true)
}
