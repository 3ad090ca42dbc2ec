//! Attempts at deliveries: who takes one, and how it ended.
//!
//! A claim takes a webhook for a time, with the delivery of it that is due first, and counts the attempt. A process
//! that dies leaves a delivery that is due again after that time. The number of the attempt is the fencing token: what
//! a process says that was paused past its time changes nothing. Webhooks take turns by the end of their last attempt.

use std::time::Duration;

use sqlx::any::AnyRow;
use sqlx::{AnyConnection, AssertSqlSafe, Row};

use crate::boxed;
use crate::database::Dialect;
use crate::secret::Secret;
use crate::{Store, StoreError, database};
use scene::{DeliveryId, WebhookId};

/// A delivery that this process is to attempt.
#[derive(Clone, Debug)]
pub struct DueDelivery {
    pub id: DeliveryId,
    pub webhook_id: WebhookId,
    pub url: String,
    /// The secret, and the previous one while it signs along.
    pub secrets: Vec<Secret>,
    /// JSON, as it is signed and sent.
    pub payload: String,
    /// Number of this attempt, from 1.
    pub attempt: u64,
}

/// Account of an attempt.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AttemptReport {
    /// Status of the answer; `None` without one.
    pub status: Option<u16>,
    /// Reason why it failed.
    pub error: Option<String>,
    pub duration: Duration,
    pub end: AttemptEnd,
}

/// Consequence of an attempt.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AttemptEnd {
    Delivered,
    RetryAfter(Duration),
    /// The delivery has failed. The `max_failures`-th in a row disables its webhook.
    Failed {
        max_failures: u32,
    },
    /// The delivery has failed, and the receiver wants no more: its webhook is disabled.
    Gone,
}

/// Condition on a webhook that has a delivery due at `$1` and that no process sends to.
const IS_DUE: &str = "disabled_reason IS NULL AND leased_until <= $1
    AND EXISTS (SELECT 1 FROM deliveries WHERE deliveries.webhook_id = webhooks.id
                AND deliveries.state = 'waiting' AND deliveries.next_at <= $1)";

impl Store {
    /// Takes what is due, at most `limit` deliveries, each of another webhook, for this long.
    #[boxed]
    pub async fn claim_deliveries(
        &self,
        lease: Duration,
        limit: u32,
    ) -> Result<Vec<DueDelivery>, StoreError> {
        // A cheap question, as most changes make nothing due.
        let now = self.readers.now_ms().await?;
        let query = format!("SELECT id FROM webhooks WHERE {IS_DUE} ORDER BY leased_until, id LIMIT 1");
        let due: Option<String> =
            sqlx::query_scalar(AssertSqlSafe(query)).bind(now).fetch_optional(&self.readers).await?;
        if due.is_none() {
            return Ok(Vec::new());
        }
        self.writer
            .write("claim deliveries", move |connection| {
                Box::pin(async move { claim(connection, lease, limit).await })
            })
            .await
    }

    /// Writes how an attempt ended. Returns whether it was still this process's.
    #[boxed]
    pub async fn end_attempt(&self, due: &DueDelivery, report: AttemptReport) -> Result<bool, StoreError> {
        let (id, webhook_id, attempt) = (due.id.clone(), due.webhook_id.clone(), due.attempt);
        self.writer
            .write("end an attempt at a delivery", move |connection| {
                Box::pin(async move { end(connection, &id, &webhook_id, attempt, &report).await })
            })
            .await
    }
}

async fn claim(
    connection: &mut AnyConnection,
    lease: Duration,
    limit: u32,
) -> Result<Vec<DueDelivery>, StoreError> {
    let now = database::now_ms(connection).await?;
    let lock = Dialect::of(connection).lock_free_rows();
    let query = format!("SELECT id FROM webhooks WHERE {IS_DUE} ORDER BY leased_until, id LIMIT $2 {lock}");
    let webhooks: Vec<String> = sqlx::query_scalar(AssertSqlSafe(query))
        .bind(now)
        .bind(i64::from(limit))
        .fetch_all(&mut *connection)
        .await?;
    let mut taken = Vec::with_capacity(webhooks.len());
    for webhook in webhooks {
        let delivery = sqlx::query(
            "UPDATE deliveries SET attempts = attempts + 1
             WHERE id = (SELECT id FROM deliveries WHERE webhook_id = $1 AND state = 'waiting' AND next_at <= $2
                         ORDER BY next_at, id LIMIT 1)
             RETURNING *",
        )
        .bind(&webhook)
        .bind(now)
        .fetch_optional(&mut *connection)
        .await?;
        let Some(delivery) = delivery else { continue };
        let webhook = sqlx::query("UPDATE webhooks SET leased_until = $1 WHERE id = $2 RETURNING *")
            .bind(now + i64::try_from(lease.as_millis()).unwrap_or(i64::MAX / 4))
            .bind(&webhook)
            .fetch_one(&mut *connection)
            .await?;
        taken.push(due_of(&webhook, &delivery, now)?);
    }
    Ok(taken)
}

