//! Refusals by limits of a tenant: which limit, its value, what is used of it, and when to ask again.

use axum::response::{IntoResponse, Response};

use super::extract::TenantApi;
use crate::problem::{LimitUse, Problem, ProblemType};
use scene::MicroUsd;
use store::limits::{Limit, LimitReached};

/// Refuses work of a tenant that has as many bytes as it may.
///
/// # Errors
///
/// A [`Problem`] for such a tenant.
pub(super) async fn check_bytes(api: &TenantApi) -> Result<(), Problem> {
    match api.store.full_quota(&api.tenant_id).await {
        Some(reached) => Err(refused(reached)),
        None => Ok(()),
    }
}

/// The refusal by a limit, which is counted.
pub(super) fn refused(reached: LimitReached) -> Problem {
    let LimitReached { limit, max, used, retry_after_secs } = reached;
    metrics::counter!("tabletopgen_limits_refused_total", "limit" => limit.as_str()).increment(1);
    let (kind, code, detail) = match limit {
        Limit::Bytes => (
            ProblemType::InsufficientStorage,
            "quota_exceeded",
            format!(
                "your scenes, datasets, recordings and executions use {used} of {max} bytes; delete those that you no \
                 longer need"
            ),
        ),
        Limit::WaitingJobs => (
            ProblemType::TooManyRequests,
            "queue_full",
            format!(
                "{used} of your jobs wait, and {max} may; send the request again in {retry_after_secs} seconds"
            ),
        ),
        Limit::AllWaitingScenes => (
            ProblemType::TooManyRequests,
            "queue_full",
            format!(
                "{used} jobs of all clients wait, and {max} may; send the request again in {retry_after_secs} seconds"
            ),
        ),
        // Jobs that run hold others back; they refuse nothing.
        Limit::SubmissionsPerMinute | Limit::RunningJobs => (
            ProblemType::TooManyRequests,
            "rate_limit",
            format!(
                "you sent {used} submissions in a minute, and {max} are allowed; send the request again in \
                 {retry_after_secs} seconds"
            ),
        ),
        Limit::UsdPerMonth => (
            ProblemType::TooManyRequests,
            "spending_limit",
            format!(
                "your calls of remote models cost {} of the {} of this month; it ends in {retry_after_secs} seconds",
                MicroUsd(used),
                MicroUsd(max)
            ),
        ),
        Limit::BatchRequests => (
            ProblemType::TooManyRequests,
            "batch_requests_limit",
            format!(
                "{used} requests of your batches have not come to their end, and with these there would be more than \
                 {max}; send fewer, or send them when others have ended"
            ),
        ),
    };
    let number = |value: i64| match limit {
        Limit::UsdPerMonth => MicroUsd(value).usd(),
        _ => value as f64,
    };
    let used = LimitUse { name: limit.as_str().into(), max: number(max), used: number(used) };
    Problem {
        limit: Some(Box::new(used)),
        retry_after_secs: Some(retry_after_secs),
        ..Problem::new(kind, code, detail)
    }
}

/// [`refused`] as the whole answer.
pub(super) fn refusal(reached: LimitReached) -> Response {
    refused(reached).into_response()
}
