//! Vendors that work for minutes: a question is submitted, the vendor's job is looked at until it is over, and what came
//! of it is fetched.
//!
//! Two things are written down on the way, so that a worker that dies costs no second job: the vendor's id of its job,
//! in the same row as the call that submitted it and before the first look, and the file that was fetched, since vendors
//! delete it soon. Whoever asks the same question in the same job again goes on from there. Looks and downloads cost
//! nothing; only submitting stands in the books.

use std::sync::Arc;
use std::time::{Duration, Instant};

use bytes::Bytes;
use serde_json::Value;
use tokio::sync::Semaphore;

use super::Endpoint;
use super::endpoint::{Question, Reading, unless_interrupted};
use super::failure::{Failure, FailureKind};
use super::outbound::Reply;
use super::settings::TaskSettings;
use ports::ledger::{LedgerError, Task};
use ports::{Call, ProviderError};

/// Times that a file is fetched again which cannot be used: it may have been read while it was written.
const FETCHES: u32 = 3;

/// How far a vendor's job is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Progress {
    Working,
    /// The file lies at this address.
    At(String),
    /// The file itself.
    File(Bytes),
    /// It failed, and says why.
    Failed(String),
}

/// A question that costs nothing.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Look {
    /// Under the base URL, with its slash.
    pub path: String,
    /// Names and values.
    pub headers: Vec<(String, String)>,
    /// Sent with a POST; without one it is a GET.
    pub body: Option<Bytes>,
}

impl Look {
    /// At an address.
    pub fn at(path: String) -> Self {
        Self { path, headers: Vec::new(), body: None }
    }

    /// By a request with a JSON body.
    pub fn asking(path: &str, headers: Vec<(String, String)>, body: &Value) -> Self {
        Self { path: path.to_owned(), headers, body: Some(body.to_string().into()) }
    }
}

/// How a vendor speaks about its jobs.
pub trait Protocol: Sync {
    /// Reads the answer to a submission: the vendor's id, also as the reading's task.
    fn submitted(&self, reply: &Reply) -> Reading<String>;

    /// How to look at a job.
    fn look(&self, id: &str) -> Look;

    /// How far it is.
    fn progress(&self, reply: &Reply) -> Result<Progress, Failure>;

    /// Where to call it off; `None` where the vendor cannot.
    fn call_off(&self, id: &str) -> Option<String>;
}

/// Why nothing was brought.
enum Stopped {
    /// Nothing will come of the vendor's job.
    Over(ProviderError),
    /// The vendor's job goes on.
    ForNow(ProviderError),
}

impl From<ProviderError> for Stopped {
    fn from(error: ProviderError) -> Self {
        Self::ForNow(error)
    }
}

/// How many jobs of ours a vendor works on at the same time; cloning shares them.
#[derive(Clone, Debug)]
pub struct JobSlots(Arc<Semaphore>);

impl JobSlots {
    pub fn new(settings: &TaskSettings) -> Self {
        Self(Arc::new(Semaphore::new(settings.vendor_jobs.clamp(1, 1024))))
    }
}

/// A question whose answer is a file that takes minutes.
pub struct LongQuestion<'a, P> {
    pub endpoint: &'a Endpoint,
    pub slots: &'a JobSlots,
    pub protocol: &'a P,
    pub settings: &'a TaskSettings,
    pub question: &'a Question,
}

