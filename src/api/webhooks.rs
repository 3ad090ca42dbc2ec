//! `/webhooks`: administrators say where events of their tenant are sent, and see what was sent.

use axum::Json;
use axum::http::StatusCode;
use axum::response::{IntoResponse, Response};
use schemars::JsonSchema;
use serde::{Deserialize, Deserializer, Serialize};
use serde_json::json;

use super::deletion;
use super::extract::{JsonBody, JsonRequest, PathId, PathName, TenantApi};
use super::merge_patch::MergePatch;
use super::preconditions::{IfMatch, tag};
use super::query::{NoParameters, Page, PageSize, PageToken, Parameters};
use crate::app::webhooks::{MAX_DESCRIPTION_CHARS, MAX_URL_CHARS, WebhookChange};
use crate::problem::{Problem, ProblemType};
use crate::schemas::values::{Id, MessageId, Timestamp};
use crate::schemas::words;
use scene::{DeliveryId, WebhookId};
use store::Digest;
use store::secret::Secret;
use store::webhooks::{
    CreateOutcome, DeliveryFilter, DeliveryRow, DeliveryState, EventType, MAX_WEBHOOKS, Message, NewWebhook,
    OrderOutcome, WebhookRow,
};

/// A webhook to be made.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "NewWebhook")]
pub struct WebhookDraft {
    /// https, at a public address, without a name and a password.
    #[schemars(url, length(min = 1, max = MAX_URL_CHARS))]
    url: String,
    /// For people.
    #[serde(default)]
    #[schemars(length(max = MAX_DESCRIPTION_CHARS), regex(pattern = r"^[^\x00-\x1F\x7F-\x9F]*$"))]
    description: String,
    /// Events to send; all, where it is absent or empty.
    #[serde(default)]
    #[schemars(length(max = EventType::ALL.len()))]
    events: Vec<EventType>,
}

impl JsonRequest for WebhookDraft {
    type Schema = Self;
    const EXAMPLE: &str =
        r#"{"url": "https://example.org/hooks/scenes", "events": ["scene.succeeded", "scene.failed"]}"#;
}

/// Whether events are sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum WebhookState {
    Enabled,
    Disabled,
}

/// A change of a webhook.
#[derive(Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct WebhookPatch {
    #[serde(deserialize_with = "present")]
    #[schemars(with = "String", url, length(min = 1, max = MAX_URL_CHARS))]
    url: Option<String>,
    /// Null removes it.
    #[serde(deserialize_with = "or_default")]
    #[schemars(length(max = MAX_DESCRIPTION_CHARS), regex(pattern = r"^[^\x00-\x1F\x7F-\x9F]*$"))]
    description: Option<String>,
    /// Null or an empty list: all.
    #[serde(deserialize_with = "or_default")]
    #[schemars(length(max = EventType::ALL.len()))]
    events: Option<Vec<EventType>>,
    /// One that is enabled again sends what has waited since.
    #[serde(deserialize_with = "present")]
    #[schemars(with = "WebhookState")]
    state: Option<WebhookState>,
}

impl JsonRequest for WebhookPatch {
    type Schema = Self;
    const EXAMPLE: &str = r#"{"state": "disabled"}"#;
}

/// A value that cannot be removed: null is refused.
fn present<'de, D: Deserializer<'de>, T: Deserialize<'de>>(deserializer: D) -> Result<Option<T>, D::Error> {
    T::deserialize(deserializer).map(Some)
}

/// A value that is set; null stands for the default.
fn or_default<'de, D, T>(deserializer: D) -> Result<Option<T>, D::Error>
where
    D: Deserializer<'de>,
    T: Deserialize<'de> + Default,
{
    Ok(Some(Option::deserialize(deserializer)?.unwrap_or_default()))
}

/// A webhook.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "Webhook")]
pub(super) struct WebhookView {
    #[schemars(with = "Id")]
    id: WebhookId,
    url: String,
    description: String,
    /// Events that are sent; empty: all.
    events: Vec<EventType>,
    state: WebhookState,
    /// Reason why it is disabled.
    disabled_reason: Option<String>,
    created_at: Timestamp,
    updated_at: Timestamp,
    /// Key of the signatures, in the answer to its making alone.
    #[serde(skip_serializing_if = "Option::is_none")]
    secret: Option<String>,
}

