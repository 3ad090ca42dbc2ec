//! Failures of calls: a kind with a stable code, which decides retry, billing and the error of the port.

use ports::BAD_ANSWER;
use std::time::Duration;

use serde_json::Value;

use http_client::{HttpResponse, SendError};
use ports::ledger::OUTCOME_UNKNOWN;
use ports::{Port, ProviderError};

/// The kind of a failure. It has a stable code and decides the consequences.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum FailureKind {
    /// The address policy forbids the address.
    AddressRefused,
    /// No connection; nothing was sent.
    Unreachable,
    /// The request was sent, and no response came before the deadline.
    TimedOut,
    /// The request was sent, and the connection broke before the response was complete.
    ConnectionLost,
    /// 5xx and the like.
    ServerError,
    /// 429: too many calls.
    Busy,
    /// 429 or 402: the account's credit is used up.
    QuotaSpent,
    /// 401 or 403.
    Denied,
    /// 404: the path or the model does not exist.
    NotFound,
    /// Another 4xx: the request is malformed or not allowed.
    RequestRejected,
    /// 3xx that is not followed.
    Redirected,
    /// A malformed response: another content type, broken JSON, or another shape.
    BadAnswer,
    AnswerTooLarge,
    /// The answer ends at the length limit.
    Truncated,
    /// The model refuses.
    Refused,
    /// The vendor's filter cut off the answer.
    Filtered,
    /// The replayed recording does not hold this request.
    NotRecorded,
    /// The response could not be recorded.
    NotKept,
}

/// Billing of a call by the vendor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Billed {
    No,
    /// The vendor answered; the response states the cost.
    Yes,
    /// No response, so the vendor may have processed the request.
    Unknown,
}

/// A failure of one attempt.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Failure {
    pub kind: FailureKind,
    /// Explanation without secrets.
    pub reason: String,
    /// The pause that the server requests.
    pub retry_after: Option<Duration>,
}

impl FailureKind {
    pub const ALL: [Self; 18] = [
        Self::AddressRefused,
        Self::Unreachable,
        Self::TimedOut,
        Self::ConnectionLost,
        Self::ServerError,
        Self::Busy,
        Self::QuotaSpent,
        Self::Denied,
        Self::NotFound,
        Self::RequestRejected,
        Self::Redirected,
        Self::BadAnswer,
        Self::AnswerTooLarge,
        Self::Truncated,
        Self::Refused,
        Self::Filtered,
        Self::NotRecorded,
        Self::NotKept,
    ];

    /// The stable error code.
    pub fn code(self) -> &'static str {
        match self {
            Self::AddressRefused => "provider_address_refused",
            Self::Unreachable => "provider_unreachable",
            Self::TimedOut => "provider_timeout",
            Self::ConnectionLost => "provider_connection_lost",
            Self::ServerError => "provider_server_error",
            Self::Busy => "provider_busy",
            Self::QuotaSpent => "provider_quota_spent",
            Self::Denied => "provider_denied",
            Self::NotFound => "provider_not_found",
            Self::RequestRejected => "provider_rejected_request",
            Self::Redirected => "provider_redirected",
            Self::BadAnswer => BAD_ANSWER,
            Self::AnswerTooLarge => "provider_answer_too_large",
            Self::Truncated => "answer_truncated",
            Self::Refused => "answer_refused",
            Self::Filtered => "answer_filtered",
            Self::NotRecorded => "provider_not_recorded",
            Self::NotKept => "provider_not_kept",
        }
    }

    /// The outcome in the ledger.
    pub fn outcome(self) -> &'static str {
        match self.billed() {
            Billed::Unknown => OUTCOME_UNKNOWN,
            Billed::Yes | Billed::No => self.code(),
        }
    }

    /// Whether a retry may succeed.
    pub fn may_pass(self) -> bool {
        matches!(
            self,
            Self::Unreachable
                | Self::TimedOut
                | Self::ConnectionLost
                | Self::ServerError
                | Self::Busy
                | Self::BadAnswer
        )
    }

    /// Whether the failure counts against the circuit breaker of the endpoint.
    pub fn blames_endpoint(self) -> bool {
        matches!(
            self,
            Self::Unreachable | Self::TimedOut | Self::ConnectionLost | Self::ServerError | Self::BadAnswer
        )
    }

    /// Billing of the call by the vendor. Vendors bill answers including refusals; they do not bill rejected requests
    /// or their own errors.
    pub fn billed(self) -> Billed {
        match self {
            Self::TimedOut | Self::ConnectionLost => Billed::Unknown,
            Self::BadAnswer
            | Self::AnswerTooLarge
            | Self::Truncated
            | Self::Refused
            | Self::Filtered
            | Self::NotKept => Billed::Yes,
            Self::AddressRefused
            | Self::Unreachable
            | Self::ServerError
            | Self::Busy
            | Self::QuotaSpent
            | Self::Denied
            | Self::NotFound
            | Self::RequestRejected
            | Self::Redirected
            | Self::NotRecorded => Billed::No,
        }
    }
}

