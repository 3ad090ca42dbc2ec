//! The regular sweep of a running service.

use std::time::{Duration, Instant};

use tokio_util::sync::CancellationToken;

use crate::background::kept_running;
use crate::config::Config;
use store::Store;
use store::retention::RetentionSettings;

/// The first sweep after a start waits no longer than this, so that a service that restarts often sweeps too.
const FIRST_WAIT: Duration = Duration::from_secs(300);

/// Sweeps from now on until `shutdown`.
pub fn start(store: &Store, config: &Config, shutdown: &CancellationToken) {
    let (store, settings, shutdown) = (store.clone(), config.store.retention.clone(), shutdown.clone());
    let sweep = move || sweep_regularly(store.clone(), settings.clone(), shutdown.clone());
    tokio::spawn(kept_running("sweep", sweep));
}

/// Sweeps at the interval of the settings until the shutdown; returns at once if they want no sweeps.
async fn sweep_regularly(store: Store, settings: RetentionSettings, shutdown: CancellationToken) {
    if settings.sweep_interval_secs == 0 {
        return;
    }
    let interval = Duration::from_secs(settings.sweep_interval_secs);
    let mut wait = interval.min(FIRST_WAIT);
    while shutdown.run_until_cancelled(tokio::time::sleep(wait)).await.is_some() {
        wait = interval;
        // A little less than the interval, or half of the turns would come a moment too early.
        match store.takes_turn(interval.mul_f64(0.9)).await {
            Ok(true) => {}
            // Another process sweeps; or the store does not answer, which it reports itself.
            Ok(false) | Err(_) => continue,
        }
        let started = Instant::now();
        // A sweep can be broken off anywhere: every transaction and every removal stands alone.
        match shutdown.run_until_cancelled(store.sweep(&settings, false)).await {
            Some(Ok(Some(report))) => tracing::info!(
                stripped_scenes = report.stripped_scenes,
                purged_scenes = report.purged_scenes,
                emptied_batches = report.batches.emptied,
                emptied_datasets = report.datasets.emptied,
                emptied_recordings = report.recordings.emptied,
                purged_batches = report.batches.purged,
                purged_datasets = report.datasets.purged,
                purged_recordings = report.recordings.purged,
                removed_blobs = report.removed.blobs,
                removed_bytes = report.removed.bytes,
                kept_blobs = report.kept.blobs,
                kept_bytes = report.kept.bytes,
                seconds = started.elapsed().as_secs_f64(),
                "swept"
            ),
            Some(Ok(None)) => tracing::info!("a backup is under way; sweeping later"),
            // The store itself reports outages, once.
            Some(Err(error)) if error.outage().is_some() => {}
            Some(Err(error)) => {
                tracing::error!(error = error.chain(), "the sweep failed; trying again later")
            }
            None => return,
        }
    }
}