impl WebhookView {
    fn new(row: WebhookRow, secret: Option<&Secret>) -> Self {
        Self {
            id: row.id,
            url: row.url,
            description: row.description,
            events: row.events,
            state: if row.disabled_reason.is_none() { WebhookState::Enabled } else { WebhookState::Disabled },
            disabled_reason: row.disabled_reason,
            created_at: Timestamp::of_ms(row.created_at_ms),
            updated_at: Timestamp::of_ms(row.updated_at_ms),
            secret: secret.map(|secret| secret.expose().to_owned()),
        }
    }
}

/// The webhooks of the tenant, newest first.
#[derive(Serialize, JsonSchema)]
pub(super) struct WebhookList {
    #[schemars(length(max = MAX_WEBHOOKS))]
    webhooks: Vec<WebhookView>,
}

/// A message for a webhook, with the account of its attempts.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "Delivery")]
pub(super) struct DeliveryView {
    /// The header `webhook-id`, the same in every attempt.
    #[schemars(with = "MessageId")]
    id: DeliveryId,
    event: EventType,
    #[schemars(with = "words::DeliveryState")]
    state: &'static str,
    created_at: Timestamp,
    /// Attempts since it was ordered, the present one included.
    #[schemars(range(min = 0, max = 1_000_000))]
    attempts: u64,
    /// Earliest time of the next attempt; null for one that has ended.
    next_attempt_at: Option<Timestamp>,
    last_attempt: Option<AttemptView>,
    message: Message,
}

/// The last attempt that has ended.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "DeliveryAttempt")]
pub(super) struct AttemptView {
    ended_at: Timestamp,
    /// Status of the answer; null without one.
    #[schemars(range(min = 100, max = 999))]
    status: Option<i64>,
    /// Reason why it failed; null for one that was accepted.
    error: Option<String>,
    #[schemars(range(min = 0, max = 1_000_000_000))]
    duration_ms: i64,
}

impl DeliveryView {
    fn new(row: DeliveryRow) -> Self {
        let DeliveryRow { id, event, state, attempts, message, status, error, .. } = row;
        let duration_ms = row.duration_ms.unwrap_or(0);
        let attempt = |at| AttemptView { ended_at: Timestamp::of_ms(at), status, error, duration_ms };
        Self {
            id,
            event,
            state: state.as_str(),
            created_at: Timestamp::of_ms(row.created_at_ms),
            attempts,
            next_attempt_at: (state == DeliveryState::Waiting).then(|| Timestamp::of_ms(row.next_at_ms)),
            last_attempt: row.tried_at_ms.map(attempt),
            message,
        }
    }
}

/// A page of deliveries.
#[derive(Serialize, JsonSchema)]
pub(super) struct DeliveryPage {
    deliveries: Vec<DeliveryView>,
    /// Null on the last page.
    next_page_token: Option<String>,
}

/// Parameters of `GET /webhooks/{webhook_id}/deliveries`.
#[derive(Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct DeliveryParameters {
    #[schemars(with = "Option<words::DeliveryState>")]
    state: Option<DeliveryState>,
    page_size: PageSize,
    page_token: Option<PageToken>,
}

/// `POST /webhooks`.
pub async fn create(
    api: TenantApi,
    JsonBody { value: draft, memory: _memory }: JsonBody<WebhookDraft>,
) -> Result<Response, Problem> {
    let WebhookDraft { url, description, events } = draft;
    let new = NewWebhook { tenant_id: api.tenant_id.clone(), url, description, events };
    api.app.check_webhook(&new)?;
    match api.store.create_webhook(new).await? {
        (CreateOutcome::Created(row), secret) => {
            let mut response = with_tag(row, Some(&secret));
            *response.status_mut() = StatusCode::CREATED;
            Ok(response)
        }
        (CreateOutcome::TooMany, _) => {
            let detail =
                format!("you have {MAX_WEBHOOKS} webhooks, as many as a tenant may; delete one first");
            Err(Problem::new(ProblemType::Conflict, "too_many_webhooks", detail))
        }
    }
}

/// `GET /webhooks`.
pub async fn list(api: TenantApi, _: Parameters<NoParameters>) -> Result<Response, Problem> {
    let rows = api.store.webhooks(&api.tenant_id).await?;
    let webhooks = rows.into_iter().map(|row| WebhookView::new(row, None)).collect();
    Ok(Json(WebhookList { webhooks }).into_response())
}

/// `GET /webhooks/{webhook_id}`.
pub async fn show(api: TenantApi, PathId(id): PathId<WebhookId>) -> Result<Response, Problem> {
    let row = api.store.webhook(&api.tenant_id, &id).await?.ok_or_else(|| unknown(&id))?;
    Ok(with_tag(row, None))
}