impl Failure {
    pub fn new(kind: FailureKind, reason: impl Into<String>) -> Self {
        Self { kind, reason: reason.into(), retry_after: None }
    }

    /// The failure of a request without a response.
    pub fn of_send(error: &SendError) -> Self {
        let kind = match error {
            SendError::Address(_) => FailureKind::AddressRefused,
            SendError::Unreachable(_) => FailureKind::Unreachable,
            SendError::Lost(_) => FailureKind::ConnectionLost,
            SendError::TooLarge { .. } => FailureKind::AnswerTooLarge,
            SendError::Redirected(_) => FailureKind::Redirected,
            SendError::NotRecorded(_) => FailureKind::NotRecorded,
            SendError::NotKept(_) => FailureKind::NotKept,
        };
        Self::new(kind, error.to_string())
    }

    /// The failure of a response by its status; `None` for a success.
    pub fn of_status(reply: &HttpResponse) -> Option<Self> {
        let text = text(reply);
        let kind = match reply.status {
            200..=299 => return None,
            401 | 403 => FailureKind::Denied,
            402 => FailureKind::QuotaSpent,
            404 | 405 | 410 => FailureKind::NotFound,
            408 | 425 => FailureKind::ServerError,
            // A gateway lost the answer of the server behind it, or did not wait for it; that one may have worked.
            502 | 520 => FailureKind::ConnectionLost,
            504 | 524 => FailureKind::TimedOut,
            // OpenAI says both with the same status.
            429 if text.code.as_deref() == Some("insufficient_quota") => FailureKind::QuotaSpent,
            429 => FailureKind::Busy,
            300..=399 => FailureKind::Redirected,
            // OpenAI's filter before and behind its image models.
            400 if matches!(
                text.code.as_deref(),
                Some("moderation_blocked" | "content_policy_violation")
            ) =>
            {
                FailureKind::Refused
            }
            // Ark's, before and behind its image models.
            400 if text.code.as_deref().is_some_and(|code| code.contains("SensitiveContent")) => {
                FailureKind::Refused
            }
            400..=499 => FailureKind::RequestRejected,
            _ => FailureKind::ServerError,
        };
        let reason = match text.message {
            Some(message) => format!("status {}: {message}", reply.status),
            None => format!("status {}", reply.status),
        };
        Some(Self { kind, reason, retry_after: reply.retry_after })
    }

    /// The error of the port.
    pub fn into_error(self, port: Port, provider: &str) -> ProviderError {
        let code = self.kind.code();
        let reason = format!("{provider}: {}", self.reason);
        match self.kind {
            FailureKind::Busy => ProviderError::RateLimited { port, retry_after: self.retry_after },
            FailureKind::Unreachable
            | FailureKind::TimedOut
            | FailureKind::ConnectionLost
            | FailureKind::ServerError
            | FailureKind::BadAnswer
            | FailureKind::AnswerTooLarge => ProviderError::Transient { port, code, reason },
            FailureKind::AddressRefused
            | FailureKind::QuotaSpent
            | FailureKind::Denied
            | FailureKind::NotFound
            | FailureKind::Redirected => ProviderError::Misconfigured { port, code, reason },
            // No fallback to another provider: the replayed or recorded scene would differ.
            FailureKind::NotRecorded | FailureKind::NotKept => ProviderError::Rejected { port, code, reason },
            FailureKind::RequestRejected | FailureKind::Truncated => {
                ProviderError::Rejected { port, code, reason }
            }
            FailureKind::Refused | FailureKind::Filtered => ProviderError::Refused { port, code, reason },
        }
    }
}

/// The error in a response body, in the shapes that vendors use.
struct Message {
    code: Option<String>,
    /// Short, on one line.
    message: Option<String>,
}

