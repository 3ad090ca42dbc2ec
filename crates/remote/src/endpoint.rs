//! One endpoint of one vendor, and how a call of it is made: in its turn, past the breaker, written down before it is
//! sent and settled after, within its deadlines, again where that can help, and stopped when the job is.

mod free;
mod proof;

use std::borrow::Cow;
use std::time::{Duration, Instant};

use bytes::Bytes;
use reqwest::Method;
use sha2::{Digest as _, Sha256};

use super::breaker::Breaker;
use super::failure::{Billed, Failure, FailureKind};
use super::outbound::{Outbound, Outgoing, Reply};
use super::patience::{full_jitter, unit};
use super::turns::Turns;
use super::{LimitSettings, Secret};
use ports::ledger::{ANSWERED, Entry, Intent, LedgerError, MicroUsd, OUTCOME_UNKNOWN, OnUnknown, Settlement};
use ports::{Call, Port, ProviderError};
use runtime::{Interrupt, Interrupted};

/// How often waits look at the interrupt.
const POLL: Duration = Duration::from_millis(50);

/// An endpoint with everything its calls share.
pub struct Endpoint {
    pub port: Port,
    /// As in the adapter's identity (`openai/chat`).
    pub provider: String,
    pub model: String,
    pub base_url: String,
    pub key: Option<Secret>,
    /// How the key proves who asks.
    pub proof: Proof,
    /// Empty = the vendor knows no idempotency keys.
    pub idempotency_header: String,
    pub limits: LimitSettings,
    pub on_unknown: OnUnknown,
    pub outbound: Outbound,
    pub turns: Turns,
    pub breaker: Breaker,
}

/// One question to an endpoint.
#[derive(Clone, Debug)]
pub struct Question {
    pub operation: &'static str,
    /// Appended to the base URL, with its slash.
    pub path: &'static str,
    /// Names and values; part of what is asked.
    pub headers: Vec<(String, String)>,
    pub content_type: Cow<'static, str>,
    pub body: Bytes,
    /// The most that the answer can cost.
    pub reserved: MicroUsd,
}

/// What an adapter reads off an answer.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Reading<T> {
    /// `None` where the answer does not say; then what was reserved counts.
    pub cost: Option<MicroUsd>,
    pub input_tokens: Option<u64>,
    pub output_tokens: Option<u64>,
    /// The vendor's id of the job it has begun, where the answer comes later.
    pub task: Option<String>,
    pub result: Result<T, Failure>,
}

/// How a key proves who asks.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Proof {
    /// It is sent, as `Authorization: Bearer`.
    Bearer,
    /// It signs requests, as Tencent Cloud wants it; this id is sent with the signature.
    Tc3 { secret_id: String, service: String },
}

/// How one try went.
struct Try<T> {
    result: Result<T, Failure>,
    settlement: Settlement,
}

