//! One attempt at one job: builds the scene and records the outcome.

use std::sync::Arc;
use std::time::{Duration, Instant};

use tracing::{Instrument, Span};
use uuid::Uuid;

use super::heartbeat::{Heartbeat, StopReason};
use super::{BuildScene, JobContext, Settings, backoff};
use crate::pipeline::checkpoint::{CancelFlag, JobScope, StageRuntime};
use crate::pipeline::error::StageError;
use crate::spans;
use scene::job::{Failure, FailureClass, JobState, SceneRequest};
use store::queue::{AttemptOutcome, Claim};
use store::{Lease, Store, StoreError};

pub(super) struct JobAttempt {
    pub(super) store: Store,
    pub(super) runtime: StageRuntime,
    pub(super) build: BuildScene,
    pub(super) settings: Arc<Settings>,
    pub(super) heartbeat: Heartbeat,
}

impl JobAttempt {
    /// Works on the claimed job until the attempt ends.
    pub(super) async fn run(self, claim: Claim) {
        let lease = claim.lease.clone();
        let span = spans::job(&lease.job_id, &claim.scene_id, lease.epoch, claim.attempt);
        async {
            let started = Instant::now();
            if let Some(outcome) = self.outcome(claim).await {
                self.finish(&lease, outcome, started).await;
            }
        }
        .instrument(span)
        .await;
    }

    /// Builds the scene; `None` when another worker holds the job by now.
    async fn outcome(&self, claim: Claim) -> Option<AttemptOutcome> {
        let request: SceneRequest = match serde_json::from_value(claim.request.clone()) {
            Ok(request) => request,
            Err(error) => {
                tracing::error!(%error, "the stored request cannot be read");
                return Some(AttemptOutcome::Failed(Failure {
                    class: FailureClass::Permanent,
                    code: "request_unreadable".into(),
                    message: "the stored request belongs to another version; submit it again".into(),
                }));
            }
        };
        let (cancel, drain) = (CancelFlag::default(), CancelFlag::default());
        let job_id = claim.lease.job_id.clone();
        self.heartbeat.watch(claim.lease.clone(), cancel.clone(), drain.clone(), claim.time_left);
        let checkpoints = self.runtime.open(JobScope {
            lease: claim.lease,
            tenant_id: claim.tenant_id,
            salt: claim.salt,
            cancel: cancel.clone(),
            drain,
        });
        let context =
            JobContext { job_id: job_id.clone(), scene_id: claim.scene_id, request, checkpoints, cancel };
        // A task of its own: a panic in the pipeline is an outcome, not the end of the worker.
        let built = tokio::spawn((self.build)(context).in_current_span()).await;
        let stopped = self.heartbeat.release(&job_id);
        let error = match built {
            Ok(Ok(built)) => return Some(AttemptOutcome::Built(Box::new(built))),
            Ok(Err(error)) => error,
            Err(died) => StageError::crashed("the pipeline panicked").because(died),
        };
        if let Some(outcome) = backoff::outcome_of(&error, claim.attempt, jitter(), &self.settings) {
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

    /// Writes the outcome down. A store that does not answer is tried a few times; then the lease runs
    /// out and another worker continues from the last checkpoint.
    async fn finish(&self, lease: &Lease, outcome: AttemptOutcome, started: Instant) {
        for pause_ms in [100, 1000, 5000] {
            match self.store.finish(lease, outcome.clone()).await {
                Ok(state) => {
                    count(state, &outcome, started.elapsed());
                    Span::current().record("state", state.as_str());
                    tracing::info!(%state, "the job's attempt is over");
                    return;
                }
                Err(StoreError::LeaseLost { .. }) => {
                    metrics::counter!("tabletopgen_lease_losses_total").increment(1);
                    tracing::warn!("the lease was lost; the result is dropped");
                    return;
                }
                Err(error) => tracing::debug!(error = error.chain(), "cannot finish the job; trying again"),
            }
            tokio::time::sleep(Duration::from_millis(pause_ms)).await;
        }
        tracing::warn!("the outcome of the job's attempt could not be recorded; its lease will expire");
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