impl<P: Protocol> LongQuestion<'_, P> {
    /// The file, as `accept` understands it.
    pub async fn ask<T, A, F>(&self, call: &Call, accept: A) -> Result<T, ProviderError>
    where
        A: Fn(Bytes) -> F,
        F: Future<Output = Result<Result<T, String>, ProviderError>>,
    {
        // Nobody closes it.
        let _slot = unless_interrupted(&call.interrupt, self.slots.0.acquire()).await?.ok();
        let task = self.task(call).await?;
        if let Some(file) = &task.file {
            if let Ok(answer) = accept(file.clone()).await? {
                return Ok(answer);
            }
            // Kept by a program that understood more; the vendor may still have it.
            tracing::warn!(task = task.id, "a file that was fetched cannot be used; fetching it again");
        }
        match self.brought(call, &task, accept).await {
            Ok(answer) => Ok(answer),
            Err(Stopped::Over(error)) => {
                self.written(call.ledger.over(task.entry_id).await)?;
                Err(error)
            }
            Err(Stopped::ForNow(error)) => {
                // Whoever drains or dies is followed by somebody who goes on; nobody follows who cancels.
                if matches!(error, ProviderError::Interrupted(_)) && call.ledger.is_cancelled().await {
                    self.call_off(&task).await;
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
        let submitted = |reply: &Reply| self.protocol.submitted(reply);
        let id = self.endpoint.ask(call, self.question, submitted).await?;
        let kept = self.written(call.ledger.task(digest).await)?;
        // Books that keep no vendors' jobs (benchmarks) have nobody who would come back for this one.
        Ok(kept.unwrap_or(Task { entry_id: 0, id, file: None }))
    }

    async fn brought<T, A, F>(&self, call: &Call, task: &Task, accept: A) -> Result<T, Stopped>
    where
        A: Fn(Bytes) -> F,
        F: Future<Output = Result<Result<T, String>, ProviderError>>,
    {
        let deadline = Instant::now() + Duration::from_secs(self.settings.task_timeout_secs);
        let mut refused = String::new();
        for _ in 0..FETCHES {
            let file = self.file(call, task, deadline).await?;
            match accept(file.clone()).await? {
                Ok(answer) => {
                    if task.entry_id != 0 {
                        self.written(call.ledger.fetched(task.entry_id, file).await)?;
                    }
                    return Ok(answer);
                }
                Err(why) => refused = why,
            }
            self.pause(call).await?;
        }
        let reason = format!("what came of the vendor's job cannot be used: {refused}");
        Err(Stopped::Over(self.endpoint.transient("provider_bad_answer", reason)))
    }

    /// Looks until the vendor's job is over, and fetches what came of it.
    async fn file(&self, call: &Call, task: &Task, deadline: Instant) -> Result<Bytes, Stopped> {
        let look = self.protocol.look(&task.id);
        loop {
            let looked = self.endpoint.look(call, &look, |reply| self.protocol.progress(reply)).await?;
            match looked.map_err(|failure| self.lost(failure, &[FailureKind::NotFound]))? {
                Progress::Working => {}
                Progress::File(file) => return Ok(file),
                Progress::At(url) => {
                    let most_bytes = self.endpoint.limits.max_answer_bytes;
                    let file = self.endpoint.download(call, &url, most_bytes).await?;
                    // An address that was signed for a time is denied after it.
                    let gone = [FailureKind::NotFound, FailureKind::Denied];
                    return file.map_err(|failure| self.lost(failure, &gone));
                }
                Progress::Failed(why) => {
                    let reason = format!("the vendor's job failed: {why}");
                    return Err(Stopped::Over(self.endpoint.transient("provider_task_failed", reason)));
                }
            }
            if Instant::now() >= deadline {
                self.call_off(task).await;
                let secs = self.settings.task_timeout_secs;
                let reason = format!("the vendor's job {} was not done within {secs} s", task.id);
                return Err(Stopped::Over(self.endpoint.transient("provider_task_timeout", reason)));
            }
            self.pause(call).await?;
        }
    }

    async fn pause(&self, call: &Call) -> Result<(), ProviderError> {
        let pause = Duration::from_millis(self.settings.look_every_ms);
        Ok(unless_interrupted(&call.interrupt, tokio::time::sleep(pause)).await?)
    }

    async fn call_off(&self, task: &Task) {
        if let Some(path) = self.protocol.call_off(&task.id) {
            self.endpoint.tell(&path).await;
        }
    }

    /// A job or a file that the vendor does not have any more is asked for anew, by the next try of the job.
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
