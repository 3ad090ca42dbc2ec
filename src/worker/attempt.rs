//! One attempt at one job: carries the work out and records the outcome.

use std::sync::Arc;
use std::time::{Duration, Instant};

use tracing::{Instrument, Span};
use uuid::Uuid;

use super::heartbeat::{Heartbeat, StopReason};
use super::work::{Work, WorkAttempt};
use super::{Settings, backoff};
use crate::pipeline::checkpoint::CancelFlag;
use crate::pipeline::error::StageError;
use crate::spans;
use store::lifecycle::{Failure, FailureClass, JobState};
use store::queue::{AttemptOutcome, Claim};
use store::{Lease, Store, StoreError};

pub(super) struct JobAttempt {
    pub(super) store: Store,
    pub(super) work: Arc<dyn Work>,
    pub(super) settings: Arc<Settings>,
    pub(super) heartbeat: Heartbeat,
}

impl JobAttempt {
    /// Works on the claimed job until the attempt ends.
    pub(super) async fn run(self, claim: Claim) {
        let (lease, work) = (claim.lease.clone(), claim.work.clone());
        let span = spans::job(&claim);
        async {
            let started = Instant::now();
            if let Some(outcome) = self.outcome(claim).await
                && self.finish(&lease, outcome, started).await.is_some_and(JobState::is_final)
            {
                self.work.ended(&work);
            }
        }
        .instrument(span)
        .await;
    }

    /// Carries the work out; `None` when another worker holds the job by now.
    async fn outcome(&self, claim: Claim) -> Option<AttemptOutcome> {
        let (cancel, drain) = (CancelFlag::default(), CancelFlag::default());
        let (job_id, number) = (claim.lease.job_id.clone(), claim.attempt);
        self.heartbeat.watch(claim.lease.clone(), cancel.clone(), drain.clone(), claim.time_left);
        let attempt = WorkAttempt { claim, cancel, drain };
        // A task of its own: a panic in the work is an outcome, not the end of the worker.
        let worked = tokio::spawn(self.work.clone().run(attempt).in_current_span()).await;
        let stopped = self.heartbeat.release(&job_id);
        let error = match worked {
            Ok(Ok(outcome)) => return Some(outcome),
            Ok(Err(error)) => error,
            Err(died) => {
                let message = "a bug stopped the work on this job; the server's log has the details";
                StageError { code: "internal_error", ..StageError::crashed(message).because(died) }
            }
        };
        if let Some(outcome) = backoff::outcome_of(&error, number, jitter(), &self.settings) {
            tracing::warn!(code = error.code, error = error.chain(), "the job's attempt failed");
            return Some(outcome);
        }
        match stopped {
            Some(StopReason::Cancelled) => Some(AttemptOutcome::Stopped),
            Some(StopReason::DeadlinePassed) => Some(AttemptOutcome::Failed(Failure::deadline_passed())),
            Some(StopReason::Draining) => Some(AttemptOutcome::Released),
            Some(StopReason::LeaseLost) => {
                metrics::counter!("tabletopgen_lease_losses_total").increment(1);
                tracing::warn!("the lease was lost; leaving the job alone");
                None
            }
            // Cancelled between two heartbeats, or a bug: the store's fence and table decide.
            None => Some(AttemptOutcome::Retry {
                failure: Failure {
                    class: FailureClass::Transient,
                    code: "stopped_early".into(),
                    message: "the job stopped without a reason; trying again".into(),
                },
                delay: Duration::ZERO,
                charged: true,
                max_attempts: self.settings.max_attempts,
            }),
        }
    }

    /// Writes the outcome down; the job's state then, `None` if it is not this worker's to say. A store that does not
    /// answer is tried a few times; then the lease runs out and another worker continues from the last checkpoint.
    async fn finish(&self, lease: &Lease, outcome: AttemptOutcome, started: Instant) -> Option<JobState> {
        for pause_ms in [100, 1000, 5000] {
            match self.store.finish(lease, outcome.clone()).await {
                Ok(state) => {
                    count(state, &outcome, started.elapsed());
                    Span::current().record("state", state.as_str());
                    tracing::info!(%state, "the job's attempt is over");
                    return Some(state);
                }
                Err(StoreError::LeaseLost { .. }) => {
                    metrics::counter!("tabletopgen_lease_losses_total").increment(1);
                    tracing::warn!("the lease was lost; the result is dropped");
                    return None;
                }
                Err(error) => tracing::debug!(error = error.chain(), "cannot finish the job; trying again"),
            }
            tokio::time::sleep(Duration::from_millis(pause_ms)).await;
        }
        tracing::warn!("the outcome of the job's attempt could not be recorded; its lease will expire");
        None
    }
}

/// Counts a recorded attempt, and its job if that has ended.
fn count(state: JobState, outcome: &AttemptOutcome, duration: Duration) {
    metrics::counter!("tabletopgen_job_attempts_total", "state" => state.as_str()).increment(1);
    metrics::histogram!("tabletopgen_job_attempt_seconds", "state" => state.as_str())
        .record(duration.as_secs_f64());
    if !state.is_final() {
        return;
    }
    let class = match outcome {
        AttemptOutcome::Failed(failure) | AttemptOutcome::Retry { failure, .. }
            if state == JobState::Failed =>
        {
            failure.class.as_str()
        }
        _ => "",
    };
    metrics::counter!("tabletopgen_jobs_finished_total", "outcome" => state.as_str(), "class" => class)
        .increment(1);
}

/// Uniform in 0..1; not a seed of anything.
fn jitter() -> f64 {
    (Uuid::new_v4().as_u128() >> 75) as f64 / (1_u64 << 53) as f64
}
