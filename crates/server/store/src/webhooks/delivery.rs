//! Deliveries: one message for one webhook each, with the account of its attempts.

use serde::Deserialize;
use sqlx::any::AnyRow;
use sqlx::{AnyConnection, Row};

use super::event::{EventType, Message, MessageData};
use super::{WebhookRow, locked, outbox};
use crate::boxed;
use crate::list_query::ListQuery;
use crate::{Store, StoreError, database};
use scene::{DeliveryId, TenantId, WebhookId};

/// Begin of the id of every delivery; a UUID follows.
pub(super) const ID_PREFIX: &str = "msg_";

/// State of a delivery.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum DeliveryState {
    /// For its first or its next attempt.
    Waiting,
    /// The receiver has accepted it.
    Delivered,
    /// The last attempt failed.
    Failed,
}

impl DeliveryState {
    pub const ALL: [Self; 3] = [Self::Waiting, Self::Delivered, Self::Failed];

    pub fn as_str(self) -> &'static str {
        match self {
            Self::Waiting => "waiting",
            Self::Delivered => "delivered",
            Self::Failed => "failed",
        }
    }

    /// Inverse of [`Self::as_str`].
    pub fn parse(text: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|state| state.as_str() == text)
    }
}

/// A delivery's row.
#[derive(Clone, Debug, PartialEq)]
pub struct DeliveryRow {
    /// `webhook-id` of the message, the same in every attempt.
    pub id: DeliveryId,
    pub webhook_id: WebhookId,
    pub event: EventType,
    pub message: Message,
    pub state: DeliveryState,
    /// Attempts since it was ordered, the present one included.
    pub attempts: u64,
    /// Time of the next attempt of one that waits, milliseconds since 1970.
    pub next_at_ms: i64,
    pub created_at_ms: i64,
    /// End of the last attempt, as the fields after it.
    pub tried_at_ms: Option<i64>,
    /// Status of the answer; `None` without one.
    pub status: Option<i64>,
    /// Reason why the attempt failed.
    pub error: Option<String>,
    pub duration_ms: Option<i64>,
}

/// Filter of a list of deliveries.
#[derive(Clone, Debug, Default)]
pub struct DeliveryFilter {
    pub state: Option<DeliveryState>,
    /// Only deliveries before the one of this UUID, the last of the previous page.
    pub before_uuid: Option<String>,
    pub limit: u32,
}

/// Result of an order to deliver.
#[derive(Clone, Debug, PartialEq)]
pub enum OrderOutcome {
    /// The delivery, which waits for its next attempt.
    Ordered(Box<DeliveryRow>),
    /// The webhook is disabled.
    Disabled,
    NoWebhook,
    NoDelivery,
}

impl DeliveryRow {
    /// The UUID in the id.
    pub fn uuid(&self) -> &str {
        self.id.as_str().trim_start_matches(ID_PREFIX)
    }
}

impl Store {
    /// Deliveries of a webhook of the tenant, newest first.
    #[boxed]
    pub async fn deliveries(
        &self,
        tenant_id: &TenantId,
        webhook_id: &WebhookId,
        filter: DeliveryFilter,
    ) -> Result<Vec<DeliveryRow>, StoreError> {
        let list = ListQuery::of(tenant_id)
            .text("webhook_id =", Some(webhook_id.as_str()))
            .word("state", filter.state.map(DeliveryState::as_str))
            .text("id <", filter.before_uuid.map(|uuid| format!("{ID_PREFIX}{uuid}")));
        let rows = list.select("deliveries", filter.limit).rows(&self.readers).await?;
        rows.iter().map(delivery_of).collect()
    }

    /// Orders a message for a webhook that tells of nothing.
    #[boxed]
    pub async fn test_webhook(
        &self,
        tenant_id: &TenantId,
        id: &WebhookId,
    ) -> Result<OrderOutcome, StoreError> {
        let (tenant_id, id) = (tenant_id.clone(), id.clone());
        let ordered = self.writer.write("test a webhook", move |connection| {
            Box::pin(async move { test(connection, &tenant_id, &id).await })
        });
        let ordered = ordered.await?;
        self.announce();
        Ok(ordered)
    }