async fn end(
    connection: &mut AnyConnection,
    id: &DeliveryId,
    webhook_id: &WebhookId,
    attempt: u64,
    report: &AttemptReport,
) -> Result<bool, StoreError> {
    let lock = Dialect::of(connection).lock();
    let query = format!("SELECT failed_in_a_row FROM webhooks WHERE id = $1 {lock}");
    let failed_before: Option<i64> = sqlx::query_scalar(AssertSqlSafe(query))
        .bind(webhook_id.as_str())
        .fetch_optional(&mut *connection)
        .await?;
    // It was deleted meanwhile.
    let Some(failed_before) = failed_before else { return Ok(false) };
    let now = database::now_ms(connection).await?;
    let (state, wait) = match report.end {
        AttemptEnd::Delivered => ("delivered", Duration::ZERO),
        AttemptEnd::RetryAfter(wait) => ("waiting", wait),
        AttemptEnd::Failed { .. } | AttemptEnd::Gone => ("failed", Duration::ZERO),
    };
    let ended = sqlx::query(
        "UPDATE deliveries SET state = $1, next_at = $2, tried_at = $3, status = $4, error = $5, duration_ms = $6
         WHERE id = $7 AND state = 'waiting' AND attempts = $8",
    )
    .bind(state)
    .bind(now + i64::try_from(wait.as_millis()).unwrap_or(i64::MAX / 4))
    .bind(now)
    .bind(report.status.map(i64::from))
    .bind(&report.error)
    .bind(i64::try_from(report.duration.as_millis()).unwrap_or(i64::MAX))
    .bind(id.as_str())
    .bind(i64::try_from(attempt).unwrap_or(i64::MAX))
    .execute(&mut *connection)
    .await?;
    if ended.rows_affected() == 0 {
        return Ok(false);
    }
    let failed = match report.end {
        AttemptEnd::Delivered => 0,
        AttemptEnd::RetryAfter(_) => failed_before,
        AttemptEnd::Failed { .. } | AttemptEnd::Gone => failed_before + 1,
    };
    let error = report.error.as_deref().unwrap_or_default();
    let reason = match report.end {
        AttemptEnd::Gone => Some("its address answered 410 Gone".to_owned()),
        AttemptEnd::Failed { max_failures } if failed >= i64::from(max_failures) => Some(format!(
            "{failed} deliveries in a row failed in every attempt, the last one because: {error}"
        )),
        _ => None,
    };
    sqlx::query(
        "UPDATE webhooks SET leased_until = $1, failed_in_a_row = $2,
                             updated_at = CASE WHEN disabled_reason IS NULL AND $3 IS NOT NULL THEN $1 ELSE updated_at END,
                             disabled_reason = COALESCE(disabled_reason, $3)
         WHERE id = $4",
    )
    .bind(now)
    .bind(failed)
    .bind(reason)
    .bind(webhook_id.as_str())
    .execute(connection)
    .await?;
    Ok(true)
}

fn due_of(webhook: &AnyRow, delivery: &AnyRow, now_ms: i64) -> Result<DueDelivery, StoreError> {
    let previous: Option<String> = webhook.try_get("previous_secret")?;
    let previous_until: Option<i64> = webhook.try_get("previous_secret_until")?;
    let previous = previous.filter(|_| previous_until.is_some_and(|until| until > now_ms));
    let secret: String = webhook.try_get("secret")?;
    Ok(DueDelivery {
        id: database::id(delivery, "deliveries", "id")?,
        webhook_id: database::id(delivery, "deliveries", "webhook_id")?,
        url: webhook.try_get("url")?,
        secrets: [Some(secret), previous].into_iter().flatten().map(|text| Secret::given(&text)).collect(),
        payload: delivery.try_get("payload")?,
        attempt: u64::try_from(delivery.try_get::<i64, _>("attempts")?).unwrap_or(0),
    })
}
