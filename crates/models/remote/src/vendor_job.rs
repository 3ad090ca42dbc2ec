//! Jobs of vendors that take minutes: submit, poll the status until the job ends, download the result.
//!
//! The ledger records two facts, so that a worker that dies causes no second job. It records the vendor's job id, in
//! the row of the submitting call and before the first status query. It also records the downloaded file, since
//! vendors delete it soon. The same question in the same job continues from there. Status queries and downloads are
//! free; only the submission is billed.

use std::fmt::Display;
use std::sync::Arc;
use std::time::{Duration, Instant};

use bytes::Bytes;
use serde_json::Value;
use tokio::sync::Semaphore;

use super::Endpoint;
use super::endpoint::{Question, Reading, unless_cancelled};
use super::failure::{Failure, FailureKind};
use super::settings::TaskSettings;
use http_client::HttpResponse;
use ports::ledger::{LedgerError, Task};
use ports::{Call, ProviderError};

/// Maximum downloads of a file that cannot be used: the server may still have been writing it.
const MAX_DOWNLOADS: u32 = 3;

/// Progress of a vendor's job.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Progress {
    Working,
    /// The file is at this URL.
    Ready {
        url: String,
    },
    /// The file itself.
    File(Bytes),
    /// The job failed, with the vendor's reason.
    Failed(String),
}

/// An unbilled request for the status of a job.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StatusQuery {
    /// The path under the base URL, with its leading slash.
    pub path: String,
    /// Names and values.
    pub headers: Vec<(String, String)>,
    /// The body of a POST; without a body the query is a GET.
    pub body: Option<Bytes>,
}

impl StatusQuery {
    /// A GET of `path`.
    pub fn get(path: String) -> Self {
        Self { path, headers: Vec::new(), body: None }
    }

    /// A POST with a JSON body.
    pub fn post(path: &str, headers: Vec<(String, String)>, body: &Value) -> Self {
        Self { path: path.to_owned(), headers, body: Some(body.to_string().into()) }
    }
}

/// A vendor's protocol for its jobs.
pub trait Protocol: Sync {
    /// Reads the response to a submission: the job id, also as the reading's task.
    fn submitted(&self, reply: &HttpResponse) -> Reading<String>;

    /// The request for the status of a job.
    fn status_query(&self, id: &str) -> StatusQuery;

    /// Reads the response to a status query.
    fn progress(&self, reply: &HttpResponse) -> Result<Progress, Failure>;

    /// The path that cancels a job; `None` where the vendor cannot cancel.
    fn cancel_path(&self, id: &str) -> Option<String>;
}

/// Reason why no file was obtained.
enum Stopped {
    /// The vendor's job will give no file.
    Over(ProviderError),
    /// The vendor's job continues.
    ForNow(ProviderError),
}

impl From<ProviderError> for Stopped {
    fn from(error: ProviderError) -> Self {
        Self::ForNow(error)
    }
}

/// Limits the concurrent jobs at a vendor; clones share the limit.
#[derive(Clone, Debug)]
pub struct JobSlots(Arc<Semaphore>);

impl JobSlots {
    pub fn new(settings: &TaskSettings) -> Self {
        Self(Arc::new(Semaphore::new(settings.vendor_jobs.clamp(1, 1024))))
    }
}

/// A question whose answer is a file that takes minutes to make.
pub struct LongQuestion<'a, P> {
    pub endpoint: &'a Endpoint,
    pub slots: &'a JobSlots,
    pub protocol: &'a P,
    pub settings: &'a TaskSettings,
    pub question: &'a Question,
}

