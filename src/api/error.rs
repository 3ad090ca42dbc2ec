//! Problems as responses. The body is written by the outermost layer, which knows the request id (see `layers`).

use axum::http::{StatusCode, Uri, header};
use axum::response::{IntoResponse, Response};

use super::body::ENCODED_BODY;
use crate::path_without_keys::path_without_keys;
use crate::problem::{Problem, ProblemType};
use store::{Outage, StoreError};

/// Time after which a request may be sent again where nothing better is known, seconds.
const USUAL_RETRY_AFTER_SECS: i64 = 5;

impl IntoResponse for Problem {
    fn into_response(self) -> Response {
        let status = StatusCode::from_u16(self.kind.status()).unwrap_or(StatusCode::INTERNAL_SERVER_ERROR);
        let mut response = status.into_response();
        if matches!(self.kind, ProblemType::Unavailable | ProblemType::TooManyRequests)
            || self.retry_after_secs.is_some()
        {
            let seconds = self.retry_after_secs.unwrap_or(USUAL_RETRY_AFTER_SECS);
            response.headers_mut().insert(header::RETRY_AFTER, header::HeaderValue::from(seconds));
        }
        if self.code == ENCODED_BODY {
            let plain = header::HeaderValue::from_static("identity");
            response.headers_mut().insert(header::ACCEPT_ENCODING, plain);
        }
        if self.code == ENCODED_BODY {
            let plain = header::HeaderValue::from_static("identity");
            response.headers_mut().insert(header::ACCEPT_ENCODING, plain);
        }
        if self.kind == ProblemType::Unauthorized {
            response
                .headers_mut()
                .insert(header::WWW_AUTHENTICATE, header::HeaderValue::from_static("Bearer"));
        }
        response.extensions_mut().insert(self);
        response
    }
}

impl From<StoreError> for Problem {
    fn from(error: StoreError) -> Self {
        // The store itself reports outages, once.
        match error.outage() {
            Some(_) => tracing::debug!(error = error.chain(), "the store failed a request"),
            None => tracing::error!(error = error.chain(), "the store failed a request"),
        }
        match error {
            _ if error.outage() == Some(Outage::Full) => Self::storage_full(),
            StoreError::Corrupt { .. } | StoreError::InvalidDigest(_) | StoreError::BlobDamaged { .. } => {
                Self::new(
                    ProblemType::Internal,
                    "stored_data_unreadable",
                    "stored data cannot be read; the log has the details under this request id",
                )
            }
            _ => Self::new(
                ProblemType::Unavailable,
                "store_unavailable",
                "the store does not answer; send the request again in a few seconds",
            ),
        }
    }
}

/// Fallback for unknown paths.
pub async fn no_such_route(uri: Uri) -> Problem {
    let path: String = path_without_keys(uri.path()).chars().take(80).collect();
    Problem::new(
        ProblemType::NotFound,
        "no_such_route",
        format!("there is nothing at {path:?}; /openapi.yaml lists every path"),
    )
}

/// Fallback for known paths with another method.
pub async fn method_not_allowed() -> Problem {
    Problem::new(
        ProblemType::MethodNotAllowed,
        "method_not_allowed",
        "this path does not take that method; the Allow header and /openapi.yaml say which it takes",
    )
}
