//! Submits the requests that are to be done, a few ahead of the worker, and writes down what comes of them.

use std::collections::BTreeMap;
use std::path::Path;
use std::time::{Duration, Instant};

use tokio::task::JoinHandle;
use tokio_util::sync::CancellationToken;

use super::bundles::Bundles;
use super::checker::Checker;
use super::money::Money;
use super::records::Records;
use super::report::{Report, Summary};
use super::source::Source;
use super::survey::{REQUEST_LABEL, Stock};
use crate::app::AppError;
use crate::cli::backup::failed;
use crate::cli::{Exit, Failure};
use crate::worker::Worker;
use batches::{BatchRequest, Grant, OutputError, OutputLine, Pace, RequestState};
use scene::{JobId, MicroUsd, SceneId};
use store::jobs::{JobRow, RetryOutcome};
use store::lifecycle::JobState;
use store::scenes::{SceneRow, SubmitOutcome};
use store::{DEFAULT_TENANT, Outage, Store, StoreError};

/// Changes in quick succession are handled together.
const BUNDLED_CHANGES: Duration = Duration::from_millis(20);

/// The progress is shown again at least this often.
const TICK: Duration = Duration::from_secs(1);

/// Follows the requests of a batch.
pub(super) struct Engine<'a> {
    pub(super) store: &'a Store,
    pub(super) checker: &'a Checker,
    pub(super) bundles: &'a Bundles,
    pub(super) stock: Stock,
    pub(super) records: Records,
    pub(super) money: Money,
    pub(super) report: Report,
    pub(super) retries_failed: bool,
    /// Requests that are in the queue at the same time.
    pub(super) window: usize,
    pub(super) active: BTreeMap<JobId, ActiveRequest>,
    /// A request that waits for money.
    pub(super) deferred: Option<BatchRequest>,
    /// Requests that came to their end in this run, which began at `started`.
    pub(super) finished: u64,
    pub(super) started: Instant,
}

/// A request in the queue, or being worked on.
pub(super) struct ActiveRequest {
    custom_id: String,
    scene_id: SceneId,
    state: RequestState,
    promised: MicroUsd,
}

/// End of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Ending {
    /// Every request came to its end.
    Complete,
    /// The user stopped it.
    Stopped,
    /// The storage takes no writes.
    Storage(Outage),
}

