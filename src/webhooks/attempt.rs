//! One attempt at a delivery: a signed POST, the verdict on the answer, and the pause before the next attempt.

use std::sync::{Arc, OnceLock};
use std::time::{Duration, Instant, SystemTime};

use super::Settings;
use super::signature::signatures;
use http_client::retry::uniform;
use http_client::{AddressError, HttpClient, HttpRequest, HttpResponse, Method, SendError};
use store::Store;
use store::webhooks::{AttemptEnd, AttemptReport, DueDelivery};

/// Bytes of an answer that are read; the rest is cut off.
const MAX_ANSWER_BYTES: usize = 64 << 10;
/// Characters of an error that are kept.
const MAX_ERROR_CHARS: usize = 500;
/// Share by which a pause is longer or shorter than the settings say, so that messages that failed together do not all
/// come again together.
const JITTER: f64 = 0.2;

/// Sends messages; cloning shares the client.
#[derive(Clone)]
pub(super) struct Sender {
    pub(super) store: Store,
    pub(super) settings: Arc<Settings>,
    /// Made for the first message: a server that sends none needs no certificates.
    client: Arc<OnceLock<Option<HttpClient>>>,
}

/// Reason why an attempt failed; the owner of the webhook reads it.
#[derive(Debug, thiserror::Error)]
enum AttemptError {
    #[error("this server has no certificates to check addresses with; its operator has to install them")]
    NoClient,
    #[error(
        "the host has a private address, and the operator of this server does not name it in webhooks.hosts"
    )]
    Private,
    #[error(
        "the address is not https, and the operator of this server does not name its host in webhooks.hosts"
    )]
    NotHttps,
    #[error("{0}")]
    NotSent(#[source] SendError),
    #[error("no answer came within {timeout_secs} s")]
    TooSlow { timeout_secs: u64 },
    #[error("the address answered {status}; only 2xx accepts a message")]
    Refused { status: u16, retry_after: Option<Duration> },
}

impl Sender {
    pub(super) fn new(store: Store, settings: Settings) -> Self {
        Self { store, settings: Arc::new(settings), client: Arc::default() }
    }

    /// Sends a message once, and writes how that ended.
    pub(super) async fn attempt(self, due: DueDelivery) {
        let started = Instant::now();
        let answer = self.send(&due).await;
        let status = match &answer {
            Ok(status) | Err(AttemptError::Refused { status, .. }) => Some(*status),
            Err(_) => None,
        };
        let end = self.settings.end_of(&answer, due.attempt, uniform());
        let error = answer.err().map(|error| error.to_string().chars().take(MAX_ERROR_CHARS).collect());
        let report = AttemptReport { status, error, duration: started.elapsed(), end };
        let outcome = match report.end {
            AttemptEnd::Delivered => "delivered",
            AttemptEnd::RetryAfter(_) => "retried",
            AttemptEnd::Failed { .. } | AttemptEnd::Gone => "failed",
        };
        metrics::counter!("tabletopgen_webhook_attempts_total", "outcome" => outcome).increment(1);
        let (delivery, webhook, attempt) = (&due.id, &due.webhook_id, due.attempt);
        tracing::debug!(%delivery, %webhook, attempt, outcome, ?status, "sent an event to a webhook");
        match self.store.end_attempt(&due, report).await {
            Ok(true) => {}
            Ok(false) => {
                tracing::debug!(%delivery, "the webhook is gone, or another process sends this message")
            }
            Err(error) if error.outage().is_some() => {}
            Err(error) => {
                tracing::error!(error = error.chain(), %delivery, "cannot write how an attempt ended; it is sent again")
            }
        }
    }

