//! The heartbeat: extends the leases of running jobs from a thread of its own, and stops a job whose
//! lease is lost, that was cancelled, whose deadline has passed, or whose worker shuts down.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use tokio_util::sync::{CancellationToken, DropGuard};

use crate::background::kept_running;
use crate::pipeline::checkpoint::CancelFlag;
use scene::JobId;
use store::lifecycle::JobState;
use store::{Lease, Store, StoreError};

/// Reason why a job's interrupt was raised.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum StopReason {
    Cancelled,
    DeadlinePassed,
    Draining,
    LeaseLost,
}

/// Handle on the heartbeat; cloning shares it, dropping the last one ends the thread.
#[derive(Clone)]
pub(super) struct Heartbeat {
    shared: Arc<Shared>,
    _stop: Arc<DropGuard>,
}

#[derive(Default)]
struct Shared {
    jobs: Mutex<Jobs>,
}

#[derive(Default)]
struct Jobs {
    running: BTreeMap<JobId, Running>,
    draining: bool,
}

struct Running {
    lease: Lease,
    cancel: CancelFlag,
    drain: CancelFlag,
    reason: Option<StopReason>,
    renewed: Instant,
    deadline: Option<Instant>,
}

impl Running {
    /// The first reason stays.
    fn stop(&mut self, reason: StopReason) {
        self.reason.get_or_insert(reason);
        self.cancel.cancel();
    }
}

impl Heartbeat {
    pub(super) fn start(store: Store, lease: Duration, interval: Duration) -> Result<Self, StoreError> {
        let shared = Arc::new(Shared::default());
        let stop = CancellationToken::new();
        let guard = stop.clone().drop_guard();
        let jobs = shared.clone();
        let failed = |source| StoreError::DataDir { path: "heartbeat thread".into(), source };
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().map_err(failed)?;
        std::thread::Builder::new()
            .name("heartbeat".into())
            .spawn(move || {
                let beat = move || beat(store.clone(), jobs.clone(), lease, interval, stop.clone());
                runtime.block_on(kept_running("heartbeat", beat));
            })
            .map_err(failed)?;
        Ok(Self { shared, _stop: Arc::new(guard) })
    }

    /// Takes a claimed job under care; `time_left` is the time until its deadline.
    pub(super) fn watch(
        &self,
        lease: Lease,
        cancel: CancelFlag,
        drain: CancelFlag,
        time_left: Option<Duration>,
    ) {
        let mut jobs = self.shared.lock();
        if jobs.draining {
            drain.cancel();
        }
        let renewed = Instant::now();
        let deadline = time_left.and_then(|time_left| renewed.checked_add(time_left));
        let running = Running { lease: lease.clone(), cancel, drain, reason: None, renewed, deadline };
        jobs.running.insert(lease.job_id, running);
    }

    /// Lets go of a job; says why it was stopped, if it was.
    pub(super) fn release(&self, job_id: &JobId) -> Option<StopReason> {
        let mut jobs = self.shared.lock();
        let draining = jobs.draining.then_some(StopReason::Draining);
        jobs.running.remove(job_id).and_then(|running| running.reason).or(draining)
    }

    /// From now on no job starts another stage.
    pub(super) fn drain(&self) {
        let mut jobs = self.shared.lock();
        jobs.draining = true;
        for running in jobs.running.values() {
            running.drain.cancel();
        }
    }

    /// Stops what is still running.
    pub(super) fn cancel_all(&self) {
        for running in self.shared.lock().running.values_mut() {
            running.stop(StopReason::Draining);
        }
    }
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, Jobs> {
        // A heartbeat that panicked is started again, and leases must go on.
        self.jobs.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

async fn beat(
    store: Store,
    shared: Arc<Shared>,
    lease: Duration,
    interval: Duration,
    stop: CancellationToken,
) {
    let mut cancellations = store.cancellations();
    loop {
        tokio::select! {
            () = stop.cancelled() => return,
            () = tokio::time::sleep(interval) => {}
            _ = cancellations.changed() => {}
        }
        let leases: Vec<Lease> =
            shared.lock().running.values().map(|running| running.lease.clone()).collect();
        if leases.is_empty() {
            continue;
        }
        let asked = Instant::now();
        // A store that hangs must not keep us from noticing that the lease has run out.
        let answer = tokio::time::timeout(lease, store.renew(leases, lease)).await;
        let mut jobs = shared.lock();
        match answer {
            Ok(Ok(states)) => {
                for (renewed, state) in states {
                    let Some(running) = jobs.running.get_mut(&renewed.job_id) else { continue };
                    // Claimed again by this very process meanwhile: not the lease that was asked about.
                    if running.lease != renewed {
                        continue;
                    }
                    match state {
                        Some(JobState::Cancelling) => {
                            running.renewed = asked;
                            running.stop(StopReason::Cancelled);
                        }
                        Some(_) => running.renewed = asked,
                        None => running.stop(StopReason::LeaseLost),
                    }
                }
            }
            // The store itself reports outages, once.
            Ok(Err(error)) if error.outage().is_some() => tracing::debug!(%error, "cannot extend leases"),
            Ok(Err(error)) => tracing::error!(error = error.chain(), "cannot extend leases"),
            Err(_) => tracing::error!("the store did not answer the heartbeat in time"),
        }
        let now = Instant::now();
        for running in jobs.running.values_mut() {
            if running.renewed.elapsed() > lease {
                running.stop(StopReason::LeaseLost);
            }
            if running.deadline.is_some_and(|deadline| deadline <= now) {
                running.stop(StopReason::DeadlinePassed);
            }
        }
    }
}