impl Engine<'_> {
    /// Runs the worker until everything is done, or until `stop`; then running stages finish and commit.
    pub(super) async fn run(
        &mut self,
        source: &Source,
        worker: Worker,
        stop: &CancellationToken,
    ) -> Result<Ending, Failure> {
        let draining = CancellationToken::new();
        let mut worker = tokio::spawn(worker.run(draining.clone()));
        let ending = self.follow(source, &mut worker, stop).await;
        draining.cancel();
        if !worker.is_finished() {
            // An error of the worker is of no interest any more.
            let _ = worker.await;
        }
        let ending = ending?;
        // Some ended while the worker drained.
        self.collect().await?;
        Ok(ending)
    }

    async fn follow(
        &mut self,
        source: &Source,
        worker: &mut JoinHandle<Result<(), StoreError>>,
        stop: &CancellationToken,
    ) -> Result<Ending, Failure> {
        let (mut changes, mut outage) = (self.store.changes(), self.store.outage());
        let todo = std::mem::take(&mut self.stock.todo);
        let mut requests = source
            .entries()?
            .zip(todo)
            .filter(|(_, is_todo)| *is_todo)
            .map(|(entry, _)| entry?.content.map_err(|wrong| changed(&source.shown(&wrong.error))));
        let mut is_exhausted = false;
        loop {
            changes.mark_unchanged();
            while !is_exhausted && self.active.len() < self.window && !stop.is_cancelled() {
                let next = match self.deferred.take() {
                    Some(request) => Some(request),
                    None => requests.next().transpose()?,
                };
                match next {
                    None => is_exhausted = true,
                    Some(request) => self.begin(request).await?,
                }
                if self.deferred.is_some() {
                    break;
                }
            }
            let before = self.active.len();
            self.collect().await?;
            self.report.show(&self.stock.counts, self.pace());
            if is_exhausted && self.active.is_empty() {
                return Ok(Ending::Complete);
            }
            if self.active.len() < before && !is_exhausted && !stop.is_cancelled() {
                continue;
            }
            tokio::select! {
                biased;
                () = stop.cancelled() => return Ok(Ending::Stopped),
                Ok(why) = outage.wait_for(Option::is_some) => {
                    return Ok(Ending::Storage(why.unwrap_or(Outage::Other)));
                }
                ended = &mut *worker => return Err(worker_ended(ended)),
                _ = changes.changed() => tokio::time::sleep(BUNDLED_CHANGES).await,
                () = tokio::time::sleep(TICK) => {}
            }
        }
    }

    /// Puts a request into the queue, finds the job of an earlier run, or defers it until there is money.
    async fn begin(&mut self, request: BatchRequest) -> Result<(), Failure> {
        let digest = request.digest();
        if let Some(scene_id) = self.stock.known.get(&digest).cloned()
            && let Some(job_id) = self.earlier_job(&scene_id).await?
        {
            let mut promised = MicroUsd::ZERO;
            if self.money.is_limited() {
                let spending = self.store.spending(&DEFAULT_TENANT, &scene_id).await.map_err(failed)?;
                promised = MicroUsd(spending.budget);
                self.money.note_promise(promised);
            }
            self.follow_job(job_id, scene_id, request.custom_id, promised);
            return Ok(());
        }
        let wanted = request.body.options.budget(self.checker.usual_budget_usd());
        let granted = match self.money.promise(wanted) {
            Grant::Granted(granted) => granted,
            Grant::Wait => {
                self.deferred = Some(request);
                return Ok(());
            }
            Grant::Exhausted => {
                let message =
                    "the budget of the batch is spent; give the same command with a larger --budget";
                return self.end_early(
                    request,
                    RequestState::Failed,
                    OutputError::new("batch_budget_spent", message),
                );
            }
        };
        let submission = match self.checker.submission(&request) {
            Ok(submission) => submission,
            // It was valid a moment ago; an image may have changed since.
            Err(error) => {
                self.money.settle(granted, MicroUsd::ZERO);
                return self.end_early(request, RequestState::Invalid, error);
            }
        };
        let key = Some(format!("batch:{digest}"));
        let usual = self.checker.usual_budget_usd();
        let tenant_id = DEFAULT_TENANT.clone();
        let mut row = submission.into_row(self.store, tenant_id, usual, key).await.map_err(failed)?;
        row.budget_micro_usd = granted.0;
        row.labels.insert(REQUEST_LABEL.to_owned(), digest.to_string());
        row.labels.entry("custom_id".to_owned()).or_insert_with(|| request.custom_id.clone());
        match self.store.submit(row).await.map_err(failed)? {
            SubmitOutcome::Created { scene_id, job_id, .. }
            | SubmitOutcome::Replayed { scene_id, job_id } => {
                self.follow_job(job_id, scene_id, request.custom_id, granted);
                Ok(())
            }
            SubmitOutcome::KeyReused | SubmitOutcome::Refused(_) => {
                let message = format!("the request {:?} could not be submitted; a bug", request.custom_id);
                Err(Failure::new(Exit::Error, message))
            }
        }
    }

    /// The job of a scene of an earlier run, or a new one if it failed and is to be retried; `None` if there is none.
    async fn earlier_job(&self, scene_id: &SceneId) -> Result<Option<JobId>, Failure> {
        let Some(job) = self.store.latest_job(&DEFAULT_TENANT, scene_id).await.map_err(failed)? else {
            return Ok(None);
        };
        let has_failed = matches!(job.state, JobState::Failed | JobState::Cancelled);
        if !(self.retries_failed && has_failed) {
            return Ok(Some(job.id));
        }
        Ok(Some(match self.store.retry(&DEFAULT_TENANT, &job.id, None).await.map_err(failed)? {
            RetryOutcome::Created { job_id, .. } => job_id,
            _ => job.id,
        }))
    }

    fn follow_job(&mut self, job_id: JobId, scene_id: SceneId, custom_id: String, promised: MicroUsd) {
        let state = RequestState::Pending;
        self.active.insert(job_id, ActiveRequest { custom_id, scene_id, state, promised });
    }

    fn end_early(
        &mut self,
        request: BatchRequest,
        state: RequestState,
        error: OutputError,
    ) -> Result<(), Failure> {
        self.stock.counts.change(RequestState::Pending, state);
        let line = OutputLine::not_computed(Some(request.custom_id), state, error);
        self.records.write(&line)?;
        self.report.ended(&line, &self.stock.counts);
        Ok(())
    }

    /// Notes the states of all jobs in the window, and ends those that came to their end.
    async fn collect(&mut self) -> Result<(), Failure> {
        let ids: Vec<JobId> = self.active.keys().cloned().collect();
        let heads = self.store.event_heads(&DEFAULT_TENANT, &ids).await.map_err(failed)?;
        for head in heads {
            let state = match head.state {
                JobState::Queued => RequestState::Pending,
                JobState::Running | JobState::Cancelling => RequestState::Running,
                JobState::Succeeded | JobState::Failed | JobState::Cancelled => {
                    self.end(&head.job_id).await?;
                    continue;
                }
            };
            if let Some(request) = self.active.get_mut(&head.job_id) {
                self.stock.counts.change(request.state, state);
                request.state = state;
            }
        }
        Ok(())
    }

    async fn end(&mut self, job_id: &JobId) -> Result<(), Failure> {
        let job = self.store.job(&DEFAULT_TENANT, job_id).await.map_err(failed)?;
        let Some(request) = self.active.get(job_id) else { return Ok(()) };
        let scene = self.store.scene(&DEFAULT_TENANT, &request.scene_id).await.map_err(failed)?;
        let (Some(job), Some(scene)) = (job, scene) else {
            let message = format!("the rows of the request {:?} are gone", request.custom_id);
            return Err(Failure::new(Exit::Error, message));
        };
        // The bundle first: a line states what is there.
        let line = line_of(self.store, self.bundles, &request.custom_id, &scene, &job).await?;
        if self.money.is_limited() {
            let spending = self.store.spending(&DEFAULT_TENANT, &scene.id).await.map_err(failed)?;
            self.money.settle(request.promised, MicroUsd(spending.spent));
        }
        self.stock.counts.change(request.state, line.state);
        self.active.remove(job_id);
        self.finished += 1;
        self.records.write(&line)?;
        self.report.ended(&line, &self.stock.counts);
        Ok(())
    }

    fn pace(&self) -> Pace {
        Pace { finished: self.finished, elapsed: self.started.elapsed() }
    }

    /// Results of the run so far.
    pub(super) fn summary(&self, out: &Path) -> Summary {
        Summary {
            counts: self.stock.counts,
            pace: self.pace(),
            spent: self.money.spent(),
            out: out.to_owned(),
        }
    }
}

