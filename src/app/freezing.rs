//! The freezer of a running service.

use std::path::Path;
use std::sync::Arc;

use tokio_util::sync::CancellationToken;

use crate::background::kept_running;
use crate::config::Config;
use crate::freezer::Freezer;
use store::Store;

/// Freezes and verifies datasets from now on until `shutdown`, in a folder of `data_dir`, as `owner`.
pub fn start(store: &Store, config: &Config, data_dir: &Path, owner: &str, shutdown: &CancellationToken) {
    let freezer = Freezer::new(store.clone(), data_dir, owner, Arc::new(config.worker.clone()));
    let shutdown = shutdown.clone();
    tokio::spawn(kept_running("freezer of datasets", move || freezer.clone().run(shutdown.clone())));
}
