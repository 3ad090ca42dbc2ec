//! The worker: claim a job, build its scene, finish it.
//!
//! Every process start is a new owner. While a job runs, the heartbeat (a thread of its own, so no
//! computation can starve it) extends the lease, hears of cancellations, deadlines and lost leases, and
//! stops the build through its interrupt. Shutting down stops claiming, lets running stages finish and
//! commit, and gives jobs back uncharged. Where one process owns the database, every lease at start belongs
//! to a dead process, so those jobs are taken over at once; where several share it, leases run out. Every
//! worker returns jobs of dead workers to the queue, also while all of its own slots are busy.

pub mod build;
pub mod backoff;
pub(crate) mod verdict;
mod heartbeat;
mod attempt;
mod rescue;

use std::sync::Arc;
use std::time::Duration;

use serde::{Deserialize, Serialize};
use tokio::sync::{Semaphore, watch};
use tokio_util::sync::CancellationToken;
use tokio_util::task::TaskTracker;
use uuid::Uuid;

use crate::pipeline::checkpoint::StageRuntime;
use scene::JobId;
use store::{Outage, Store, StoreError};

pub use build::{BuildScene, BuiltScene, JobContext};

use heartbeat::Heartbeat;

/// Section `[worker]`.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct Settings {
    /// Jobs worked on at the same time (1..=64). More overlaps waiting; the CPU pool is shared.
    pub concurrency: usize,
    /// Threads of the CPU pool; 0 = one per core. Does not change results.
    pub cpu_threads: usize,
    /// Instances of one stage worked on at the same time (1..=64). Does not change results.
    pub fan_out: usize,
    /// How long a claim lasts without a heartbeat, seconds (5..=3600). More leaves a dead worker's job
    /// waiting longer; less risks taking a slow worker's job away.
    pub lease_secs: u64,
    /// Time between heartbeats, seconds; at most a third of the lease.
    pub heartbeat_secs: u64,
    /// Longest sleep before the queue is polled again, milliseconds.
    pub poll_ms: u64,
    /// Tries since the last new checkpoint before a job that keeps failing is failed (1..=100).
    pub max_attempts: u32,
    /// Times that the process may die while a job runs alone in it, since the job's last new checkpoint, before
    /// the job is failed (1..=100).
    pub max_deaths: u32,
    /// Mean of the first retry's delay is half of this, milliseconds; it doubles with every attempt.
    pub backoff_base_ms: u64,
    /// Largest delay of a retry, milliseconds.
    pub backoff_cap_ms: u64,
    /// How long a shutdown waits for running stages to finish before it interrupts them, seconds.
    pub drain_grace_secs: u64,
    /// Longest time one stage (of one instance) may take, seconds.
    pub stage_timeout_secs: u64,
    /// Address of the probes of a process without the HTTP interface; empty = none.
    pub listen: String,
}

/// How long a shutdown waits for interrupted stages to end.
const INTERRUPT_GRACE: Duration = Duration::from_secs(10);

/// Takes jobs from the store and builds them.
#[derive(Clone)]
pub struct Worker {
    store: Store,
    runtime: StageRuntime,
    build: BuildScene,
    settings: Arc<Settings>,
    owner: Arc<str>,
    only: Option<JobId>,
}

impl Worker {
    pub fn new(store: Store, runtime: StageRuntime, build: BuildScene, settings: Settings) -> Self {
        let owner = Uuid::new_v4().to_string();
        Self { store, runtime, build, settings: Arc::new(settings), owner: owner.into(), only: None }
    }

    /// The name of this process in the rows that it holds.
    pub fn owner(&self) -> &str {
        &self.owner
    }

    /// A worker that takes this job and leaves every other alone.
    pub fn only(mut self, job_id: &JobId) -> Self {
        self.only = Some(job_id.clone());
        self
    }

