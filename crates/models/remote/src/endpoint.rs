//! One endpoint of one vendor.
//!
//! One call: rate limit, circuit breaker, ledger reservation, send with a deadline, retry with jitter, settlement. A
//! cancelled job ends the call.

mod auth;
mod polling;

pub use auth::Auth;

use std::borrow::Cow;
use std::time::{Duration, Instant};

use bytes::Bytes;
use sha2::{Digest as _, Sha256};
use tracing::field::Empty;
use tracing::{Instrument, Span};

use super::LimitSettings;
use super::failure::{Billed, Failure, FailureKind};
use http_client::circuit_breaker::CircuitBreaker;
use http_client::rate_limit::RateLimiter;
use http_client::retry::{full_jitter, uniform};
use http_client::{HttpClient, HttpRequest, HttpResponse, Method, Secret};
use ports::ledger::{ANSWERED, Entry, Intent, LedgerError, MicroUsd, OUTCOME_UNKNOWN, OnUnknown, Settlement};
use ports::{Call, Port, ProviderError};
use runtime::{CancelFlag, Cancelled};

/// Interval at which waits poll the cancel flag.
const POLL: Duration = Duration::from_millis(50);

/// An endpoint with the state that its calls share.
pub struct Endpoint {
    pub port: Port,
    /// The adapter's name (`openai/chat`).
    pub provider: String,
    pub model: String,
    pub base_url: String,
    pub key: Option<Secret>,
    /// Authentication of requests with the key.
    pub auth: Auth,
    /// The header of idempotency keys; empty where the vendor supports none.
    pub idempotency_header: String,
    pub limits: LimitSettings,
    pub on_unknown: OnUnknown,
    pub client: HttpClient,
    pub rate_limiter: RateLimiter,
    pub circuit_breaker: CircuitBreaker,
}

/// One question to an endpoint.
#[derive(Clone, Debug)]
pub struct Question {
    pub operation: &'static str,
    /// The path under the base URL, with its leading slash.
    pub path: &'static str,
    /// Names and values; part of the request digest.
    pub headers: Vec<(String, String)>,
    pub content_type: Cow<'static, str>,
    pub body: Bytes,
    /// Maximum cost of the answer.
    pub reserved: MicroUsd,
}

/// The values that an adapter reads from a response.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Reading<T> {
    /// `None` where the response does not state it; then the reservation counts.
    pub cost: Option<MicroUsd>,
    pub input_tokens: Option<u64>,
    pub output_tokens: Option<u64>,
    /// The vendor's id of the job that it started, where the result comes later.
    pub task: Option<String>,
    pub result: Result<T, Failure>,
}

/// The outcome of one attempt.
struct Attempt<T> {
    result: Result<T, Failure>,
    settlement: Settlement,
}

impl Endpoint {
    /// Asks until an answer comes, a failure is permanent, or the deadline passes.
    ///
    /// # Errors
    ///
    /// The last failure as a [`ProviderError`] of the port; also a refused reservation and a cancelled job.
    pub async fn ask<T>(
        &self,
        call: &Call,
        question: &Question,
        read: impl Fn(&HttpResponse) -> Reading<T>,
    ) -> Result<T, ProviderError> {
        if let Some(answer) = self.answered_before(call, question, &read).await? {
            return Ok(answer);
        }
        let deadline = Instant::now() + Duration::from_secs(self.limits.total_timeout_secs);
        let mut tries = 0;
        loop {
            tries += 1;
            let span = tracing::info_span!(
                "provider_call",
                otel.kind = "client",
                provider = self.provider,
                model = self.model,
                operation = question.operation,
                attempt = tries,
                outcome = Empty,
                cost_micro_usd = Empty,
            );
            let attempt = self.attempt(call, question, tries, deadline, &read).instrument(span);
            let failure = match attempt.await? {
                Ok(answer) => return Ok(answer),
                Err(failure) => failure,
            };
            let lost = failure.kind.billed() == Billed::Unknown;
            if lost && self.on_unknown == OnUnknown::Fail {
                return Err(self.unknown(&failure));
            }
            match self.pause_before_next(&failure, tries, deadline) {
                Some(pause) => {
                    tracing::debug!(
                        provider = self.provider,
                        code = failure.kind.code(),
                        reason = failure.reason,
                        pause_ms = pause.as_millis() as u64,
                        "a call failed; trying again"
                    );
                    unless_cancelled(&call.cancel, tokio::time::sleep(pause)).await?;
                }
                None => return Err(failure.into_error(self.port, &self.provider)),
            }
        }
    }