/// `PATCH /webhooks/{webhook_id}`.
pub async fn change(
    api: TenantApi,
    PathId(id): PathId<WebhookId>,
    if_match: IfMatch,
    MergePatch(patch): MergePatch<WebhookPatch>,
) -> Result<Response, Problem> {
    let WebhookPatch { url, description, events, state } = patch;
    let is_enabled = state.map(|state| state == WebhookState::Enabled);
    let change = WebhookChange { url, description, events, is_enabled };
    let is_expected = |row: &WebhookRow| if_match.allows(&webhook_tag(row));
    let row = api.app.change_webhook(&api.store, &api.tenant_id, &id, &change, is_expected).await?;
    Ok(with_tag(row, None))
}

/// `DELETE /webhooks/{webhook_id}`.
pub async fn remove(api: TenantApi, PathId(id): PathId<WebhookId>) -> Result<StatusCode, Problem> {
    deletion::answer(api.store.delete_webhook(&api.tenant_id, &id).await?, &id)
}

/// `POST /webhooks/{webhook_id}/secret`.
pub async fn renew_secret(api: TenantApi, PathId(id): PathId<WebhookId>) -> Result<Response, Problem> {
    let renewed = api.store.renew_webhook_secret(&api.tenant_id, &id).await?;
    let (row, secret) = renewed.ok_or_else(|| unknown(&id))?;
    Ok(with_tag(row, Some(&secret)))
}

/// `POST /webhooks/{webhook_id}/test`.
pub async fn test(api: TenantApi, PathId(id): PathId<WebhookId>) -> Result<Response, Problem> {
    ordered(api.store.test_webhook(&api.tenant_id, &id).await?, &id, "")
}

/// `GET /webhooks/{webhook_id}/deliveries`.
pub async fn deliveries(
    api: TenantApi,
    PathId(id): PathId<WebhookId>,
    Parameters(DeliveryParameters { state, page_size, page_token }): Parameters<DeliveryParameters>,
) -> Result<Response, Problem> {
    api.store.webhook(&api.tenant_id, &id).await?.ok_or_else(|| unknown(&id))?;
    let before_uuid = page_token.and_then(PageToken::last_id);
    let filter = DeliveryFilter { state, before_uuid, limit: page_size.rows_to_read() };
    let rows = api.store.deliveries(&api.tenant_id, &id, filter).await?;
    let Page { rows, next_page_token } = page_size.page_of(rows, |row| PageToken::after(row.uuid()));
    let deliveries = rows.into_iter().map(DeliveryView::new).collect();
    Ok(Json(DeliveryPage { deliveries, next_page_token }).into_response())
}

/// `POST /webhooks/{webhook_id}/deliveries/{delivery_id}/replay`.
pub async fn replay(
    api: TenantApi,
    PathId(id): PathId<WebhookId>,
    PathName(name): PathName,
) -> Result<Response, Problem> {
    let outcome = match name.parse::<DeliveryId>() {
        Ok(delivery) => api.store.replay_delivery(&api.tenant_id, &id, &delivery).await?,
        Err(_) => OrderOutcome::NoDelivery,
    };
    ordered(outcome, &id, &name)
}

/// The answer to an order of a delivery.
fn ordered(outcome: OrderOutcome, id: &WebhookId, delivery: &str) -> Result<Response, Problem> {
    match outcome {
        OrderOutcome::Ordered(row) => {
            Ok((StatusCode::ACCEPTED, Json(DeliveryView::new(*row))).into_response())
        }
        OrderOutcome::Disabled => {
            let detail = "this webhook is disabled; change its state to enabled first";
            Err(Problem::new(ProblemType::Conflict, "webhook_disabled", detail))
        }
        OrderOutcome::NoWebhook => Err(unknown(id)),
        OrderOutcome::NoDelivery => Err(Problem::not_found("delivery of this webhook", delivery)),
    }
}

fn unknown(id: &WebhookId) -> Problem {
    Problem::not_found("webhook", id.as_str())
}

/// The `ETag` of a webhook: the digest of its fields without the secret.
fn webhook_tag(row: &WebhookRow) -> String {
    let fields = json!(WebhookView::new(row.clone(), None));
    format!("\"{}\"", Digest::of(fields.to_string().as_bytes()))
}

/// The answer with a webhook and its tag, which no cache keeps.
fn with_tag(row: WebhookRow, secret: Option<&Secret>) -> Response {
    let webhook_tag = webhook_tag(&row);
    let mut response = Json(WebhookView::new(row, secret)).into_response();
    tag(&mut response, &webhook_tag);
    response
}
