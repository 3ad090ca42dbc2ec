//! How a call ends when it does not end well: a kind with a stable code, and what follows from it.

use ports::BAD_ANSWER;
use std::time::Duration;

use serde_json::Value;

use super::outbound::{Reply, SendError};
use ports::ledger::OUTCOME_UNKNOWN;
use ports::{Port, ProviderError};

/// What went wrong; each kind has a stable code and decides what is done about it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum FailureKind {
    /// The address is not one that may be talked to.
    AddressRefused,
    /// No connection; nothing was sent.
    Unreachable,
    /// Sent, and no answer came in time.
    TimedOut,
    /// Sent, and the connection broke before the answer was whole.
    ConnectionLost,
    /// 5xx and the like.
    ServerError,
    /// 429: too many calls.
    Busy,
    /// 429 or 402: the account's credit is used up.
    QuotaSpent,
    /// 401 or 403.
    Denied,
    /// 404: the path, or the model, is not there.
    NotFound,
    /// Another 4xx: what was asked is not understood or not allowed.
    RequestRejected,
    /// 3xx for something that is not followed.
    Redirected,
    /// An answer that is none: another content type, broken JSON, another shape.
    BadAnswer,
    AnswerTooLarge,
    /// The answer stops at the length limit.
    Truncated,
    /// The model says no.
    Refused,
    /// The vendor's filter cut the answer off.
    Filtered,
    /// A recording is played, and this was never asked when it was made.
    NotRecorded,
    /// The answer could not be recorded.
    NotKept,
}

/// Whether the vendor will ask money for it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Billed {
    No,
    /// It answered; the answer says how much.
    Yes,
    /// Nobody knows whether it did anything.
    Unknown,
}

/// A failure with what is known about it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Failure {
    pub kind: FailureKind,
    /// What happened, without secrets.
    pub reason: String,
    /// What the server asks for.
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

    /// Stable; the error's code.
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

    /// What the ledger calls it.
    pub fn outcome(self) -> &'static str {
        match self.billed() {
            Billed::Unknown => OUTCOME_UNKNOWN,
            Billed::Yes | Billed::No => self.code(),
        }
    }

    /// Whether the same call may go better in a moment.
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

    /// Whether it says that the endpoint is not well.
    pub fn is_the_endpoints(self) -> bool {
        matches!(
            self,
            Self::Unreachable | Self::TimedOut | Self::ConnectionLost | Self::ServerError | Self::BadAnswer
        )
    }

    /// Whether the vendor will ask money for it. Vendors bill answers, also those that say no; not what they refuse
    /// before they begin, nor their own errors.
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

    /// Of a send that brought nothing back.
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

    /// Of an answer whose status is no success; `None` where it is one.
    pub fn of_status(reply: &Reply) -> Option<Self> {
        let told = told(reply);
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
            429 if told.code.as_deref() == Some("insufficient_quota") => FailureKind::QuotaSpent,
            429 => FailureKind::Busy,
            300..=399 => FailureKind::Redirected,
            // OpenAI's filter before and behind its image models.
            400 if matches!(
                told.code.as_deref(),
                Some("moderation_blocked" | "content_policy_violation")
            ) =>
            {
                FailureKind::Refused
            }
            // Ark's, before and behind its image models.
            400 if told.code.as_deref().is_some_and(|code| code.contains("SensitiveContent")) => {
                FailureKind::Refused
            }
            400..=499 => FailureKind::RequestRejected,
            _ => FailureKind::ServerError,
        };
        let reason = match told.message {
            Some(message) => format!("status {}: {message}", reply.status),
            None => format!("status {}", reply.status),
        };
        Some(Self { kind, reason, retry_after: reply.retry_after })
    }

    /// What the port's caller is told.
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
            // Neither is for another provider to answer: what is played or recorded would be another scene.
            FailureKind::NotRecorded | FailureKind::NotKept => ProviderError::Rejected { port, code, reason },
            FailureKind::RequestRejected | FailureKind::Truncated => {
                ProviderError::Rejected { port, code, reason }
            }
            FailureKind::Refused | FailureKind::Filtered => ProviderError::Refused { port, code, reason },
        }
    }
}

/// What an error's body says, in the shapes vendors use.
struct Told {
    code: Option<String>,
    /// Short, on one line.
    message: Option<String>,
}

fn told(reply: &Reply) -> Told {
    let body: Value = serde_json::from_slice(&reply.body).unwrap_or(Value::Null);
    let error = body.get("error").unwrap_or(&body);
    let text = |value: Option<&Value>| value.and_then(Value::as_str).map(one_line);
    let message =
        text(error.get("message")).or_else(|| text(Some(error))).or_else(|| text(body.get("detail")));
    Told { code: text(error.get("code")), message: message.filter(|message| !message.is_empty()) }
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

    fn reply(status: u16, body: &str) -> Reply {
        let body = Bytes::copy_from_slice(body.as_bytes());
        Reply { status, content_type: "application/json".into(), retry_after: None, body }
    }

    #[test]
    fn every_status_has_its_kind() {
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
    fn vendors_words_are_passed_on_short() {
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
    fn a_filter_that_says_no_is_a_refusal() {
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
            // A lost answer must never look free.
            let lost = matches!(kind, FailureKind::TimedOut | FailureKind::ConnectionLost);
            assert_eq!(kind.billed() == Billed::Unknown, lost, "{kind:?}");
        }
    }
}
