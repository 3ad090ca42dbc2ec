//! The freezer of a running service.

use std::path::Path;
use std::time::Duration;

use tokio_util::sync::CancellationToken;

use crate::config::Config;
use crate::freezer::Freezer;
use store::Store;

/// Freezes and verifies datasets from now on until `shutdown`, in a folder of `data_dir`.
pub fn start(store: &Store, config: &Config, data_dir: &Path, shutdown: &CancellationToken) {
    let lease = Duration::from_secs(config.worker.lease_secs);
    let poll = Duration::from_millis(config.worker.poll_ms);
    tokio::spawn(Freezer::new(store.clone(), data_dir, lease, poll).run(shutdown.clone()));
}
