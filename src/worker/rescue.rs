//! Returns jobs of dead workers to the queue, at a steady pace.
//!
//! A worker whose slots are all busy claims nothing, and one of its jobs may wait for a stage that a dead worker's job
//! claimed. So this does not depend on free slots.

use std::sync::Arc;
use std::time::Duration;

use tokio_util::task::AbortOnDropHandle;

use super::Settings;
use crate::background::kept_running;
use store::Store;

/// Starts the task; dropping the handle ends it.
pub(super) fn start(store: Store, settings: Arc<Settings>) -> AbortOnDropHandle<()> {
    let rescue = move || rescue(store.clone(), settings.clone());
    AbortOnDropHandle::new(tokio::spawn(kept_running("rescue of jobs", rescue)))
}

async fn rescue(store: Store, settings: Arc<Settings>) {
    let pause = Duration::from_millis(settings.poll_ms);
    loop {
        tokio::time::sleep(pause).await;
        match store.rescue(settings.max_deaths).await {
            Ok(0) => {}
            Ok(jobs) => tracing::info!(jobs, "leases ran out; the jobs are back in the queue"),
            // The store itself reports outages, once.
            Err(error) if error.outage().is_some() => tracing::debug!(%error, "cannot rescue jobs"),
            Err(error) => tracing::error!(error = error.chain(), "cannot rescue jobs"),
        }
    }
}
