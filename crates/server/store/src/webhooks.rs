//! Webhooks: addresses of a tenant that events of its work are sent to, by the specification Standard Webhooks.
//!
//! What a change tells is written in the transaction of the change ([`outbox`]), so that no event is lost and none is
//! sent of what was rolled back. Any process takes what is due ([`claim`]) and writes how an attempt ended. A webhook
//! has one message under way at most, so that an address that does not answer holds up its own messages alone.
//!
//! The secret is kept as it is, because it signs. No list and no event holds it.

mod event;
mod outbox;
mod delivery;
mod claim;

use sqlx::any::AnyRow;
use sqlx::{AnyConnection, AssertSqlSafe, Row};
use uuid::Uuid;

use super::database::Dialect;
use super::deletion::DeleteOutcome;
use super::secret::Secret;
use super::{Store, StoreError, database, limits};
use crate::boxed;
use scene::{TenantId, WebhookId};

pub use claim::{AttemptEnd, AttemptReport, DueDelivery};
pub use delivery::{DeliveryFilter, DeliveryRow, DeliveryState, OrderOutcome};
pub use event::{EventType, Message, MessageData};
pub(super) use outbox::{batch_ended, job_ended, recording_ended};

/// Webhooks of a tenant.
pub const MAX_WEBHOOKS: usize = 20;
/// Time that the previous secret signs along after a new one was made.
const PREVIOUS_SECRET_MS: i64 = 86_400_000;
/// Reason why a webhook that its owner has disabled is so.
const DISABLED_BY_OWNER: &str = "it was disabled by a request";

/// A webhook to be made.
#[derive(Clone, Debug)]
pub struct NewWebhook {
    pub tenant_id: TenantId,
    pub url: String,
    /// For people.
    pub description: String,
    /// Empty = all.
    pub events: Vec<EventType>,
}

/// A webhook's row, without its secret.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct WebhookRow {
    pub id: WebhookId,
    pub url: String,
    pub description: String,
    /// Empty = all.
    pub events: Vec<EventType>,
    /// `None` = enabled.
    pub disabled_reason: Option<String>,
    /// Milliseconds since 1970, as all times here.
    pub created_at_ms: i64,
    pub updated_at_ms: i64,
}

/// Result of the making of a webhook.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum CreateOutcome {
    Created(WebhookRow),
    /// The tenant has [`MAX_WEBHOOKS`].
    TooMany,
}

/// Result of a change.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ChangeOutcome {
    Changed(WebhookRow),
    /// The webhook is no longer as the caller has read it; nothing was changed.
    Differs,
}

impl Store {
    /// Makes a webhook. Its secret is returned here alone.
    #[boxed]
    pub async fn create_webhook(&self, new: NewWebhook) -> Result<(CreateOutcome, Secret), StoreError> {
        let secret = Secret::new_webhook()?;
        let signing = secret.clone();
        let insert = self.writer.write("make a webhook", move |connection| {
            Box::pin(async move { insert(connection, new, &signing).await })
        });
        Ok((insert.await?, secret))
    }

    /// Webhooks of a tenant, newest first.
    #[boxed]
    pub async fn webhooks(&self, tenant_id: &TenantId) -> Result<Vec<WebhookRow>, StoreError> {
        let rows = sqlx::query("SELECT * FROM webhooks WHERE tenant_id = $1 ORDER BY id DESC LIMIT $2")
            .bind(tenant_id.as_str())
            .bind(MAX_WEBHOOKS as i64)
            .fetch_all(&self.readers)
            .await?;
        rows.iter().map(webhook_of).collect()
    }

    /// A webhook of the tenant.
    #[boxed]
    pub async fn webhook(
        &self,
        tenant_id: &TenantId,
        id: &WebhookId,
    ) -> Result<Option<WebhookRow>, StoreError> {
        let row = sqlx::query("SELECT * FROM webhooks WHERE id = $1 AND tenant_id = $2")
            .bind(id.as_str())
            .bind(tenant_id.as_str())
            .fetch_optional(&self.readers)
            .await?;
        row.as_ref().map(webhook_of).transpose()
    }

    /// Changes a webhook to `new`, if it is still as the caller has read it. One that is enabled again sends what
    /// waits.
    #[boxed]
    pub async fn change_webhook(
        &self,
        tenant_id: &TenantId,
        read: WebhookRow,
        new: NewWebhook,
        is_enabled: bool,
    ) -> Result<ChangeOutcome, StoreError> {
        let tenant_id = tenant_id.clone();
        let changed = self
            .writer
            .write("change a webhook", move |connection| {
                Box::pin(async move { change(connection, &tenant_id, read, new, is_enabled).await })
            })
            .await?;
        self.announce();
        Ok(changed)
    }

    /// Gives a webhook a new secret, which is returned here alone. The previous one signs along for a day.
    #[boxed]
    pub async fn renew_webhook_secret(
        &self,
        tenant_id: &TenantId,
        id: &WebhookId,
    ) -> Result<Option<(WebhookRow, Secret)>, StoreError> {
        let secret = Secret::new_webhook()?;
        let (tenant_id, id, signing) = (tenant_id.clone(), id.clone(), secret.clone());
        let renewed = self.writer.write("renew the secret of a webhook", move |connection| {
            Box::pin(async move {
                let now = database::now_ms(connection).await?;
                let row = sqlx::query(
                    "UPDATE webhooks SET previous_secret = secret, previous_secret_until = $1, secret = $2,
                                         updated_at = $3
                     WHERE id = $4 AND tenant_id = $5 RETURNING *",
                )
                .bind(now + PREVIOUS_SECRET_MS)
                .bind(signing.expose())
                .bind(now)
                .bind(id.as_str())
                .bind(tenant_id.as_str())
                .fetch_optional(connection)
                .await?;
                row.as_ref().map(webhook_of).transpose()
            })
        });
        Ok(renewed.await?.map(|row| (row, secret)))
    }

