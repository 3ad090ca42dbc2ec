//! Refusals as RFC 9457 problem documents.
//!
//! `type` comes from a closed list, `code` is stable and finer, `detail` says what to change, `errors`
//! points into the body. The request id is added on the way out (see `layers`).

use std::borrow::Cow;

use axum::http::{StatusCode, Uri, header};
use axum::response::{IntoResponse, Response};
use serde::Serialize;
use serde_json::json;

use store::{Outage, StoreError};

/// The closed list of problem types; each has one status.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ProblemType {
    /// 400: the request cannot be read.
    MalformedRequest,
    /// 422: it can be read, and a value in it will not do.
    InvalidRequest,
    /// 403: this sender may not ask for this.
    Forbidden,
    NotFound,
    MethodNotAllowed,
    RequestTimeout,
    /// 409: not in this state.
    Conflict,
    Gone,
    PayloadTooLarge,
    UnsupportedMediaType,
    RangeNotSatisfiable,
    /// 421: the host is not one of this server.
    Misdirected,
    /// 429: one client asks for more than its share.
    TooManyRequests,
    Internal,
    Unavailable,
    /// 507: a tenant's quota leaves no room.
    InsufficientStorage,
}

impl ProblemType {
    pub const ALL: [Self; 16] = [
        Self::MalformedRequest,
        Self::InvalidRequest,
        Self::Forbidden,
        Self::NotFound,
        Self::MethodNotAllowed,
        Self::RequestTimeout,
        Self::Conflict,
        Self::Gone,
        Self::PayloadTooLarge,
        Self::UnsupportedMediaType,
        Self::RangeNotSatisfiable,
        Self::Misdirected,
        Self::TooManyRequests,
        Self::Internal,
        Self::Unavailable,
        Self::InsufficientStorage,
    ];

    /// The HTTP status, and the name in the type's URI.
    fn facts(self) -> (StatusCode, &'static str) {
        match self {
            Self::MalformedRequest => (StatusCode::BAD_REQUEST, "malformed-request"),
            Self::InvalidRequest => (StatusCode::UNPROCESSABLE_ENTITY, "invalid-request"),
            Self::Forbidden => (StatusCode::FORBIDDEN, "forbidden"),
            Self::NotFound => (StatusCode::NOT_FOUND, "not-found"),
            Self::MethodNotAllowed => (StatusCode::METHOD_NOT_ALLOWED, "method-not-allowed"),
            Self::RequestTimeout => (StatusCode::REQUEST_TIMEOUT, "request-timeout"),
            Self::Conflict => (StatusCode::CONFLICT, "conflict"),
            Self::Gone => (StatusCode::GONE, "gone"),
            Self::PayloadTooLarge => (StatusCode::PAYLOAD_TOO_LARGE, "payload-too-large"),
            Self::UnsupportedMediaType => (StatusCode::UNSUPPORTED_MEDIA_TYPE, "unsupported-media-type"),
            Self::RangeNotSatisfiable => (StatusCode::RANGE_NOT_SATISFIABLE, "range-not-satisfiable"),
            Self::Misdirected => (StatusCode::MISDIRECTED_REQUEST, "misdirected-request"),
            Self::TooManyRequests => (StatusCode::TOO_MANY_REQUESTS, "too-many-requests"),
            Self::Internal => (StatusCode::INTERNAL_SERVER_ERROR, "internal"),
            Self::Unavailable => (StatusCode::SERVICE_UNAVAILABLE, "unavailable"),
            Self::InsufficientStorage => (StatusCode::INSUFFICIENT_STORAGE, "insufficient-storage"),
        }
    }

    /// The standard reason phrase of the status (RFC 9110).
    pub fn title(self) -> &'static str {
        self.facts().0.canonical_reason().unwrap_or("Error")
    }

    pub fn status(self) -> StatusCode {
        self.facts().0
    }

    /// `urn:tabletopgen:problem:<name>`.
    pub fn uri(self) -> String {
        format!("urn:tabletopgen:problem:{}", self.facts().1)
    }
}