    /// The usable answer that the ledger keeps from a worker that died.
    async fn answered_before<T>(
        &self,
        call: &Call,
        question: &Question,
        read: &impl Fn(&HttpResponse) -> Reading<T>,
    ) -> Result<Option<T>, ProviderError> {
        let kept = call.ledger.answer(self.digest(question)).await;
        let Some(kept) = kept.map_err(|error| self.not_written(error))? else { return Ok(None) };
        Ok(from_ledger_answer(&kept).and_then(|reply| read(&reply).result.ok()))
    }

    /// The pause before the next attempt; `None` where there is none.
    fn pause_before_next(&self, failure: &Failure, tries: u32, deadline: Instant) -> Option<Duration> {
        if !failure.kind.may_pass() || tries >= self.limits.max_tries {
            return None;
        }
        let (base, cap) = (self.limits.pause_base_ms, self.limits.pause_cap_ms);
        let (base, cap) = (Duration::from_millis(base), Duration::from_millis(cap));
        let jitter = full_jitter(tries, base, cap, uniform());
        let pause = match failure.retry_after {
            // Too long to wait here: the job returns to its queue and frees the worker.
            Some(asked) if asked > cap => return None,
            // Jitter spreads the attempts after the requested pause.
            Some(asked) => asked + jitter,
            None => jitter,
        };
        (Instant::now() + pause < deadline).then_some(pause)
    }

    /// One attempt. The outer error is permanent.
    async fn attempt<T>(
        &self,
        call: &Call,
        question: &Question,
        tries: u32,
        deadline: Instant,
        read: &impl Fn(&HttpResponse) -> Reading<T>,
    ) -> Result<Result<T, Failure>, ProviderError> {
        call.cancel.check()?;
        let left = deadline.saturating_duration_since(Instant::now());
        let waited = tokio::time::timeout(left, self.rate_limiter.acquire());
        let Ok(_slot) = unless_cancelled(&call.cancel, waited).await? else {
            return Err(self.transient("provider_queue_timeout", "no turn came in time".into()));
        };
        let permit = match self.circuit_breaker.admit(Instant::now()) {
            Ok(permit) => permit,
            Err(cooldown) => {
                let reason =
                    format!("it failed too often and is left alone for {:.1} s", cooldown.as_secs_f64());
                return Err(self.transient("provider_circuit_open", reason));
            }
        };
        let entry = self.reserve(call, question, tries).await?;
        let url = format!("{}{}", self.base_url.trim_end_matches('/'), question.path);
        let mut request = HttpRequest {
            method: Method::POST,
            url,
            headers: question.headers.clone(),
            transient_headers: Vec::new(),
            bearer: self.bearer(),
            content_type: question.content_type.clone(),
            body: question.body.clone(),
        };
        request.transient_headers = self.signature(&request);
        if !self.idempotency_header.is_empty() {
            let key = (self.idempotency_header.clone(), entry.idempotency_key.clone());
            request.transient_headers.push(key);
        }
        let left = deadline.saturating_duration_since(Instant::now());
        let longest = left.min(Duration::from_secs(self.limits.attempt_timeout_secs));
        let started = Instant::now();
        let sent = tokio::time::timeout(longest, self.client.send(&request, self.limits.max_answer_bytes));
        let ended = match unless_cancelled(&call.cancel, sent).await {
            Ok(Ok(Ok(reply))) => Ok(self.read(reply, read)),
            Ok(Ok(Err(error))) => Ok(self.without_answer(Failure::of_send(&error))),
            Ok(Err(_)) => {
                let reason = format!("no answer within {:.1} s", longest.as_secs_f64());
                Ok(self.without_answer(Failure::new(FailureKind::TimedOut, reason)))
            }
            Err(cancelled) => Err(cancelled),
        };
        let Ok(Attempt { result, settlement }) = ended else {
            // A cancelled call may still be billed.
            self.count(question, &unknown_settlement(), started.elapsed());
            self.settle(call, entry, unknown_settlement()).await?;
            return Err(Cancelled.into());
        };
        match &result {
            Ok(_) => permit.succeeded(),
            Err(failure) if failure.kind.blames_endpoint() => permit.failed(Instant::now()),
            Err(failure) => {
                if let (FailureKind::Busy, Some(asked)) = (failure.kind, failure.retry_after) {
                    self.rate_limiter.pause_until(
                        Instant::now() + asked.min(Duration::from_millis(self.limits.pause_cap_ms)),
                    );
                }
                permit.succeeded();
            }
        }
        self.count(question, &settlement, started.elapsed());
        self.settle(call, entry, settlement).await?;
        Ok(result)
    }

