//! Deletion of a resource, as its client sees it.

use std::fmt::Display;

use axum::http::StatusCode;

use super::extract::ResourceId;
use crate::problem::{Problem, ProblemType};
use store::deletion::DeleteOutcome;

/// 204, also for what was deleted before; 404 for what there is not.
pub fn answer<T: ResourceId + Display>(outcome: DeleteOutcome, id: &T) -> Result<StatusCode, Problem> {
    match outcome {
        DeleteOutcome::Done => Ok(StatusCode::NO_CONTENT),
        DeleteOutcome::NotFound => Err(Problem::not_found(T::NAME, &id.to_string())),
    }
}

/// 410: it was deleted, and its last rows are still there.
pub fn gone(code: &'static str, what: &str, correction: &str) -> Problem {
    Problem::new(ProblemType::Gone, code, format!("this {what} was deleted; {correction}"))
}
