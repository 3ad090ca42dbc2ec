//! The feeder of a running service: it puts requests of batches into the queue, a few at a time, and gives those of
//! recipes their rows before.
//!
//! It keeps nothing in memory, and each of its steps is one transaction, so any number of processes may feed the same
//! batches, and any of them may die at any time.

use std::time::{Duration, Instant};

use tokio_util::sync::CancellationToken;

use crate::app::App;
use crate::app::batch_reading::BatchReader;
use crate::background::kept_running;
use crate::config::Config;
use scene::BatchId;
use store::batches::FeedRules;
use store::{Store, StoreError};

/// Changes in quick succession are handled together.
const BUNDLED_CHANGES: Duration = Duration::from_millis(20);

/// Requests of a recipe that get their rows together.
const EXPANDED_TOGETHER: usize = 200;

/// The feeder rests so many times as long as a round over the batches took.
const REST_PER_ROUND: u32 = 4;

/// Longest pause after a round.
const LONGEST_REST: Duration = Duration::from_secs(1);

/// Feeds from now on until `shutdown`.
pub fn start(store: &Store, app: &App, shutdown: &CancellationToken) {
    let config: &Config = app.config();
    let rules = FeedRules {
        queue: config.queue.clone(),
        window: config.batches.window,
        counts_money: config.calls_remote_models(),
    };
    let poll = Duration::from_millis(config.worker.poll_ms);
    let (feeder, shutdown) = (Feeder { store: store.clone(), app: app.clone(), rules }, shutdown.clone());
    let feed = move || feed_until_shutdown(feeder.clone(), poll, shutdown.clone());
    tokio::spawn(kept_running("feeder of batches", feed));
}

#[derive(Clone)]
struct Feeder {
    store: Store,
    app: App,
    rules: FeedRules,
}

async fn feed_until_shutdown(feeder: Feeder, poll: Duration, shutdown: CancellationToken) {
    let mut changes = feeder.store.changes();
    while !shutdown.is_cancelled() {
        changes.mark_unchanged();
        let began = Instant::now();
        match feed(&feeder).await {
            Ok(()) => {}
            // The store itself reports outages, once.
            Err(error) if error.outage().is_some() => {}
            Err(error) => {
                tracing::error!(error = error.chain(), "cannot feed the batches; trying again later")
            }
        }
        // A round asks for every batch, and with many that takes long; most changes are none of theirs.
        let rest = (REST_PER_ROUND * began.elapsed()).clamp(BUNDLED_CHANGES, LONGEST_REST);
        tokio::select! {
            () = shutdown.cancelled() => {}
            _ = changes.changed() => tokio::time::sleep(rest).await,
            () = tokio::time::sleep(poll) => {}
        }
    }
}

/// Feeds each batch once; one of many items takes no longer than the others. The feeder rests as long as it worked:
/// submissions and turns of other tenants wait for the same writer.
async fn feed(feeder: &Feeder) -> Result<(), StoreError> {
    let Feeder { store, rules, .. } = feeder;
    let mut batches = store.active_batches().await?;
    while !batches.is_empty() {
        let mut unfinished = Vec::new();
        for batch in batches {
            let began = Instant::now();
            let is_expanded = expand(feeder, &batch).await?;
            let fed = store.feed_batch(&batch, rules.clone()).await?;
            let is_fed = fed.submitted > 0 || fed.settled > 0;
            if is_fed {
                tracing::debug!(batch_id = %batch, submitted = fed.submitted, settled = fed.settled, "fed a batch");
            }
            if is_expanded || is_fed {
                tokio::time::sleep(began.elapsed().min(LONGEST_REST)).await;
            }
            if fed.has_more {
                unfinished.push(batch);
            }
        }
        batches = unfinished;
    }
    Ok(())
}

/// Gives requests of a recipe their rows, where few of the batch wait. Whether it did.
async fn expand(Feeder { store, app, rules }: &Feeder, batch: &BatchId) -> Result<bool, StoreError> {
    let Some(rest) = store.recipe_to_expand(batch, rules.window).await? else { return Ok(false) };
    let reader = BatchReader { app: app.clone() };
    let expanding = tokio::task::spawn_blocking(move || {
        let (items, is_last) = reader.expand(&rest, EXPANDED_TOGETHER);
        (rest, items, is_last)
    });
    let Ok((rest, items, is_last)) = expanding.await else {
        tracing::error!(batch_id = %batch, "a bug stopped the reader of a recipe; trying again later");
        return Ok(false);
    };
    let (first_place, count) = (rest.first_place, items.len());
    let is_expanded = store.expand_recipe(batch, rest, items, is_last).await?;
    if is_expanded {
        tracing::debug!(batch_id = %batch, first_place, count, "gave requests of a recipe their rows");
    }
    Ok(is_expanded)
}
