//! Unbilled requests: status polling of a vendor's job, downloads, and cancellation.

use std::time::{Duration, Instant};

use bytes::Bytes;

use super::{Endpoint, unless_cancelled};
use crate::failure::{Failure, FailureKind};
use crate::vendor_job::StatusQuery;
use http_client::retry::{full_jitter, uniform};
use http_client::{HttpRequest, HttpResponse, Method};
use ports::{Call, ProviderError};

/// Longest time of a cancellation request.
const CANCEL_TIMEOUT: Duration = Duration::from_secs(5);

impl Endpoint {
    /// Sends a status query, and repeats it after transient failures. The inner error is the vendor's.
    pub(crate) async fn poll<T>(
        &self,
        call: &Call,
        query: &StatusQuery,
        read: impl Fn(&HttpResponse) -> Result<T, Failure>,
    ) -> Result<Result<T, Failure>, ProviderError> {
        let method = if query.body.is_some() { Method::POST } else { Method::GET };
        let mut request = self.unbilled(method, self.address(&query.path), true);
        request.headers = query.headers.clone();
        request.body = query.body.clone().unwrap_or_default();
        self.send_with_retries(call, request, self.limits.max_answer_bytes, read).await
    }

    /// Downloads a file from a URL that the vendor names, without the key.
    pub(crate) async fn download(
        &self,
        call: &Call,
        url: &str,
        max_bytes: usize,
    ) -> Result<Result<Bytes, Failure>, ProviderError> {
        let request = self.unbilled(Method::GET, url.to_owned(), false);
        self.send_with_retries(call, request, max_bytes, |reply| Ok(reply.body.clone())).await
    }

    /// Asks the vendor once to cancel a job, and ignores the result.
    pub(crate) async fn cancel(&self, path: &str) {
        let request = self.unbilled(Method::POST, self.address(path), true);
        let message = tokio::time::timeout(CANCEL_TIMEOUT, self.client.send(&request, 64 << 10)).await;
        tracing::debug!(
            provider = self.provider,
            path,
            delivered = matches!(message, Ok(Ok(_))),
            "asked the vendor to cancel"
        );
    }

    fn address(&self, path: &str) -> String {
        format!("{}{path}", self.base_url.trim_end_matches('/'))
    }

    fn unbilled(&self, method: Method, url: String, with_key: bool) -> HttpRequest {
        HttpRequest {
            method,
            url,
            headers: Vec::new(),
            transient_headers: Vec::new(),
            bearer: self.bearer().filter(|_| with_key),
            content_type: "application/json".into(),
            body: Bytes::new(),
        }
    }

    async fn send_with_retries<T>(
        &self,
        call: &Call,
        mut request: HttpRequest,
        max_bytes: usize,
        read: impl Fn(&HttpResponse) -> Result<T, Failure>,
    ) -> Result<Result<T, Failure>, ProviderError> {
        let deadline = Instant::now() + Duration::from_secs(self.limits.total_timeout_secs);
        let mut tries = 0;
        loop {
            tries += 1;
            request.transient_headers = self.signature(&request);
            let left = deadline.saturating_duration_since(Instant::now());
            let longest = left.min(Duration::from_secs(self.limits.attempt_timeout_secs));
            let sent = tokio::time::timeout(longest, self.client.send(&request, max_bytes));
            let result = match unless_cancelled(&call.cancel, sent).await? {
                Ok(Ok(reply)) => self.classify(reply, &read),
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
                failure.retry_after.unwrap_or_default().min(cap) + full_jitter(tries, base, cap, uniform());
            unless_cancelled(&call.cancel, tokio::time::sleep(pause)).await?;
        }
    }

    fn classify<T>(
        &self,
        mut reply: HttpResponse,
        read: &impl Fn(&HttpResponse) -> Result<T, Failure>,
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