    /// Counts a try in the metrics, and says in its span how it ended.
    fn count(&self, question: &Question, settlement: &Settlement, duration: Duration) {
        let (provider, operation) = (self.provider.clone(), question.operation);
        let labels = [("provider", provider), ("operation", operation.to_owned())];
        let reserved = if self.client.is_replaying() { MicroUsd::ZERO } else { question.reserved };
        let cost = u64::try_from(settlement.cost.unwrap_or(reserved).0).unwrap_or(0);
        metrics::counter!("tabletopgen_provider_calls_total", "provider" => self.provider.clone(),
            "operation" => operation, "outcome" => settlement.outcome)
        .increment(1);
        metrics::histogram!("tabletopgen_provider_call_seconds", &labels).record(duration.as_secs_f64());
        metrics::counter!("tabletopgen_provider_cost_micro_usd_total", &labels).increment(cost);
        Span::current().record("outcome", settlement.outcome).record("cost_micro_usd", cost);
    }

    async fn reserve(&self, call: &Call, question: &Question, tries: u32) -> Result<Entry, ProviderError> {
        let intent = Intent {
            port: self.port,
            provider: self.provider.clone(),
            model: self.model.clone(),
            endpoint: format!("{}{}", self.base_url.trim_end_matches('/'), question.path),
            operation: question.operation,
            request_digest: self.digest(question),
            attempt: tries,
            // A replay costs nothing.
            reserved: if self.client.is_replaying() { MicroUsd::ZERO } else { question.reserved },
            sent_bytes: question.body.len() as u64,
            on_unknown: self.on_unknown,
        };
        call.ledger.reserve(intent).await.map_err(|error| self.not_written(error))
    }

    async fn settle(&self, call: &Call, entry: Entry, settlement: Settlement) -> Result<(), ProviderError> {
        call.ledger.settle(entry, settlement).await.map_err(|error| self.not_written(error))
    }

    /// SHA-256 of all parts of the request that decide the answer.
    pub(super) fn digest(&self, question: &Question) -> String {
        let mut digest = Sha256::new();
        for part in [self.base_url.as_bytes(), question.path.as_bytes(), question.content_type.as_bytes()] {
            digest.update((part.len() as u64).to_le_bytes());
            digest.update(part);
        }
        for (name, value) in &question.headers {
            digest.update(format!("{name}: {value}\n"));
        }
        digest.update(&question.body);
        runtime::digest::hex(&digest.finalize())
    }