/// Place in the body, and the fault there.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct FieldError {
    /// JSON pointer, such as `/options/table/size_m`.
    pub pointer: String,
    pub detail: String,
}

impl FieldError {
    pub fn new(pointer: impl Into<String>, detail: impl Into<String>) -> Self {
        Self { pointer: pointer.into(), detail: detail.into() }
    }
}

/// A refusal. Handlers return it as their error.
#[derive(Clone, Debug)]
pub struct Problem {
    pub kind: ProblemType,
    /// Stable, `[a-z0-9_]+`.
    pub code: Cow<'static, str>,
    /// Fault and correction.
    pub detail: String,
    pub errors: Vec<FieldError>,
}

impl Problem {
    pub fn new(kind: ProblemType, code: &'static str, detail: impl Into<String>) -> Self {
        Self { kind, code: Cow::Borrowed(code), detail: detail.into(), errors: Vec::new() }
    }

    /// A body that can be read but not accepted.
    pub fn invalid(errors: Vec<FieldError>) -> Self {
        let place = |error: &FieldError| match error.pointer.as_str() {
            "" => "the body".to_owned(),
            pointer => pointer.to_owned(),
        };
        let places: Vec<String> = errors.iter().map(place).collect();
        let detail = format!("correct {} and send it again", places.join(", "));
        Self { kind: ProblemType::InvalidRequest, code: Cow::Borrowed("invalid_body"), detail, errors }
    }

    /// The code, if this process made the problem; `failed` of one that was stored.
    pub fn own_code(&self) -> &'static str {
        match self.code {
            Cow::Borrowed(code) => code,
            Cow::Owned(_) => "failed",
        }
    }

    /// Fault and correction in one sentence, with the places in the body.
    pub fn message(&self) -> String {
        let errors: Vec<String> =
            self.errors.iter().map(|error| format!("{} {}", error.pointer, error.detail)).collect();
        if errors.is_empty() { self.detail.clone() } else { errors.join("; ") }
    }

    /// Nothing new can be stored.
    pub fn storage_full() -> Self {
        Self::new(
            ProblemType::Unavailable,
            "storage_full",
            "the server's disk is full; nothing was enqueued. Send it again when its operator has freed space",
        )
    }

    /// The tenant's scenes have as many bytes as they may.
    pub fn quota_exceeded(used_bytes: u64, quota_bytes: u64) -> Self {
        Self::new(
            ProblemType::InsufficientStorage,
            "quota_exceeded",
            format!(
                "your scenes use {used_bytes} of {quota_bytes} bytes; delete scenes that you no longer need"
            ),
        )
    }

    pub fn not_found(what: &str, id: &str) -> Self {
        let shown: String = id.chars().take(80).collect();
        Self::new(ProblemType::NotFound, "not_found", format!("there is no {what} {shown:?}"))
    }

    /// The document, with the id of the request it answers.
    pub fn document(&self, request_id: &str) -> serde_json::Value {
        let (status, title) = (self.kind.status(), self.kind.title());
        let mut document = json!({
            "type": self.kind.uri(),
            "title": title,
            "status": status.as_u16(),
            "code": self.code,
            "detail": self.detail,
            "request_id": request_id,
        });
        if !self.errors.is_empty() {
            document["errors"] = json!(self.errors);
        }
        document
    }
}

impl IntoResponse for Problem {
    /// The body is written by the outermost layer, which knows the request id.
    fn into_response(self) -> Response {
        let mut response = self.kind.status().into_response();
        if matches!(self.kind, ProblemType::Unavailable | ProblemType::TooManyRequests) {
            response.headers_mut().insert(header::RETRY_AFTER, header::HeaderValue::from_static("5"));
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
    let path: String = uri.path().chars().take(80).collect();
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