    /// Orders a delivery again, with the same message; attempts of one that has ended count anew. One that waits is due
    /// now.
    #[boxed]
    pub async fn replay_delivery(
        &self,
        tenant_id: &TenantId,
        webhook_id: &WebhookId,
        id: &DeliveryId,
    ) -> Result<OrderOutcome, StoreError> {
        let (tenant_id, webhook_id, id) = (tenant_id.clone(), webhook_id.clone(), id.clone());
        let ordered = self.writer.write("replay a delivery", move |connection| {
            Box::pin(async move { replay(connection, &tenant_id, &webhook_id, &id).await })
        });
        let ordered = ordered.await?;
        self.announce();
        Ok(ordered)
    }
}

async fn test(
    connection: &mut AnyConnection,
    tenant_id: &TenantId,
    id: &WebhookId,
) -> Result<OrderOutcome, StoreError> {
    if let Some(refused) = refusal(locked(connection, tenant_id, id).await?.as_ref()) {
        return Ok(refused);
    }
    let now = database::now_ms(connection).await?;
    let data = MessageData {
        id: id.to_string(),
        state: "test".to_owned(),
        failure_code: None,
        job_id: None,
        path: format!("/webhooks/{id}"),
    };
    let event = EventType::WebhookTest;
    let payload = Message::text(event, now, data);
    let id = outbox::insert(connection, tenant_id.as_str(), id.as_str(), event, &payload, now).await?;
    let row = sqlx::query("SELECT * FROM deliveries WHERE id = $1").bind(id.as_str());
    Ok(OrderOutcome::Ordered(Box::new(delivery_of(&row.fetch_one(connection).await?)?)))
}

async fn replay(
    connection: &mut AnyConnection,
    tenant_id: &TenantId,
    webhook_id: &WebhookId,
    id: &DeliveryId,
) -> Result<OrderOutcome, StoreError> {
    if let Some(refused) = refusal(locked(connection, tenant_id, webhook_id).await?.as_ref()) {
        return Ok(refused);
    }
    let now = database::now_ms(connection).await?;
    let row = sqlx::query(
        "UPDATE deliveries SET attempts = CASE WHEN state = 'waiting' THEN attempts ELSE 0 END,
                               state = 'waiting', next_at = $1
         WHERE id = $2 AND webhook_id = $3 RETURNING *",
    )
    .bind(now)
    .bind(id.as_str())
    .bind(webhook_id.as_str())
    .fetch_optional(connection)
    .await?;
    Ok(match row.as_ref().map(delivery_of).transpose()? {
        Some(row) => OrderOutcome::Ordered(Box::new(row)),
        None => OrderOutcome::NoDelivery,
    })
}

fn refusal(webhook: Option<&WebhookRow>) -> Option<OrderOutcome> {
    match webhook {
        None => Some(OrderOutcome::NoWebhook),
        Some(webhook) if webhook.disabled_reason.is_some() => Some(OrderOutcome::Disabled),
        Some(_) => None,
    }
}

fn delivery_of(row: &AnyRow) -> Result<DeliveryRow, StoreError> {
    let corrupt = |reason: String| StoreError::Corrupt { table: "deliveries", reason };
    let (event, state): (String, String) = (row.try_get("event")?, row.try_get("state")?);
    let payload: String = row.try_get("payload")?;
    Ok(DeliveryRow {
        id: database::id(row, "deliveries", "id")?,
        webhook_id: database::id(row, "deliveries", "webhook_id")?,
        event: EventType::parse(&event).ok_or_else(|| corrupt(format!("event {event}")))?,
        message: serde_json::from_str(&payload).map_err(|error| corrupt(format!("payload: {error}")))?,
        state: DeliveryState::parse(&state).ok_or_else(|| corrupt(format!("state {state}")))?,
        attempts: u64::try_from(row.try_get::<i64, _>("attempts")?).unwrap_or(0),
        next_at_ms: row.try_get("next_at")?,
        created_at_ms: row.try_get("created_at")?,
        tried_at_ms: row.try_get("tried_at")?,
        status: row.try_get("status")?,
        error: row.try_get("error")?,
        duration_ms: row.try_get("duration_ms")?,
    })
}
