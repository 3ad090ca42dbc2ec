//! What costs nothing and is asked again and again: how far a vendor's job is, what came of it.

use std::time::{Duration, Instant};

use bytes::Bytes;
use reqwest::Method;

use super::{Endpoint, unless_interrupted};
use crate::failure::{Failure, FailureKind};
use crate::outbound::{Outgoing, Reply};
use crate::patience::{full_jitter, unit};
use crate::task::Look;
use ports::{Call, ProviderError};

/// Longest time for telling a vendor that nobody wants its work any more.
const FAREWELL: Duration = Duration::from_secs(5);

impl Endpoint {
    /// Asks under the base URL until there is an answer, a failure that stays one, or too many that may pass. The inner
    /// error is the vendor's.
    pub(crate) async fn look<T>(
        &self,
        call: &Call,
        look: &Look,
        read: impl Fn(&Reply) -> Result<T, Failure>,
    ) -> Result<Result<T, Failure>, ProviderError> {
        let method = if look.body.is_some() { Method::POST } else { Method::GET };
        let mut outgoing = self.free(method, self.address(&look.path), true);
        outgoing.headers = look.headers.clone();
        outgoing.body = look.body.clone().unwrap_or_default();
        self.patiently(call, outgoing, self.limits.max_answer_bytes, read).await
    }

    /// Fetches a file from an address that the vendor named: wherever that is, no key goes along.
    pub(crate) async fn download(
        &self,
        call: &Call,
        url: &str,
        most_bytes: usize,
    ) -> Result<Result<Bytes, Failure>, ProviderError> {
        let outgoing = self.free(Method::GET, url.to_owned(), false);
        self.patiently(call, outgoing, most_bytes, |reply| Ok(reply.body.clone())).await
    }

    /// Tells the vendor something, once, and does not mind whether that arrives.
    pub(crate) async fn tell(&self, path: &str) {
        let outgoing = self.free(Method::POST, self.address(path), true);
        let told = tokio::time::timeout(FAREWELL, self.outbound.send(&outgoing, 64 << 10)).await;
        tracing::debug!(provider = self.provider, path, heard = matches!(told, Ok(Ok(_))), "told the vendor");
    }

    fn address(&self, path: &str) -> String {
        format!("{}{path}", self.base_url.trim_end_matches('/'))
    }

    fn free(&self, method: Method, url: String, with_key: bool) -> Outgoing {
        Outgoing {
            method,
            url,
            headers: Vec::new(),
            passing_headers: Vec::new(),
            bearer: self.bearer().filter(|_| with_key),
            content_type: "application/json".into(),
            body: Bytes::new(),
        }
    }

    async fn patiently<T>(
        &self,
        call: &Call,
        mut outgoing: Outgoing,
        most_bytes: usize,
        read: impl Fn(&Reply) -> Result<T, Failure>,
    ) -> Result<Result<T, Failure>, ProviderError> {
        let deadline = Instant::now() + Duration::from_secs(self.limits.total_timeout_secs);
        let mut tries = 0;
        loop {
            tries += 1;
            outgoing.passing_headers = self.signature(&outgoing);
            let left = deadline.saturating_duration_since(Instant::now());
            let longest = left.min(Duration::from_secs(self.limits.attempt_timeout_secs));
            let sent = tokio::time::timeout(longest, self.outbound.send(&outgoing, most_bytes));
            let result = match unless_interrupted(&call.interrupt, sent).await? {
                Ok(Ok(reply)) => self.understood(reply, &read),
                Ok(Err(error)) => Err(Failure::of_send(&error)),
                Err(_) => {
                    let reason = format!("no answer within {:.1} s", longest.as_secs_f64());
                    Err(Failure::new(FailureKind::TimedOut, reason))
                }
            };
            let failure = match result {
                Ok(answer) => return Ok(Ok(answer)),
                Err(failure) => failure,
            };
            if !failure.kind.may_pass() || tries >= self.limits.max_tries || Instant::now() >= deadline {
                return Ok(Err(failure));
            }
            let (base, cap) = (self.limits.pause_base_ms, self.limits.pause_cap_ms);
            let (base, cap) = (Duration::from_millis(base), Duration::from_millis(cap));
            let pause =
                failure.retry_after.unwrap_or_default().min(cap) + full_jitter(tries, base, cap, unit());
            unless_interrupted(&call.interrupt, tokio::time::sleep(pause)).await?;
        }
    }

    fn understood<T>(
        &self,
        mut reply: Reply,
        read: &impl Fn(&Reply) -> Result<T, Failure>,
    ) -> Result<T, Failure> {
        if let Some(key) = &self.key {
            reply.body = key.redact(reply.body);
        }
        match Failure::of_status(&reply) {
            Some(failure) => Err(failure),
            None => read(&reply),
        }
    }
}