impl<P: Protocol> LongQuestion<'_, P> {
    /// The file, as `accept` reads it.
    ///
    /// # Errors
    ///
    /// A failed, lost or late job, a file that `accept` rejects repeatedly, and every failure of a call.
    pub async fn ask<T, E, A, F>(&self, call: &Call, accept: A) -> Result<T, ProviderError>
    where
        E: Display,
        A: Fn(Bytes) -> F,
        F: Future<Output = Result<Result<T, E>, ProviderError>>,
    {
        // The semaphore is never closed.
        let _slot = unless_cancelled(&call.cancel, self.slots.0.acquire()).await?.ok();
        let task = self.task(call).await?;
        if let Some(file) = &task.file {
            if let Ok(answer) = accept(file.clone()).await? {
                return Ok(answer);
            }
            // Another version of the program kept it; the vendor may still hold the file.
            tracing::warn!(task = task.id, "a file that was fetched cannot be used; fetching it again");
        }
        match self.obtain(call, &task, accept).await {
            Ok(answer) => Ok(answer),
            Err(Stopped::Over(error)) => {
                self.written(call.ledger.over(task.entry_id).await)?;
                Err(error)
            }
            Err(Stopped::ForNow(error)) => {
                // A worker that drains or dies has a successor that continues the job; a cancelled job has none.
                if matches!(error, ProviderError::Cancelled(_)) && call.ledger.is_cancelled().await {
                    self.cancel(&task).await;
                }
                Err(error)
            }
        }
    }

    /// The vendor's job: one that was submitted before, or a new one.
    async fn task(&self, call: &Call) -> Result<Task, ProviderError> {
        let digest = self.endpoint.digest(self.question);
        if let Some(task) = self.written(call.ledger.task(digest.clone()).await)? {
            return Ok(task);
        }
        let submitted = |reply: &HttpResponse| self.protocol.submitted(reply);
        let id = self.endpoint.ask(call, self.question, submitted).await?;
        let kept = self.written(call.ledger.task(digest).await)?;
        // A ledger that keeps no jobs of vendors (as in benchmarks) has no successor that needs this one.
        Ok(kept.unwrap_or(Task { entry_id: 0, id, file: None }))
    }

    async fn obtain<T, E, A, F>(&self, call: &Call, task: &Task, accept: A) -> Result<T, Stopped>
    where
        E: Display,
        A: Fn(Bytes) -> F,
        F: Future<Output = Result<Result<T, E>, ProviderError>>,
    {
        let deadline = Instant::now() + Duration::from_secs(self.settings.task_timeout_secs);
        let mut refused = String::new();
        for _ in 0..MAX_DOWNLOADS {
            let file = self.file(call, task, deadline).await?;
            match accept(file.clone()).await? {
                Ok(answer) => {
                    if task.entry_id != 0 {
                        self.written(call.ledger.fetched(task.entry_id, file).await)?;
                    }
                    return Ok(answer);
                }
                Err(why) => refused = why.to_string(),
            }
            self.pause(call).await?;
        }
        let reason = format!("what came of the vendor's job cannot be used: {refused}");
        Err(Stopped::Over(self.endpoint.transient("provider_bad_answer", reason)))
    }

    /// Polls until the vendor's job ends, and downloads its file.
    async fn file(&self, call: &Call, task: &Task, deadline: Instant) -> Result<Bytes, Stopped> {
        let query = self.protocol.status_query(&task.id);
        loop {
            let progress = self.endpoint.poll(call, &query, |reply| self.protocol.progress(reply)).await?;
            match progress.map_err(|failure| self.lost(failure, &[FailureKind::NotFound]))? {
                Progress::Working => {}
                Progress::File(file) => return Ok(file),
                Progress::Ready { url } => {
                    let max_bytes = self.endpoint.limits.max_answer_bytes;
                    let file = self.endpoint.download(call, &url, max_bytes).await?;
                    // A signed URL is denied after it expires.
                    let gone = [FailureKind::NotFound, FailureKind::Denied];
                    return file.map_err(|failure| self.lost(failure, &gone));
                }
                Progress::Failed(why) => {
                    let reason = format!("the vendor's job failed: {why}");
                    return Err(Stopped::Over(self.endpoint.transient("provider_task_failed", reason)));
                }
            }
            if Instant::now() >= deadline {
                self.cancel(task).await;
                let secs = self.settings.task_timeout_secs;
                let reason = format!("the vendor's job {} was not done within {secs} s", task.id);
                return Err(Stopped::Over(self.endpoint.transient("provider_task_timeout", reason)));
            }
            self.pause(call).await?;
        }
    }

    async fn pause(&self, call: &Call) -> Result<(), ProviderError> {
        let pause = Duration::from_millis(self.settings.poll_interval_ms);
        Ok(unless_cancelled(&call.cancel, tokio::time::sleep(pause)).await?)
    }

    async fn cancel(&self, task: &Task) {
        if let Some(path) = self.protocol.cancel_path(&task.id) {
            self.endpoint.cancel(&path).await;
        }
    }

    /// Classifies a failure: a job or file that the vendor no longer has is requested anew by the next attempt.
    fn lost(&self, failure: Failure, gone: &[FailureKind]) -> Stopped {
        if gone.contains(&failure.kind) {
            let reason = format!("the vendor does not have it any more ({})", failure.reason);
            return Stopped::Over(self.endpoint.transient("provider_task_lost", reason));
        }
        Stopped::ForNow(failure.into_error(self.endpoint.port, &self.endpoint.provider))
    }

    fn written<T>(&self, result: Result<T, LedgerError>) -> Result<T, ProviderError> {
        result.map_err(|error| self.endpoint.not_written(error))
    }
}
