//! Sending of events to webhooks, by the specification Standard Webhooks (standardwebhooks.com).
//!
//! The store has the messages ([`store::webhooks`]); a process takes those that are due, signs them ([`signature`]),
//! sends each with one POST ([`attempt`]), and writes how that ended. A message is sent at least once: a process that
//! dies between an answer and its row leaves it to another one, which sends it again with the same id.
//!
//! An address of a client is not a provider's: it has rules of its own, and no redirect is followed. No line of the log
//! has an address, a secret or a message.

pub mod signature;
mod attempt;

use std::time::Duration;

use serde::{Deserialize, Serialize};
use tokio::task::JoinSet;
use tokio_util::sync::CancellationToken;

use crate::background::kept_running;
use http_client::AddressPolicy;
use store::Store;

use attempt::Sender;

/// Section `[webhooks]`.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct Settings {
    /// Hosts, or `host:port`, that may be reached by plain HTTP and at private addresses; separated by spaces.
    pub hosts: String,
    /// Longest time of one attempt, seconds.
    pub timeout_secs: u64,
    /// Pause after each failed attempt, seconds; the attempt after the last pause is the last one.
    pub retry_secs: Vec<f64>,
    /// Deliveries in a row whose last attempt failed that disable their webhook.
    pub max_failures: u32,
    /// Messages that a process sends at the same time, each to another webhook.
    pub concurrency: u32,
}

impl Settings {
    /// The addresses that webhooks may have.
    pub fn addresses(&self) -> AddressPolicy {
        AddressPolicy::with_exceptions(&self.hosts)
    }

    fn timeout(&self) -> Duration {
        Duration::from_secs(self.timeout_secs)
    }
}

/// Time beyond the longest attempt that a claim lasts, in which its end is written.
const LEASE_MARGIN: Duration = Duration::from_secs(15);
/// Changes in quick succession are handled together.
const BUNDLED_CHANGES: Duration = Duration::from_millis(20);

/// Sends from now on until `shutdown`; asks for messages after every change, and every `poll`.
pub fn start(store: &Store, settings: &Settings, poll: Duration, shutdown: &CancellationToken) {
    let (sender, shutdown) = (Sender::new(store.clone(), settings.clone()), shutdown.clone());
    let send = move || send_until_shutdown(sender.clone(), poll, shutdown.clone());
    tokio::spawn(kept_running("sender of webhooks", send));
}

/// Claims and sends. A message under way at the shutdown is broken off, and sent again by another process or after the
/// next start.
async fn send_until_shutdown(sender: Sender, poll: Duration, shutdown: CancellationToken) {
    let lease = sender.settings.timeout() + LEASE_MARGIN;
    let mut changes = sender.store.changes();
    let mut attempts = JoinSet::new();
    while !shutdown.is_cancelled() {
        changes.mark_unchanged();
        let free =
            sender.settings.concurrency.saturating_sub(u32::try_from(attempts.len()).unwrap_or(u32::MAX));
        let due = if free > 0 { sender.store.claim_deliveries(lease, free).await } else { Ok(Vec::new()) };
        match due {
            Ok(due) => {
                for delivery in due {
                    attempts.spawn(sender.clone().attempt(delivery));
                }
            }
            // The store itself reports outages, once.
            Err(error) if error.outage().is_some() => {}
            Err(error) => {
                tracing::error!(
                    error = error.chain(),
                    "cannot take messages for webhooks; trying again later"
                )
            }
        }
        tokio::select! {
            () = shutdown.cancelled() => {}
            Some(_) = attempts.join_next() => {}
            _ = changes.changed() => tokio::time::sleep(BUNDLED_CHANGES).await,
            () = tokio::time::sleep(poll) => {}
        }
    }
}
