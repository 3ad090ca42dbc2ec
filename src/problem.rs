//! Refusals of requests as RFC 9457 problem documents, for every caller: the interface sends them, the command line
//! prints them, a job that is refused keeps code and message.
//!
//! `type` comes from a closed list, `code` is stable and finer, `detail` says what to change, `errors` points into the
//! request.

use std::borrow::Cow;
use std::fmt;

use crate::path_without_keys::path_without_keys;
use crate::schemas::values::Code;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::Serialize;
use serde_json::{Value, json};

/// The closed list of problem types; each has one status.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ProblemType {
    /// 400: the request cannot be read.
    MalformedRequest,
    /// 422: it can be read, and a value in it will not do.
    InvalidRequest,
    /// 401: this needs a credential, or the one that was sent opens nothing.
    Unauthorized,
    /// 403: this sender may not ask for this.
    Forbidden,
    NotFound,
    MethodNotAllowed,
    RequestTimeout,
    /// 409: not in this state.
    Conflict,
    Gone,
    /// 412: not in the state that the sender has read.
    PreconditionFailed,
    PayloadTooLarge,
    UnsupportedMediaType,
    RangeNotSatisfiable,
    /// 421: the host is not one of this server.
    Misdirected,
    /// 429: one client asks for more than its share.
    TooManyRequests,
    Internal,
    Unavailable,
    /// 507: the bytes of a tenant leave no room.
    InsufficientStorage,
}

impl ProblemType {
    pub const ALL: [Self; 18] = [
        Self::MalformedRequest,
        Self::InvalidRequest,
        Self::Unauthorized,
        Self::Forbidden,
        Self::NotFound,
        Self::MethodNotAllowed,
        Self::RequestTimeout,
        Self::Conflict,
        Self::Gone,
        Self::PreconditionFailed,
        Self::PayloadTooLarge,
        Self::UnsupportedMediaType,
        Self::RangeNotSatisfiable,
        Self::Misdirected,
        Self::TooManyRequests,
        Self::Internal,
        Self::Unavailable,
        Self::InsufficientStorage,
    ];

    /// Status and reason phrase (RFC 9110, section 15), and the name in the type's URI.
    fn facts(self) -> (u16, &'static str, &'static str) {
        match self {
            Self::MalformedRequest => (400, "Bad Request", "malformed-request"),
            Self::InvalidRequest => (422, "Unprocessable Entity", "invalid-request"),
            Self::Unauthorized => (401, "Unauthorized", "unauthorized"),
            Self::Forbidden => (403, "Forbidden", "forbidden"),
            Self::NotFound => (404, "Not Found", "not-found"),
            Self::MethodNotAllowed => (405, "Method Not Allowed", "method-not-allowed"),
            Self::RequestTimeout => (408, "Request Timeout", "request-timeout"),
            Self::Conflict => (409, "Conflict", "conflict"),
            Self::Gone => (410, "Gone", "gone"),
            Self::PreconditionFailed => (412, "Precondition Failed", "precondition-failed"),
            Self::PayloadTooLarge => (413, "Payload Too Large", "payload-too-large"),
            Self::UnsupportedMediaType => (415, "Unsupported Media Type", "unsupported-media-type"),
            Self::RangeNotSatisfiable => (416, "Range Not Satisfiable", "range-not-satisfiable"),
            Self::Misdirected => (421, "Misdirected Request", "misdirected-request"),
            Self::TooManyRequests => (429, "Too Many Requests", "too-many-requests"),
            Self::Internal => (500, "Internal Server Error", "internal"),
            Self::Unavailable => (503, "Service Unavailable", "unavailable"),
            Self::InsufficientStorage => (507, "Insufficient Storage", "insufficient-storage"),
        }
    }

    pub fn status(self) -> u16 {
        self.facts().0
    }

    /// The standard reason phrase of the status.
    pub fn title(self) -> &'static str {
        self.facts().1
    }

    /// `urn:tabletopgen:problem:<name>`.
    pub fn uri(self) -> String {
        format!("urn:tabletopgen:problem:{}", self.facts().2)
    }
}

/// Place in a request, and the fault there.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, JsonSchema)]
pub struct FieldError {
    /// A JSON pointer into the body.
    pub pointer: String,
    pub detail: String,
}

impl FieldError {
    pub fn new(pointer: impl Into<String>, detail: impl Into<String>) -> Self {
        Self { pointer: pointer.into(), detail: detail.into() }
    }
}