/// A request that was valid when the file was read first.
fn changed(shown: &str) -> Failure {
    let advice = "the file changed while the batch ran; give the same command again";
    Failure::new(Exit::Error, format!("{shown}; {advice}"))
}

fn worker_ended(ended: Result<Result<(), StoreError>, tokio::task::JoinError>) -> Failure {
    let reason = match ended {
        Ok(Ok(())) => "without a reason".to_owned(),
        Ok(Err(error)) => error.chain(),
        Err(died) => died.to_string(),
    };
    AppError::WorkerEnded { reason }.into()
}

/// The line of a request whose job came to its end; writes its bundle if it is not there.
pub(super) async fn line_of(
    store: &Store,
    bundles: &Bundles,
    custom_id: &str,
    scene: &SceneRow,
    job: &JobRow,
) -> Result<OutputLine, Failure> {
    let stages = store.stages(&DEFAULT_TENANT, &job.id).await.map_err(failed)?;
    let computed = stages.iter().filter(|stage| stage.runs > 0).filter_map(|stage| stage.elapsed_ms);
    let stages_ms: i64 = computed.sum();
    let mut line = OutputLine {
        custom_id: Some(custom_id.to_owned()),
        scene_id: Some(scene.id.to_string()),
        state: RequestState::Failed,
        verdict: scene.verdict.clone(),
        bundle: None,
        error: None,
        stages_s: stages_ms as f64 / 1000.0,
        attempts: u64::try_from(job.epoch).unwrap_or(0),
        duplicate_of: None,
    };
    if job.state != JobState::Succeeded {
        let is_cancelled = job.state == JobState::Cancelled;
        line.state = if is_cancelled { RequestState::Cancelled } else { RequestState::Failed };
        let code = job.failure_code.as_deref().or(scene.failure_code.as_deref()).unwrap_or("failed");
        let message = job.failure_message.as_deref().or(scene.failure_message.as_deref()).unwrap_or_default();
        line.error = Some(OutputError::new(code, message));
        return Ok(line);
    }
    line.bundle = bundles.write(store, custom_id, scene).await?;
    let passed = scene.verdict.as_deref() == Some("pass");
    if !passed {
        let message = scene.failure_message.as_deref().unwrap_or("the certificate says quarantine");
        line.error = Some(OutputError::new("quarantined", message));
    }
    line.state = match (&line.bundle, passed) {
        (Some(_), true) => RequestState::Succeeded,
        (_, false) => RequestState::Quarantined,
        (None, true) => {
            let message = "the stored bundle is gone; delete the data directory and run the batch again";
            line.error = Some(OutputError::new("bundle_missing", message));
            RequestState::Failed
        }
    };
    Ok(line)
}