    /// Works until `shutdown`, then drains.
    pub async fn run(self, shutdown: CancellationToken) -> Result<(), StoreError> {
        let Some(orphans) = self.take_over(&shutdown).await? else { return Ok(()) };
        if orphans > 0 {
            tracing::info!(orphans, "taking over jobs of a worker that died");
        }
        let _rescuer = rescue::start(self.store.clone(), self.settings.clone());
        let heartbeat = Heartbeat::start(
            self.store.clone(),
            Duration::from_secs(self.settings.lease_secs),
            Duration::from_secs(self.settings.heartbeat_secs),
        )?;
        let slots = Arc::new(Semaphore::new(self.settings.concurrency.max(1)));
        metrics::gauge!("tabletopgen_worker_slots").set(slots.available_permits() as f64);
        let attempts = TaskTracker::new();
        let mut failed_claims = 0;
        loop {
            let slot = tokio::select! {
                biased;
                () = shutdown.cancelled() => break,
                slot = slots.clone().acquire_owned() => match slot {
                    Ok(slot) => slot,
                    Err(_) => break,
                },
            };
            let mut changes = self.store.changes();
            let lease = Duration::from_secs(self.settings.lease_secs);
            let only = self.only.as_ref();
            let mut pause = Duration::from_millis(self.settings.poll_ms);
            match self.store.claim(&self.owner, lease, self.settings.max_deaths, only).await {
                Ok(Some(claim)) => {
                    let attempt = attempt::JobAttempt {
                        store: self.store.clone(),
                        runtime: self.runtime.clone(),
                        build: self.build.clone(),
                        settings: self.settings.clone(),
                        heartbeat: heartbeat.clone(),
                    };
                    count_claim("claimed");
                    attempts.spawn(async move {
                        metrics::gauge!("tabletopgen_worker_slots_used").increment(1.0);
                        attempt.run(claim).await;
                        metrics::gauge!("tabletopgen_worker_slots_used").decrement(1.0);
                        drop(slot);
                    });
                    failed_claims = 0;
                    continue;
                }
                Ok(None) => {
                    count_claim("empty");
                    failed_claims = 0;
                }
                Err(error) => {
                    count_claim("failed");
                    failed_claims += 1;
                    pause = pause.max(backoff::full_delay(failed_claims, &self.settings));
                    // The store itself reports outages, once.
                    if error.outage().is_none() {
                        let (error, pause_secs) = (error.chain(), pause.as_secs_f32());
                        tracing::error!(error, pause_secs, "cannot claim a job; trying again later");
                    }
                }
            }
            drop(slot);
            tokio::select! {
                () = shutdown.cancelled() => break,
                () = self.something_new(&mut changes, failed_claims > 0) => {}
                () = tokio::time::sleep(pause) => {}
            }
        }
        self.drain(&heartbeat, attempts).await;
        Ok(())
    }

    /// Ends the leases of workers that died, as soon as storage takes writes; `None` if stopped before.
    async fn take_over(&self, shutdown: &CancellationToken) -> Result<Option<u64>, StoreError> {
        let mut failed = 0;
        loop {
            match self.store.expire_leases_of_others(&self.owner).await {
                // The store itself reports outages, once.
                Err(error) if error.outage().is_some() => failed += 1,
                found => return found.map(Some),
            }
            tokio::select! {
                () = shutdown.cancelled() => return Ok(None),
                () = tokio::time::sleep(backoff::full_delay(failed, &self.settings)) => {}
            }
        }
    }

    /// Returns when it is worth looking at the queue again: a job may be claimed, or an outage ended.
    async fn something_new(&self, changes: &mut watch::Receiver<u64>, claims_fail: bool) {
        if !claims_fail {
            // An error means that the store is gone; then the pause decides. Most changes are of jobs that run.
            while changes.changed().await.is_ok() {
                if !matches!(self.store.has_work().await, Ok(false)) {
                    return;
                }
            }
            std::future::pending::<()>().await;
        }
        let mut outage = self.store.outage();
        if outage.wait_for(Option::<Outage>::is_some).await.is_err()
            || outage.wait_for(Option::<Outage>::is_none).await.is_err()
        {
            std::future::pending::<()>().await;
        }
    }

    /// Running stages finish and commit; those that take too long are interrupted; every job is given
    /// back. What does not stop even then is left to the lease.
    async fn drain(&self, heartbeat: &Heartbeat, attempts: TaskTracker) {
        attempts.close();
        if !attempts.is_empty() {
            tracing::info!(jobs = attempts.len(), "draining");
        }
        heartbeat.drain();
        let grace = Duration::from_secs(self.settings.drain_grace_secs);
        if tokio::time::timeout(grace, attempts.wait()).await.is_err() {
            heartbeat.cancel_all();
            if tokio::time::timeout(INTERRUPT_GRACE, attempts.wait()).await.is_err() {
                tracing::warn!(
                    jobs = attempts.len(),
                    "stages ignored the interrupt; their leases will run out"
                );
            }
        }
    }
}

fn count_claim(outcome: &'static str) {
    metrics::counter!("tabletopgen_claims_total", "outcome" => outcome).increment(1);
}