    /// The status of a message that was accepted.
    async fn send(&self, due: &DueDelivery) -> Result<u16, AttemptError> {
        let client = || HttpClient::new(self.settings.addresses(), self.settings.timeout()).ok();
        let client = self.client.get_or_init(client).as_ref().ok_or(AttemptError::NoClient)?;
        let timestamp_s =
            SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).unwrap_or_default().as_secs();
        let signature = signatures(&due.secrets, due.id.as_str(), timestamp_s, &due.payload);
        let request = HttpRequest {
            method: Method::POST,
            url: due.url.clone(),
            headers: vec![("webhook-id".to_owned(), due.id.to_string())],
            transient_headers: vec![
                ("webhook-timestamp".to_owned(), timestamp_s.to_string()),
                ("webhook-signature".to_owned(), signature),
            ],
            bearer: None,
            content_type: "application/json".into(),
            body: due.payload.clone().into(),
        };
        let timeout_secs = self.settings.timeout_secs;
        let sent =
            tokio::time::timeout(self.settings.timeout(), client.send_and_cut(&request, MAX_ANSWER_BYTES));
        match sent.await.map_err(|_| AttemptError::TooSlow { timeout_secs })? {
            Ok(HttpResponse { status: status @ 200..=299, .. }) => Ok(status),
            Ok(HttpResponse { status, retry_after, .. }) => {
                Err(AttemptError::Refused { status, retry_after })
            }
            Err(SendError::Address(AddressError::Private { .. })) => Err(AttemptError::Private),
            Err(SendError::Address(AddressError::NotHttps(_))) => Err(AttemptError::NotHttps),
            Err(error) => Err(AttemptError::NotSent(error)),
        }
    }
}

impl Settings {
    /// Consequence of the answer to an attempt, counted from 1. `uniform` is drawn uniformly from 0..1.
    fn end_of(&self, answer: &Result<u16, AttemptError>, attempt: u64, uniform: f64) -> AttemptEnd {
        let asked = match answer {
            Ok(_) => return AttemptEnd::Delivered,
            Err(AttemptError::Refused { status: 410, .. }) => return AttemptEnd::Gone,
            // At most a day.
            Err(AttemptError::Refused { retry_after, .. }) => retry_after.unwrap_or_default(),
            Err(_) => Duration::ZERO,
        };
        let index = usize::try_from(attempt.saturating_sub(1)).unwrap_or(usize::MAX);
        match self.retry_secs.get(index) {
            Some(pause_secs) => {
                let pause_secs = pause_secs * (1.0 - JITTER + 2.0 * JITTER * uniform);
                AttemptEnd::RetryAfter(Duration::from_secs_f64(pause_secs.max(0.0)).max(asked))
            }
            None => AttemptEnd::Failed { max_failures: self.max_failures },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::{Sources, layers};

    fn settings() -> Settings {
        layers::load(Sources::default()).expect("the defaults are valid").config.webhooks
    }

    #[test]
    fn pauses_follow_the_settings_until_the_last_attempt() {
        let settings = settings();
        let failed = Err(AttemptError::TooSlow { timeout_secs: 15 });
        let pauses_secs: Vec<u64> = (1..20)
            .map_while(|attempt| match settings.end_of(&failed, attempt, 0.5) {
                AttemptEnd::RetryAfter(pause) => Some(pause.as_secs()),
                _ => None,
            })
            .collect();
        assert_eq!(pauses_secs, [5, 300, 1800, 7200, 18_000, 36_000, 50_400, 72_000, 86_400]);
        let max_failures = settings.max_failures;
        assert_eq!(settings.end_of(&failed, 10, 0.5), AttemptEnd::Failed { max_failures });
        let drawn = [0.0, 1.0].map(|uniform| settings.end_of(&failed, 2, uniform));
        assert_eq!(drawn, [240, 360].map(|secs| AttemptEnd::RetryAfter(Duration::from_secs(secs))));
    }

    #[test]
    fn answers_decide_what_becomes_of_a_delivery() {
        let settings = settings();
        let refused = |status, retry_after_secs: u64| {
            let retry_after = Some(Duration::from_secs(retry_after_secs));
            settings.end_of(&Err(AttemptError::Refused { status, retry_after }), 1, 0.5)
        };
        assert_eq!(settings.end_of(&Ok(204), 1, 0.5), AttemptEnd::Delivered);
        assert_eq!(refused(410, 0), AttemptEnd::Gone);
        assert_eq!(
            refused(503, 1),
            AttemptEnd::RetryAfter(Duration::from_secs(5)),
            "no sooner than the settings say"
        );
        assert_eq!(refused(429, 600), AttemptEnd::RetryAfter(Duration::from_secs(600)));
        let unreachable = Err(AttemptError::NotSent(SendError::Unreachable("refused".into())));
        assert_eq!(settings.end_of(&unreachable, 1, 0.5), AttemptEnd::RetryAfter(Duration::from_secs(5)));
    }
}