    fn read<T>(&self, mut reply: HttpResponse, read: &impl Fn(&HttpResponse) -> Reading<T>) -> Attempt<T> {
        let received_bytes = reply.body.len() as u64;
        if let Some(key) = &self.key {
            reply.body = key.redact(reply.body);
        }
        if let Some(failure) = Failure::of_status(&reply) {
            let mut tried = self.without_answer(failure);
            tried.settlement.received_bytes = received_bytes;
            return tried;
        }
        let Reading { cost, input_tokens, output_tokens, task, result } = read(&reply);
        let cost = if self.client.is_replaying() { Some(MicroUsd::ZERO) } else { cost };
        let outcome = match &result {
            Ok(_) => ANSWERED,
            Err(failure) => failure.kind.outcome(),
        };
        // For a vendor's job, the ledger keeps the id and later the file instead.
        let answer = (result.is_ok() && task.is_none()).then(|| to_ledger_answer(&reply));
        let settlement =
            Settlement { cost, received_bytes, input_tokens, output_tokens, outcome, task, answer };
        Attempt { result, settlement }
    }

    /// An attempt without an answer.
    fn without_answer<T>(&self, failure: Failure) -> Attempt<T> {
        let cost = (failure.kind.billed() == Billed::No).then_some(MicroUsd::ZERO);
        let settlement = Settlement { cost, outcome: failure.kind.outcome(), ..unknown_settlement() };
        Attempt { result: Err(failure), settlement }
    }

    pub(super) fn transient(&self, code: &'static str, reason: String) -> ProviderError {
        ProviderError::Transient { port: self.port, code, reason: format!("{}: {reason}", self.provider) }
    }

    fn unknown(&self, failure: &Failure) -> ProviderError {
        let reason = format!("{}: {}; {}", self.provider, failure.reason, LedgerError::OutcomeUnknown);
        ProviderError::Rejected { port: self.port, code: OUTCOME_UNKNOWN, reason }
    }

    pub(super) fn not_written(&self, error: LedgerError) -> ProviderError {
        let (port, reason) = (self.port, error.to_string());
        match error {
            LedgerError::OverBudget { .. } | LedgerError::OverMonth { .. } => {
                ProviderError::OverBudget { port, reason }
            }
            LedgerError::OutcomeUnknown => ProviderError::Rejected { port, code: OUTCOME_UNKNOWN, reason },
            LedgerError::LeaseLost(_) => ProviderError::Ledger { port, lease_lost: true, reason },
            LedgerError::Unavailable(_) => ProviderError::Ledger { port, lease_lost: false, reason },
        }
    }
}

fn unknown_settlement() -> Settlement {
    Settlement {
        cost: None,
        received_bytes: 0,
        input_tokens: None,
        output_tokens: None,
        outcome: OUTCOME_UNKNOWN,
        task: None,
        answer: None,
    }
}

/// The form in which the ledger keeps a response: its content type on a line, then its body.
fn to_ledger_answer(reply: &HttpResponse) -> Bytes {
    [reply.content_type.as_bytes(), b"\n", &reply.body].concat().into()
}

fn from_ledger_answer(kept: &Bytes) -> Option<HttpResponse> {
    let end = kept.iter().position(|byte| *byte == b'\n')?;
    let content_type = String::from_utf8(kept[..end].to_vec()).ok()?;
    Some(HttpResponse { status: 200, content_type, retry_after: None, body: kept.slice(end + 1..) })
}

/// The output of `future`, unless the job is cancelled first; then the future is dropped.
pub async fn unless_cancelled<T>(
    cancel: &CancelFlag,
    future: impl Future<Output = T>,
) -> Result<T, Cancelled> {
    let mut future = std::pin::pin!(future);
    loop {
        cancel.check()?;
        if let Ok(output) = tokio::time::timeout(POLL, &mut future).await {
            return Ok(output);
        }
    }
}
