//! `/batches`: submit, list, show, results, cancel, retry.
//!
//! A batch is stored with all its requests before the submission is answered ([`receive`]). Feeders then put them into
//! the queue a few at a time (see `store::batches`): one batch neither fills the queue nor keeps others waiting.

mod output;
mod parameters;
mod receive;
mod requests;
mod views;

use axum::Json;
use axum::extract::{Path, Request, State};
use axum::response::{IntoResponse, Response};
use serde::{Deserialize, Serialize};

use super::Api;
use super::accepted::accepted_at;
use super::enqueue::idempotency_key;
use super::error::{Problem, ProblemType};
use super::json_body::{json_bytes, media_type, parse};
use super::query::{Page, PageSize, PageToken, Parameters};
use ::batches::BatchState;
use scene::BatchId;
use store::DEFAULT_TENANT;
use store::batches::{BatchCancelOutcome, BatchFilter, BatchRetryOutcome, BatchRow};

pub use output::{errors, output};
use parameters::{BudgetUsd, SubmitParameters};
pub use requests::refused;
use views::BatchView;

/// `POST /batches`.
pub async fn submit(
    State(api): State<Api>,
    Parameters(parameters): Parameters<SubmitParameters>,
    request: Request,
) -> Result<Response, Problem> {
    let key = idempotency_key(request.headers())?;
    let id = receive::receive(&api, parameters, key, request).await?;
    accepted(&api, &id).await
}

/// Parameters of `GET /batches`.
#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ListParameters {
    state: Option<BatchState>,
    page_size: PageSize,
    page_token: Option<PageToken>,
}

/// A page of batches.
#[derive(Serialize)]
struct BatchPage {
    batches: Vec<BatchView>,
    next_page_token: Option<String>,
}

/// `GET /batches`.
pub async fn list(
    State(api): State<Api>,
    Parameters(parameters): Parameters<ListParameters>,
) -> Result<Response, Problem> {
    let size = parameters.page_size;
    let filter = BatchFilter {
        state: parameters.state,
        before_id: parameters.page_token.and_then(PageToken::last_id),
        limit: size.rows_to_read(),
    };
    let rows = api.store.batches(&DEFAULT_TENANT, filter).await?;
    let Page { rows, next_page_token } = size.page_of(rows, |batch| PageToken::after(batch.id.as_str()));
    let accounts = api.store.batch_accounts(&rows).await?;
    let batches = rows.into_iter().zip(accounts).map(|(row, account)| BatchView::new(row, account));
    let page = BatchPage { batches: batches.collect(), next_page_token };
    Ok(Json(page).into_response())
}

/// `GET /batches/{batch_id}`.
pub async fn show(State(api): State<Api>, Path(batch_id): Path<String>) -> Result<Response, Problem> {
    Ok(Json(view(&api, &parse_id(&batch_id)?).await?).into_response())
}

/// `POST /batches/{batch_id}/cancel`.
pub async fn cancel(State(api): State<Api>, Path(batch_id): Path<String>) -> Result<Response, Problem> {
    let batch_id = parse_id(&batch_id)?;
    match api.store.cancel_batch(&DEFAULT_TENANT, &batch_id).await? {
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
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
struct RetryBody {
    budget_usd: Option<BudgetUsd>,
}

/// `POST /batches/{batch_id}/retry`.
pub async fn retry(
    State(api): State<Api>,
    Path(batch_id): Path<String>,
    request: Request,
) -> Result<Response, Problem> {
    let batch_id = parse_id(&batch_id)?;
    let kind = media_type(request.headers());
    let bytes = json_bytes(&api, request.into_body()).await?;
    let body: RetryBody = match (bytes.is_empty(), kind.as_str()) {
        (true, _) => RetryBody::default(),
        (false, "application/json") => parse(&bytes)?,
        (false, _) => {
            return Err(Problem::new(
                ProblemType::UnsupportedMediaType,
                "body_format",
                "send application/json such as {\"budget_usd\": 10}, or no body",
            ));
        }
    };
    let budget = body.budget_usd.map(BudgetUsd::amount);
    let conflict = |code, detail| Err(Problem::new(ProblemType::Conflict, code, detail));
    match api.store.retry_batch(&DEFAULT_TENANT, &batch_id, budget).await? {
        BatchRetryOutcome::Accepted(_) => accepted(&api, &batch_id).await,
        BatchRetryOutcome::NothingToRetry => conflict(
            "nothing_to_retry",
            "no request of this batch has failed or was cancelled; quarantined ones want another seed",
        ),
        BatchRetryOutcome::StillCancelling => {
            conflict("batch_still_cancelling", "requests of this batch are still stopping; retry it then")
        }
        BatchRetryOutcome::NotFound => Err(Problem::not_found("batch", batch_id.as_str())),
    }
}

/// 202 with the batch and its address.
async fn accepted(api: &Api, batch_id: &BatchId) -> Result<Response, Problem> {
    let view = view(api, batch_id).await?;
    Ok(accepted_at(&view.links.this, &view))
}

async fn view(api: &Api, batch_id: &BatchId) -> Result<BatchView, Problem> {
    let row = find(api, batch_id).await?;
    let account = api.store.batch_accounts(std::slice::from_ref(&row)).await?.pop().unwrap_or_default();
    Ok(BatchView::new(row, account))
}

/// The batch id in a path. A text that is no id names no batch.
fn parse_id(text: &str) -> Result<BatchId, Problem> {
    text.parse().map_err(|_| Problem::not_found("batch", text))
}

/// A batch that is there.
async fn find(api: &Api, batch_id: &BatchId) -> Result<BatchRow, Problem> {
    let batch = api.store.batch(&DEFAULT_TENANT, batch_id).await?;
    batch.ok_or_else(|| Problem::not_found("batch", batch_id.as_str()))
}
