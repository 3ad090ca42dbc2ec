//! The worker: claim a job, carry it out, finish it. Everything that a request leaves for later is a job
//! (see [`work`]).
//!
//! Every process start is a new owner. While a job runs, the heartbeat (a thread of its own, so no
//! computation can starve it) extends the lease, hears of cancellations, deadlines and lost leases, and
//! stops the work through its interrupt. Shutting down stops claiming, lets running stages finish and
//! commit, and gives jobs back uncharged. Where one process owns the database, every lease at start belongs
//! to a dead process, so those jobs are taken over at once; where several share it, leases run out. Every
//! worker returns jobs of dead workers to the queue, also while all of its own slots are busy.

pub mod build;
pub mod work;
pub mod backoff;
mod heartbeat;
mod attempt;
mod rescue;
#[cfg(test)]
mod tests;

use std::sync::Arc;
use std::time::Duration;

use serde::{Deserialize, Serialize};
use tokio::sync::{Notify, OwnedSemaphorePermit, Semaphore, watch};
use tokio_util::sync::CancellationToken;
use tokio_util::task::TaskTracker;
use uuid::Uuid;

use scene::JobId;
use store::lifecycle::JobKind;
use store::queue::Scope;
use store::{Outage, Store, StoreError};

pub use build::{BuildScene, BuiltScene, JobContext, SceneBuilder};
pub use work::{Work, WorkAttempt};

use heartbeat::Heartbeat;

/// Section `[worker]`.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct Settings {
    /// Scenes built at the same time (1..=64). More overlaps waiting; the CPU pool is shared.
    pub concurrency: usize,
    /// Threads of the CPU pool; 0 = one per core. Does not change results.
    pub cpu_threads: usize,
    /// Instances of one stage worked on at the same time (1..=64). Does not change results.
    pub fan_out: usize,
    /// Time that a claim lasts without a heartbeat, seconds (5..=3600). More leaves a dead worker's job waiting longer;
    /// less risks taking a slow worker's job away.
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
    /// Time that a shutdown waits for running stages to finish before it interrupts them, seconds.
    pub drain_grace_secs: u64,
    /// Longest time one stage (of one instance) may take, seconds.
    pub stage_timeout_secs: u64,
    /// Address of the probes of a process without the HTTP interface; empty = none.
    pub listen: String,
}

impl Settings {
    /// Number of threads that compute.
    pub fn threads(&self) -> usize {
        match self.cpu_threads {
            0 => std::thread::available_parallelism().map_or(1, std::num::NonZero::get),
            threads => threads,
        }
    }
}

/// Time that a shutdown waits for interrupted stages to end.
const INTERRUPT_GRACE: Duration = Duration::from_secs(10);

/// A work with its slots.
#[derive(Clone)]
struct SlottedWork {
    work: Arc<dyn Work>,
    slots: Arc<Semaphore>,
}

/// Takes jobs from the store and carries them out.
#[derive(Clone)]
pub struct Worker {
    store: Store,
    works: Vec<SlottedWork>,
    settings: Arc<Settings>,
    owner: Arc<str>,
    only: Option<JobId>,
}

impl Worker {
    /// A worker that carries nothing out yet.
    pub fn new(store: Store, settings: Settings) -> Self {
        let owner = Uuid::new_v4().to_string();
        Self { store, works: Vec::new(), settings: Arc::new(settings), owner: owner.into(), only: None }
    }

    /// The same worker, which takes the jobs of this work, too.
    pub fn with(mut self, work: Arc<dyn Work>) -> Self {
        let slots = work.slots(&self.settings).clamp(1, Semaphore::MAX_PERMITS);
        self.works.push(SlottedWork { work, slots: Arc::new(Semaphore::new(slots)) });
        self
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
        for known in &self.works {
            let slots = known.slots.available_permits() as f64;
            metrics::gauge!("tabletopgen_worker_slots", "kind" => label(&*known.work)).set(slots);
        }
        let attempts = TaskTracker::new();
        // Notified when a slot becomes free.
        let freed = Arc::new(Notify::new());
        let mut failed_claims = 0;
        loop {
            let Some(scope) = self.free_scope() else {
                tokio::select! {
                    biased;
                    () = shutdown.cancelled() => break,
                    () = freed.notified() => continue,
                }
            };
            if shutdown.is_cancelled() {
                break;
            }
            let mut changes = self.store.changes();
            let lease = Duration::from_secs(self.settings.lease_secs);
            let mut pause = Duration::from_millis(self.settings.poll_ms);
            match self.store.claim(&self.owner, lease, self.settings.max_deaths, &scope).await {
                Ok(Some(claim)) => {
                    let Some((work, slot)) = self.slot_for(claim.work.kind()) else {
                        tracing::error!(
                            kind = claim.work.kind().as_str(),
                            "no slot for the job that was claimed"
                        );
                        break;
                    };
                    let attempt = attempt::JobAttempt {
                        store: self.store.clone(),
                        work,
                        settings: self.settings.clone(),
                        heartbeat: heartbeat.clone(),
                    };
                    count_claim("claimed");
                    let freed = freed.clone();
                    let used =
                        metrics::gauge!("tabletopgen_worker_slots_used", "kind" => label(&*attempt.work));
                    attempts.spawn(async move {
                        used.increment(1.0);
                        attempt.run(claim).await;
                        used.decrement(1.0);
                        drop(slot);
                        freed.notify_one();
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
            tokio::select! {
                () = shutdown.cancelled() => break,
                () = self.something_new(&mut changes, &scope, failed_claims > 0) => {}
                () = freed.notified() => {}
                () = tokio::time::sleep(pause) => {}
            }
        }
        self.drain(&heartbeat, attempts).await;
        Ok(())
    }

    /// The jobs that there are free slots for; `None` while there are none.
    fn free_scope(&self) -> Option<Scope> {
        let free = self.works.iter().filter(|known| known.slots.available_permits() > 0);
        let kinds: Vec<JobKind> = free.flat_map(|known| known.work.kinds()).copied().collect();
        let scope = match &self.only {
            Some(job_id) => Scope::Job(job_id.clone()),
            None => Scope::Kinds(kinds.clone()),
        };
        (!kinds.is_empty()).then_some(scope)
    }

    /// The work for jobs of a kind, with one of its slots.
    fn slot_for(&self, kind: JobKind) -> Option<(Arc<dyn Work>, OwnedSemaphorePermit)> {
        let known = self.works.iter().find(|known| known.work.kinds().contains(&kind))?;
        let slot = known.slots.clone().try_acquire_owned().ok()?;
        Some((known.work.clone(), slot))
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
    async fn something_new(&self, changes: &mut watch::Receiver<u64>, scope: &Scope, claims_fail: bool) {
        if !claims_fail {
            // An error means that the store is gone; then the pause decides. Most changes are of jobs that run.
            while changes.changed().await.is_ok() {
                if !matches!(self.store.has_work(scope).await, Ok(false)) {
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

/// The label of the metrics of a work: the first of its kinds.
fn label(work: &dyn Work) -> &'static str {
    work.kinds().first().map_or("", |kind| kind.as_str())
}

fn count_claim(outcome: &'static str) {
    metrics::counter!("tabletopgen_claims_total", "outcome" => outcome).increment(1);
}