impl Endpoint {
    /// Asks until there is an answer, or a failure that stays one, or the time is over.
    pub async fn ask<T>(
        &self,
        call: &Call,
        question: &Question,
        read: impl Fn(&Reply) -> Reading<T>,
    ) -> Result<T, ProviderError> {
        if let Some(answer) = self.answered_before(call, question, &read).await? {
            return Ok(answer);
        }
        let deadline = Instant::now() + Duration::from_secs(self.limits.total_timeout_secs);
        let mut tries = 0;
        loop {
            tries += 1;
            let failure = match self.attempt(call, question, tries, deadline, &read).await? {
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
                    unless_interrupted(&call.interrupt, tokio::time::sleep(pause)).await?;
                }
                None => return Err(failure.into_error(self.port, &self.provider)),
            }
        }
    }

    /// What a worker that died was answered, if that can be used.
    async fn answered_before<T>(
        &self,
        call: &Call,
        question: &Question,
        read: &impl Fn(&Reply) -> Reading<T>,
    ) -> Result<Option<T>, ProviderError> {
        let kept = call.ledger.answer(self.digest(question)).await;
        let Some(kept) = kept.map_err(|error| self.not_written(error))? else { return Ok(None) };
        Ok(kept_reply(&kept).and_then(|reply| read(&reply).result.ok()))
    }

    /// The pause before the next try; `None` where there is to be none.
    fn pause_before_next(&self, failure: &Failure, tries: u32, deadline: Instant) -> Option<Duration> {
        if !failure.kind.may_pass() || tries >= self.limits.max_tries {
            return None;
        }
        let (base, cap) = (self.limits.pause_base_ms, self.limits.pause_cap_ms);
        let (base, cap) = (Duration::from_millis(base), Duration::from_millis(cap));
        let jitter = full_jitter(tries, base, cap, unit());
        let pause = match failure.retry_after {
            // Longer than anybody waits here: the job goes back to its queue and others get the worker.
            Some(asked) if asked > cap => return None,
            // Spread beyond the time that everybody was told.
            Some(asked) => asked + jitter,
            None => jitter,
        };
        (Instant::now() + pause < deadline).then_some(pause)
    }

    /// One try. The outer error is one that no further try can help.
    async fn attempt<T>(
        &self,
        call: &Call,
        question: &Question,
        tries: u32,
        deadline: Instant,
        read: &impl Fn(&Reply) -> Reading<T>,
    ) -> Result<Result<T, Failure>, ProviderError> {
        call.interrupt.check()?;
        let left = deadline.saturating_duration_since(Instant::now());
        let waited = tokio::time::timeout(left, self.turns.take());
        let Ok(_turn) = unless_interrupted(&call.interrupt, waited).await? else {
            return Err(self.transient("provider_queue_timeout", "no turn came in time".into()));
        };
        let pass = match self.breaker.admit(Instant::now()) {
            Ok(pass) => pass,
            Err(rest) => {
                let reason = format!("it failed too often and is left alone for {:.1} s", rest.as_secs_f64());
                return Err(self.transient("provider_resting", reason));
            }
        };
        let entry = self.reserve(call, question, tries).await?;
        let url = format!("{}{}", self.base_url.trim_end_matches('/'), question.path);
        let mut outgoing = Outgoing {
            method: Method::POST,
            url,
            headers: question.headers.clone(),
            passing_headers: Vec::new(),
            bearer: self.bearer(),
            content_type: question.content_type.clone(),
            body: question.body.clone(),
        };
        outgoing.passing_headers = self.signature(&outgoing);
        if !self.idempotency_header.is_empty() {
            let key = (self.idempotency_header.clone(), entry.idempotency_key.clone());
            outgoing.passing_headers.push(key);
        }
        let left = deadline.saturating_duration_since(Instant::now());
        let longest = left.min(Duration::from_secs(self.limits.attempt_timeout_secs));
        let sent = tokio::time::timeout(longest, self.outbound.send(&outgoing, self.limits.max_answer_bytes));
        let ended = match unless_interrupted(&call.interrupt, sent).await {
            Ok(Ok(Ok(reply))) => Ok(self.read(reply, read)),
            Ok(Ok(Err(error))) => Ok(self.nothing(Failure::of_send(&error))),
            Ok(Err(_)) => {
                let reason = format!("no answer within {:.1} s", longest.as_secs_f64());
                Ok(self.nothing(Failure::new(FailureKind::TimedOut, reason)))
            }
            Err(interrupted) => Err(interrupted),
        };
        let Ok(Try { result, settlement }) = ended else {
            // Whoever cancels pays for what was under way.
            self.settle(call, entry, unknown_settlement()).await?;
            return Err(Interrupted.into());
        };
        match &result {
            Ok(_) => pass.answered(),
            Err(failure) if failure.kind.is_the_endpoints() => pass.failed(Instant::now()),
            Err(failure) => {
                if let (FailureKind::Busy, Some(asked)) = (failure.kind, failure.retry_after) {
                    self.turns
                        .hold(Instant::now() + asked.min(Duration::from_millis(self.limits.pause_cap_ms)));
                }
                pass.answered();
            }
        }
        let outcome = settlement.outcome;
        metrics::counter!("tabletopgen_provider_calls_total", "provider" => self.provider.clone(),
            "operation" => question.operation, "outcome" => outcome)
        .increment(1);
        self.settle(call, entry, settlement).await?;
        Ok(result)
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
            // A recording is paid for already.
            reserved: if self.outbound.is_playing() { MicroUsd::ZERO } else { question.reserved },
            sent_bytes: question.body.len() as u64,
            on_unknown: self.on_unknown,
        };
        call.ledger.reserve(intent).await.map_err(|error| self.not_written(error))
    }

    async fn settle(&self, call: &Call, entry: Entry, settlement: Settlement) -> Result<(), ProviderError> {
        call.ledger.settle(entry, settlement).await.map_err(|error| self.not_written(error))
    }

    /// Of everything that decides the answer.
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
        digest.finalize().iter().map(|byte| format!("{byte:02x}")).collect()
    }

    fn read<T>(&self, mut reply: Reply, read: &impl Fn(&Reply) -> Reading<T>) -> Try<T> {
        let received_bytes = reply.body.len() as u64;
        if let Some(key) = &self.key {
            reply.body = key.redact(reply.body);
        }
        if let Some(failure) = Failure::of_status(&reply) {
            let mut tried = self.nothing(failure);
            tried.settlement.received_bytes = received_bytes;
            return tried;
        }
        let Reading { cost, input_tokens, output_tokens, task, result } = read(&reply);
        let cost = if self.outbound.is_playing() { Some(MicroUsd::ZERO) } else { cost };
        let outcome = match &result {
            Ok(_) => ANSWERED,
            Err(failure) => failure.kind.outcome(),
        };
        // Of a vendor's job the id is kept, and what comes of it.
        let answer = (result.is_ok() && task.is_none()).then(|| keepable(&reply));
        let settlement =
            Settlement { cost, received_bytes, input_tokens, output_tokens, outcome, task, answer };
        Try { result, settlement }
    }

    /// A try that brought no answer.
    fn nothing<T>(&self, failure: Failure) -> Try<T> {
        let cost = (failure.kind.billed() == Billed::No).then_some(MicroUsd::ZERO);
        let settlement = Settlement { cost, outcome: failure.kind.outcome(), ..unknown_settlement() };
        Try { result: Err(failure), settlement }
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
            LedgerError::OverBudget { .. } => ProviderError::OverBudget { port, reason },
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

/// A successful answer as it is kept: its content type on a line, then its body.
fn keepable(reply: &Reply) -> Bytes {
    [reply.content_type.as_bytes(), b"\n", &reply.body].concat().into()
}

fn kept_reply(kept: &Bytes) -> Option<Reply> {
    let end = kept.iter().position(|byte| *byte == b'\n')?;
    let content_type = String::from_utf8(kept[..end].to_vec()).ok()?;
    Some(Reply { status: 200, content_type, retry_after: None, body: kept.slice(end + 1..) })
}

/// The future's output, unless the job is asked to stop first; then the future is dropped where it is.
pub async fn unless_interrupted<T>(
    interrupt: &Interrupt,
    future: impl Future<Output = T>,
) -> Result<T, Interrupted> {
    let mut future = std::pin::pin!(future);
    loop {
        interrupt.check()?;
        if let Ok(output) = tokio::time::timeout(POLL, &mut future).await {
            return Ok(output);
        }
    }
}
