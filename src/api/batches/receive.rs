//! The body of `POST /batches`: read on a thread that may block, stored in groups as it is read.
//!
//! Memory holds the body and a few groups, not the requests that a recipe makes. Every request of a recipe is checked
//! and counted now; only the first group is stored, the others as they are fed (see `service::feeding`).

use axum::extract::Request;
use tokio::sync::mpsc;

use super::parameters::SubmitParameters;
use crate::api::admission::overloaded;
use crate::api::body::{BodyReader, ReceivedBody};
use crate::api::extract::TenantApi;
use crate::api::json_body::media_type;
use crate::api::limits::{check_bytes, refused};
use crate::app::batch_reading::{BatchReader, BodyKind};
use crate::problem::{Problem, ProblemType};
use scene::BatchId;
use store::Digest;
use store::batches::{NewBatch, NewItem, PublishOutcome, RecipeRest, RestCounts};

/// Requests that are stored in one transaction, which others wait for.
const GROUP: usize = 200;
/// Groups that wait for the store.
const GROUPS_AHEAD: usize = 2;

/// Stores a batch once for each idempotency key; its id.
pub(super) async fn receive(
    api: &TenantApi,
    parameters: SubmitParameters,
    key: Option<String>,
    request: Request,
) -> Result<BatchId, Problem> {
    let (parts, body) = request.into_parts();
    let kind = BodyKind::of(&media_type(&parts.headers))?;
    let body = BodyReader::new(api, &parts, body, api.settings.max_body_bytes).collect().await?;
    let _permit = api.requests.clone().try_acquire_owned().map_err(|_| overloaded())?;
    let name = parameters.name.map(|name| name.0).unwrap_or_default();
    let budget = parameters.budget_usd.map(|budget| budget.0.amount());
    let stated = format!("{kind:?} {name:?} {budget:?} ");
    let (body, body_digest) = digested(stated, body).await?;
    if let Some(key) = &key
        && let Some((id, earlier_digest)) = api.store.batch_by_key(&api.tenant_id, key).await?
    {
        return if earlier_digest == body_digest.as_str() {
            Ok(id)
        } else {
            Err(Problem::key_reused("batch"))
        };
    }
    check_bytes(api).await?;
    // Before its requests are read and stored; counted again, with them, where it is published.
    if let Some(reached) = api.store.full_of_batches(&api.tenant_id).await? {
        return Err(refused(reached));
    }
    let new = NewBatch { tenant_id: api.tenant_id.clone(), name, budget, idempotency_key: key, body_digest };
    let id = api.store.begin_batch(new).await?;
    if let Err(problem) = store_requests(api, &id, kind, body).await {
        // What cannot be removed now, a sweep removes.
        if let Err(error) = api.store.discard_batch(&id).await {
            tracing::warn!(error = error.chain(), batch_id = %id, "a refused batch was not removed");
        }
        return Err(problem);
    }
    match api.store.publish_batch(&id).await? {
        PublishOutcome::Published => {
            metrics::counter!("tabletopgen_batches_submitted_total").increment(1);
            Ok(id)
        }
        PublishOutcome::Replayed(earlier) => Ok(earlier),
        PublishOutcome::KeyReused => Err(Problem::key_reused("batch")),
        PublishOutcome::Refused(reached) => Err(refused(reached)),
    }
}

/// The body with the digest of everything that is asked for. It takes a moment for a large body, so it is computed
/// apart.
async fn digested(stated: String, body: ReceivedBody) -> Result<(ReceivedBody, Digest), Problem> {
    let computed = tokio::task::spawn_blocking(move || {
        let content = Digest::of(&body);
        (body, Digest::of(format!("{stated}{content}").as_bytes()))
    });
    computed.await.map_err(|_| stopped())
}

fn stopped() -> Problem {
    let detail = "a bug stopped the reader of the body; the log has the details under this request id";
    Problem::new(ProblemType::Internal, "internal_error", detail)
}

/// Reads, checks and stores every request of the body.
async fn store_requests(
    api: &TenantApi,
    id: &BatchId,
    kind: BodyKind,
    body: ReceivedBody,
) -> Result<(), Problem> {
    let _turn = api.receptions.of(&api.tenant_id).await;
    let (groups, mut received) = mpsc::channel(GROUPS_AHEAD);
    let reader = BatchReader { app: api.app.clone() };
    let reading = tokio::task::spawn_blocking(move || read(&reader, kind, &body, &groups));
    while let Some(group) = received.recv().await {
        // An error drops the receiver, and the reader stops at its next group.
        api.store.append_items(id, group).await?;
    }
    if let Some(rest) = reading.await.unwrap_or_else(|_| Err(stopped()))? {
        api.store.keep_recipe(id, rest).await?;
    }
    Ok(())
}

/// Reads the requests. Of a recipe the first group is sent; the rest of its requests is the result.
fn read(
    reader: &BatchReader,
    kind: BodyKind,
    body: &ReceivedBody,
    groups: &mpsc::Sender<Vec<NewItem>>,
) -> Result<Option<RecipeRest>, Problem> {
    let mut group = Vec::with_capacity(GROUP);
    let mut rest: Option<(u64, RestCounts)> = None;
    reader.read(kind, body, |item| {
        if kind == BodyKind::Recipe && group.len() == GROUP {
            rest.get_or_insert((item.place, RestCounts::default())).1.add(&item.content);
            return true;
        }
        group.push(item);
        kind == BodyKind::Recipe
            || group.len() < GROUP
            || groups.blocking_send(std::mem::replace(&mut group, Vec::with_capacity(GROUP))).is_ok()
    })?;
    if !group.is_empty() {
        // The receiver is gone where the store has failed, which is the error that the client gets.
        let _ = groups.blocking_send(group);
    }
    // The reader has parsed it, so it is a text.
    let recipe = || String::from_utf8_lossy(body).into_owned();
    Ok(rest.map(|(first_place, counts)| RecipeRest { recipe: recipe(), first_place, counts }))
}