/// A refusal (RFC 9457).
#[derive(Debug, Serialize, JsonSchema)]
#[schemars(rename = "Problem")]
pub struct ProblemDocument<'a> {
    #[serde(rename = "type")]
    #[schemars(with = "ProblemType")]
    kind: String,
    /// The reason phrase of the status.
    title: &'static str,
    #[schemars(range(min = 400, max = 599))]
    status: u16,
    #[schemars(with = "Code")]
    code: &'a str,
    /// Correction.
    detail: &'a str,
    request_id: &'a str,
    #[serde(skip_serializing_if = "<[_]>::is_empty")]
    errors: &'a [FieldError],
    /// The limit that leaves no room, where that is the reason.
    #[serde(skip_serializing_if = "Option::is_none")]
    limit: Option<&'a LimitUse>,
}

/// A limit, and what is used of it.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct LimitUse {
    /// The setting of the server, such as `store.limits.waiting_jobs`.
    #[schemars(length(min = 1, max = 100))]
    pub name: Cow<'static, str>,
    /// Value of the limit for this tenant: bytes, jobs, submissions, requests or US dollars, as the setting has it.
    #[schemars(range(min = 0.0, max = 9007199254740991.0))]
    pub max: f64,
    /// Amount that is used of it, without what was asked for.
    #[schemars(range(min = 0.0, max = 9007199254740991.0))]
    pub used: f64,
}

impl JsonSchema for ProblemType {
    fn schema_name() -> Cow<'static, str> {
        "ProblemType".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        let uris: Vec<String> = Self::ALL.iter().map(|kind| kind.uri()).collect();
        json_schema!({ "description": "Type of a problem; each has one status.", "type": "string", "enum": uris })
    }
}

/// A refusal of a request.
#[derive(Clone, Debug)]
pub struct Problem {
    pub kind: ProblemType,
    /// Stable, `[a-z0-9_]+`.
    pub code: Cow<'static, str>,
    /// Fault and correction.
    pub detail: String,
    pub errors: Vec<FieldError>,
    /// The limit that leaves no room, where that is the reason.
    pub limit: Option<Box<LimitUse>>,
    /// Time after which the request may be sent again, seconds, where it is known.
    pub retry_after_secs: Option<i64>,
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message())
    }
}

impl std::error::Error for Problem {}

impl Problem {
    pub fn new(kind: ProblemType, code: &'static str, detail: impl Into<String>) -> Self {
        Self {
            kind,
            code: Cow::Borrowed(code),
            detail: detail.into(),
            errors: Vec::new(),
            limit: None,
            retry_after_secs: None,
        }
    }

    /// A body that can be read but not accepted.
    pub fn invalid(errors: Vec<FieldError>) -> Self {
        let place = |error: &FieldError| match error.pointer.as_str() {
            "" => "the body".to_owned(),
            pointer => pointer.to_owned(),
        };
        let places: Vec<String> = errors.iter().map(place).collect();
        let detail = format!("correct {} and send it again", places.join(", "));
        Self { errors, ..Self::new(ProblemType::InvalidRequest, "invalid_body", detail) }
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

    /// The idempotency key of a request belongs to another one; `what` is what either makes.
    pub fn key_reused(what: &str) -> Self {
        Self::new(
            ProblemType::InvalidRequest,
            "idempotency_key_reused",
            format!("this Idempotency-Key came with another body before; use a new key for a new {what}"),
        )
    }

    /// 412 for a resource whose ETag is no longer that of the header `If-Match`.
    pub fn no_longer_matches(what: &str, code: &'static str) -> Self {
        let detail = format!(
            "this {what} is no longer as the If-Match header says; get it again, and send the change with its new ETag"
        );
        Self::new(ProblemType::PreconditionFailed, code, detail)
    }

    pub fn not_found(what: &str, id: &str) -> Self {
        let shown: String = path_without_keys(id).chars().take(80).collect();
        Self::new(ProblemType::NotFound, "not_found", format!("there is no {what} {shown:?}"))
    }

    /// The document, with the id of the request it answers.
    pub fn document(&self, request_id: &str) -> Value {
        json!(ProblemDocument {
            kind: self.kind.uri(),
            title: self.kind.title(),
            status: self.kind.status(),
            code: &self.code,
            detail: &self.detail,
            request_id,
            errors: &self.errors,
            limit: self.limit.as_deref(),
        })
    }
}