    /// Deletes a webhook with its secrets. A sweep removes its deliveries, and none of them is sent any more.
    #[boxed]
    pub async fn delete_webhook(
        &self,
        tenant_id: &TenantId,
        id: &WebhookId,
    ) -> Result<DeleteOutcome, StoreError> {
        let (tenant_id, id) = (tenant_id.clone(), id.clone());
        self.writer
            .write("delete a webhook", move |connection| {
                Box::pin(async move {
                    let deleted = sqlx::query("DELETE FROM webhooks WHERE id = $1 AND tenant_id = $2")
                        .bind(id.as_str())
                        .bind(tenant_id.as_str())
                        .execute(connection)
                        .await?;
                    Ok(match deleted.rows_affected() {
                        0 => DeleteOutcome::NotFound,
                        _ => DeleteOutcome::Done,
                    })
                })
            })
            .await
    }
}

async fn insert(
    connection: &mut AnyConnection,
    new: NewWebhook,
    secret: &Secret,
) -> Result<CreateOutcome, StoreError> {
    limits::one_at_a_time(connection, &format!("webhooks of {}", new.tenant_id)).await?;
    let count: i64 = sqlx::query_scalar(
        "SELECT COUNT(*) FROM (SELECT 1 FROM webhooks WHERE tenant_id = $1 LIMIT $2) AS those",
    )
    .bind(new.tenant_id.as_str())
    .bind(MAX_WEBHOOKS as i64)
    .fetch_one(&mut *connection)
    .await?;
    if count >= MAX_WEBHOOKS as i64 {
        return Ok(CreateOutcome::TooMany);
    }
    let now = database::now_ms(connection).await?;
    let id: WebhookId = database::parse_id(&Uuid::now_v7().to_string(), "webhooks")?;
    let row = sqlx::query(
        "INSERT INTO webhooks (id, tenant_id, url, description, events, secret, created_at, updated_at)
         VALUES ($1, $2, $3, $4, $5, $6, $7, $7) RETURNING *",
    )
    .bind(id.as_str())
    .bind(new.tenant_id.as_str())
    .bind(&new.url)
    .bind(&new.description)
    .bind(event::words(&new.events))
    .bind(secret.expose())
    .bind(now)
    .fetch_one(connection)
    .await?;
    webhook_of(&row).map(CreateOutcome::Created)
}

async fn change(
    connection: &mut AnyConnection,
    tenant_id: &TenantId,
    read: WebhookRow,
    new: NewWebhook,
    is_enabled: bool,
) -> Result<ChangeOutcome, StoreError> {
    let present = locked(connection, tenant_id, &read.id).await?;
    if present.as_ref() != Some(&read) {
        return Ok(ChangeOutcome::Differs);
    }
    let reason = match is_enabled {
        true => None,
        false => Some(read.disabled_reason.as_deref().unwrap_or(DISABLED_BY_OWNER)),
    };
    let was_enabled = read.disabled_reason.is_none();
    let now = database::now_ms(connection).await?;
    let row = sqlx::query(
        "UPDATE webhooks SET url = $1, description = $2, events = $3, disabled_reason = $4, updated_at = $5,
                             failed_in_a_row = CASE WHEN $6 = 1 THEN 0 ELSE failed_in_a_row END
         WHERE id = $7 RETURNING *",
    )
    .bind(&new.url)
    .bind(&new.description)
    .bind(event::words(&new.events))
    .bind(reason)
    .bind(now)
    .bind(i64::from(is_enabled && !was_enabled))
    .bind(read.id.as_str())
    .fetch_one(connection)
    .await?;
    webhook_of(&row).map(ChangeOutcome::Changed)
}

/// Locks a webhook of the tenant. A transaction that changes deliveries of a webhook locks it before them.
async fn locked(
    connection: &mut AnyConnection,
    tenant_id: &TenantId,
    id: &WebhookId,
) -> Result<Option<WebhookRow>, StoreError> {
    let lock = Dialect::of(connection).lock();
    let query = format!("SELECT * FROM webhooks WHERE id = $1 AND tenant_id = $2 {lock}");
    let row = sqlx::query(AssertSqlSafe(query))
        .bind(id.as_str())
        .bind(tenant_id.as_str())
        .fetch_optional(connection)
        .await?;
    row.as_ref().map(webhook_of).transpose()
}

fn webhook_of(row: &AnyRow) -> Result<WebhookRow, StoreError> {
    Ok(WebhookRow {
        id: database::id(row, "webhooks", "id")?,
        url: row.try_get("url")?,
        description: row.try_get("description")?,
        events: event::of_words(&row.try_get::<String, _>("events")?)?,
        disabled_reason: row.try_get("disabled_reason")?,
        created_at_ms: row.try_get("created_at")?,
        updated_at_ms: row.try_get("updated_at")?,
    })
}