fn text(reply: &HttpResponse) -> Message {
    let body: Value = serde_json::from_slice(&reply.body).unwrap_or(Value::Null);
    let error = body.get("error").unwrap_or(&body);
    let text = |value: Option<&Value>| value.and_then(Value::as_str).map(one_line);
    let message =
        text(error.get("message")).or_else(|| text(Some(error))).or_else(|| text(body.get("detail")));
    Message { code: text(error.get("code")), message: message.filter(|message| !message.is_empty()) }
}

/// The first 300 characters without control characters.
pub(super) fn one_line(text: &str) -> String {
    let plain = text.chars().map(|c| if c.is_control() { ' ' } else { c });
    plain.take(300).collect::<String>().trim().to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;
    use bytes::Bytes;

    fn reply(status: u16, body: &str) -> HttpResponse {
        let body = Bytes::copy_from_slice(body.as_bytes());
        HttpResponse { status, content_type: "application/json".into(), retry_after: None, body }
    }

    #[test]
    fn of_status_classifies_every_status() {
        let kind = |status, body: &str| Failure::of_status(&reply(status, body)).map(|failure| failure.kind);
        assert_eq!(kind(200, "{}"), None);
        for (status, expected) in [
            (301, FailureKind::Redirected),
            (400, FailureKind::RequestRejected),
            (401, FailureKind::Denied),
            (402, FailureKind::QuotaSpent),
            (403, FailureKind::Denied),
            (404, FailureKind::NotFound),
            (408, FailureKind::ServerError),
            (413, FailureKind::RequestRejected),
            (422, FailureKind::RequestRejected),
            (429, FailureKind::Busy),
            (500, FailureKind::ServerError),
            (502, FailureKind::ConnectionLost),
            (504, FailureKind::TimedOut),
            (503, FailureKind::ServerError),
            (529, FailureKind::ServerError),
        ] {
            assert_eq!(kind(status, "<html>"), Some(expected), "{status}");
        }
    }

    #[test]
    fn reasons_quote_the_vendor_briefly() {
        // The error OpenAI documents for an account without credit.
        let spent = r#"{"error": {"message": "You exceeded your current quota, please check your plan and billing details.",
            "type": "insufficient_quota", "param": null, "code": "insufficient_quota"}}"#;
        let failure = Failure::of_status(&reply(429, spent)).expect("is a failure");
        assert_eq!(failure.kind, FailureKind::QuotaSpent);
        assert!(failure.reason.starts_with("status 429: You exceeded your current quota"));
        let long = format!(r#"{{"error": {{"message": "a\nb{}"}}}}"#, "c".repeat(10_000));
        let failure = Failure::of_status(&reply(500, &long)).expect("is a failure");
        assert!(failure.reason.starts_with("status 500: a bccc") && failure.reason.len() < 330);
        // FastAPI's shape.
        let failure = Failure::of_status(&reply(500, r#"{"detail": "no GPU"}"#)).expect("is a failure");
        assert_eq!(failure.reason, "status 500: no GPU");
    }

    #[test]
    fn content_filters_are_refusals() {
        let blocked = r#"{"error": {"message": "Your request was rejected by the safety system.",
            "type": "image_generation_user_error", "param": null, "code": "moderation_blocked"}}"#;
        let failure = Failure::of_status(&reply(400, blocked)).expect("is a failure");
        assert_eq!(failure.kind, FailureKind::Refused);
        let arks = blocked.replace("moderation_blocked", "InputTextSensitiveContentDetected");
        let failure = Failure::of_status(&reply(400, &arks)).expect("is a failure");
        assert_eq!(failure.kind, FailureKind::Refused);
        let other = blocked.replace("moderation_blocked", "invalid_value");
        let failure = Failure::of_status(&reply(400, &other)).expect("is a failure");
        assert_eq!(failure.kind, FailureKind::RequestRejected);
    }

    #[test]
    fn codes_are_distinct_and_what_is_not_billed_is_known() {
        let codes: std::collections::BTreeSet<&str> =
            FailureKind::ALL.iter().map(|kind| kind.code()).collect();
        assert_eq!(codes.len(), FailureKind::ALL.len());
        for code in codes {
            assert!(code.bytes().all(|b| b.is_ascii_lowercase() || b == b'_'), "{code}");
        }
        for kind in FailureKind::ALL {
            // A lost answer must never count as free.
            let lost = matches!(kind, FailureKind::TimedOut | FailureKind::ConnectionLost);
            assert_eq!(kind.billed() == Billed::Unknown, lost, "{kind:?}");
        }
    }
}
