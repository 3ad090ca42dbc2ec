//! The feeder of a running service: it puts requests of batches into the queue, a few at a time.
//!
//! It keeps nothing in memory, and each of its steps is one transaction, so any number of processes may feed the same
//! batches, and any of them may die at any time.

use std::time::Duration;

use tokio_util::sync::CancellationToken;

use crate::background::kept_running;
use crate::config::Config;
use store::batches::FeedRules;
use store::{Store, StoreError};

/// Changes in quick succession are handled together.
const BUNDLED_CHANGES: Duration = Duration::from_millis(20);

/// Feeds from now on until `shutdown`.
pub fn start(store: &Store, config: &Config, shutdown: &CancellationToken) {
    let rules = FeedRules {
        queue: config.queue.clone(),
        window: config.batches.window,
        counts_money: config.calls_remote_models(),
    };
    let poll = Duration::from_millis(config.worker.poll_ms);
    let (store, shutdown) = (store.clone(), shutdown.clone());
    let feed = move || feed_until_shutdown(store.clone(), rules.clone(), poll, shutdown.clone());
    tokio::spawn(kept_running("feeder of batches", feed));
}

async fn feed_until_shutdown(store: Store, rules: FeedRules, poll: Duration, shutdown: CancellationToken) {
    let mut changes = store.changes();
    while !shutdown.is_cancelled() {
        changes.mark_unchanged();
        match feed(&store, &rules).await {
            Ok(()) => {}
            // The store itself reports outages, once.
            Err(error) if error.outage().is_some() => {}
            Err(error) => {
                tracing::error!(error = error.chain(), "cannot feed the batches; trying again later")
            }
        }
        tokio::select! {
            () = shutdown.cancelled() => {}
            _ = changes.changed() => tokio::time::sleep(BUNDLED_CHANGES).await,
            () = tokio::time::sleep(poll) => {}
        }
    }
}

/// Feeds each batch once; one of many items takes no longer than the others.
async fn feed(store: &Store, rules: &FeedRules) -> Result<(), StoreError> {
    let mut batches = store.active_batches().await?;
    while !batches.is_empty() {
        let mut unfinished = Vec::new();
        for batch in batches {
            let fed = store.feed_batch(&batch, rules.clone()).await?;
            if fed.submitted > 0 || fed.settled > 0 {
                tracing::debug!(batch_id = %batch, submitted = fed.submitted, settled = fed.settled, "fed a batch");
            }
            if fed.has_more {
                unfinished.push(batch);
            }
        }
        batches = unfinished;
    }
    Ok(())
}
