//! `/batches`: submit, list, show, results, cancel, retry, delete.
//!
//! A batch is stored with all its requests before the submission is answered ([`receive`]). Feeders then put them into
//! the queue a few at a time (see `store::batches`): one batch neither fills the queue nor keeps others waiting.

mod output;
mod parameters;
mod receive;
pub(super) mod views;

use axum::Json;
use axum::extract::Request;
use axum::http::StatusCode;
use axum::response::{IntoResponse, Response};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::accepted::accepted_at;
use super::deletion::{self, gone};
use super::extract::{JsonRequest, OptionalJsonBody, PathId, TenantApi};
use super::idempotency::{IdempotencyKey, KeyScope, scoped};
use super::limits::{check_bytes, refused};
use super::query::{Page, PageSize, PageToken, Parameters};
use crate::problem::{Problem, ProblemType};
use crate::schemas::values::BatchBudget;
use crate::schemas::words;
use ::batches::BatchState;
use scene::BatchId;
use store::batches::{BatchCancelOutcome, BatchFilter, BatchRetryOutcome, BatchRow, BatchScenes};

pub use output::{errors, output};
use parameters::{BudgetUsd, SubmitParameters};
use views::BatchView;

/// `POST /batches`.
pub async fn submit(
    api: TenantApi,
    Parameters(parameters): Parameters<SubmitParameters>,
    IdempotencyKey(idempotency_key): IdempotencyKey,
    request: Request,
) -> Result<Response, Problem> {
    let key = scoped(&api, KeyScope::Batch, idempotency_key.as_deref());
    let id = receive::receive(&api, parameters, key, request).await?;
    accepted(&api, &id).await
}

/// Parameters of `GET /batches`.
#[derive(Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ListParameters {
    #[schemars(with = "Option<words::BatchState>")]
    state: Option<BatchState>,
    page_size: PageSize,
    page_token: Option<PageToken>,
}

/// A page of batches.
#[derive(Serialize, JsonSchema)]
pub(super) struct BatchPage {
    batches: Vec<BatchView>,
    /// Null on the last page.
    next_page_token: Option<String>,
}

/// `GET /batches`.
pub async fn list(
    api: TenantApi,
    Parameters(parameters): Parameters<ListParameters>,
) -> Result<Response, Problem> {
    let size = parameters.page_size;
    let filter = BatchFilter {
        state: parameters.state,
        before_id: parameters.page_token.and_then(PageToken::last_id),
        limit: size.rows_to_read(),
    };
    let rows = api.store.batches(&api.tenant_id, filter).await?;
    let Page { rows, next_page_token } = size.page_of(rows, |batch| PageToken::after(batch.id.as_str()));
    let accounts = api.store.batch_accounts(&rows).await?;
    let batches = rows.into_iter().zip(accounts).map(|(row, account)| BatchView::new(row, account));
    let page = BatchPage { batches: batches.collect(), next_page_token };
    Ok(Json(page).into_response())
}

/// `GET /batches/{batch_id}`.
pub async fn show(api: TenantApi, PathId(batch_id): PathId<BatchId>) -> Result<Response, Problem> {
    Ok(Json(view(&api, &batch_id).await?).into_response())
}

/// `POST /batches/{batch_id}/cancel`.
pub async fn cancel(api: TenantApi, PathId(batch_id): PathId<BatchId>) -> Result<Response, Problem> {
    find(&api, &batch_id).await?;
    match api.store.cancel_batch(&api.tenant_id, &batch_id).await? {
        BatchCancelOutcome::Accepted => accepted(&api, &batch_id).await,
        BatchCancelOutcome::TooLate(state) => Err(Problem::new(
            ProblemType::Conflict,
            "batch_already_ended",
            format!("this batch is {} already; there is nothing to cancel", state.as_str()),
        )),
        BatchCancelOutcome::NotFound => Err(Problem::not_found("batch", batch_id.as_str())),
    }
}

/// The optional body of a retry.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
#[schemars(rename = "BatchRetry")]
pub struct RetryBody {
    /// The new budget of the batch, with what is spent already.
    #[schemars(with = "Option<BatchBudget>")]
    budget_usd: Option<BudgetUsd>,
}

impl JsonRequest for RetryBody {
    type Schema = Self;
    const EXAMPLE: &str = r#"{"budget_usd": 10}"#;
}

/// `POST /batches/{batch_id}/retry`.
pub async fn retry(
    api: TenantApi,
    PathId(batch_id): PathId<BatchId>,
    OptionalJsonBody(body): OptionalJsonBody<RetryBody>,
) -> Result<Response, Problem> {
    let budget = body.budget_usd.map(BudgetUsd::amount);
    check_bytes(&api).await?;
    let conflict = |code, detail| Err(Problem::new(ProblemType::Conflict, code, detail));
    find(&api, &batch_id).await?;
    match api.store.retry_batch(&api.tenant_id, &batch_id, budget).await? {
        BatchRetryOutcome::Accepted(_) => accepted(&api, &batch_id).await,
        BatchRetryOutcome::NothingToRetry => conflict(
            "nothing_to_retry",
            "no request of this batch has failed or was cancelled; quarantined ones want another seed",
        ),
        BatchRetryOutcome::StillCancelling => {
            conflict("batch_still_cancelling", "requests of this batch are still stopping; retry it then")
        }
        BatchRetryOutcome::NotFound => Err(Problem::not_found("batch", batch_id.as_str())),
        BatchRetryOutcome::Refused(reached) => Err(refused(reached)),
    }
}

/// Parameters of `DELETE /batches/{batch_id}`.
#[derive(Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct DeletionParameters {
    /// Fate of the scenes of the batch; they stay if absent.
    #[schemars(with = "Option<ScenesOfBatch>")]
    scenes: ScenesOfBatch,
}

/// Fate of the scenes of a batch that is deleted.
#[derive(Clone, Copy, Debug, Default, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum ScenesOfBatch {
    #[default]
    Keep,
    Delete,
}

/// `DELETE /batches/{batch_id}`.
pub async fn remove(
    api: TenantApi,
    PathId(batch_id): PathId<BatchId>,
    Parameters(parameters): Parameters<DeletionParameters>,
) -> Result<StatusCode, Problem> {
    let scenes = match parameters.scenes {
        ScenesOfBatch::Keep => BatchScenes::Keep,
        ScenesOfBatch::Delete => BatchScenes::Delete,
    };
    deletion::answer(api.store.delete_batch(&api.tenant_id, &batch_id, scenes).await?, &batch_id)
}

/// 202 with the batch and its address.
async fn accepted(api: &TenantApi, batch_id: &BatchId) -> Result<Response, Problem> {
    let view = view(api, batch_id).await?;
    Ok(accepted_at(&view.links.this, &view))
}

async fn view(api: &TenantApi, batch_id: &BatchId) -> Result<BatchView, Problem> {
    let row = find(api, batch_id).await?;
    let account = api.store.batch_accounts(std::slice::from_ref(&row)).await?.pop().unwrap_or_default();
    Ok(BatchView::new(row, account))
}

/// A batch that is there.
async fn find(api: &TenantApi, batch_id: &BatchId) -> Result<BatchRow, Problem> {
    match api.store.batch(&api.tenant_id, batch_id).await? {
        Some(batch) if batch.is_deleted => Err(gone("batch_deleted", "batch", "submit its requests again")),
        Some(batch) => Ok(batch),
        None => Err(Problem::not_found("batch", batch_id.as_str())),
    }
}
