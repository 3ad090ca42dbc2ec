//! The running parts of a process, and the order in which they stop.
//!
//! 1. Not ready: `/readyz` answers 503, no job is claimed, running stages finish and commit.
//! 2. The listener stays open until the worker has drained, and for `server.close_delay_secs`, so that load balancers
//!    notice before connections are refused.
//! 3. The listener closes; requests that are being answered get `server.shutdown_grace_secs`.
//!
//! A stop ends at the latest after `max(server.close_delay_secs, worker.drain_grace_secs + 10 s) +
//! server.shutdown_grace_secs`.

use std::time::Duration;

use tokio::task::JoinHandle;
use tokio_util::sync::CancellationToken;

use crate::app::AppError;
use store::StoreError;

/// The tasks of a process. Dropping it does not stop them; [`Process::stop`] does.
pub struct Process {
    /// Cancelled = not ready any more, no job is claimed.
    pub draining: CancellationToken,
    /// Cancelled = the listener closes.
    pub closing: CancellationToken,
    pub close_delay: Duration,
    pub listener: Option<JoinHandle<()>>,
    pub worker: Option<JoinHandle<Result<(), StoreError>>>,
}

impl Process {
    /// Waits until `stop` is done (then drains) or the worker ends by itself (an error).
    pub async fn run_until(mut self, stop: impl Future<Output = ()>) -> Result<(), AppError> {
        tokio::select! {
            () = stop => self.stop().await,
            reason = end_of(&mut self.worker) => {
                self.draining.cancel();
                self.closing.cancel();
                // What is being answered may finish; nothing else is left to save.
                if let Some(listener) = self.listener.take() {
                    let _ = listener.await;
                }
                Err(AppError::WorkerEnded { reason })
            }
        }
    }

    /// Stops in good order.
    pub async fn stop(self) -> Result<(), AppError> {
        let Self { draining, closing, close_delay, listener, worker } = self;
        draining.cancel();
        let drain = async {
            match worker {
                None => Ok(()),
                Some(worker) => match worker.await {
                    Ok(result) => Ok(result?),
                    Err(died) => Err(AppError::WorkerEnded { reason: died.to_string() }),
                },
            }
        };
        let delay = async {
            if listener.is_some() {
                tokio::time::sleep(close_delay).await;
            }
        };
        let (drained, ()) = tokio::join!(drain, delay);
        closing.cancel();
        if let Some(Err(died)) = match listener {
            Some(listener) => Some(listener.await),
            None => None,
        } {
            tracing::error!(%died, "the listener died");
        }
        drained
    }
}

/// Reason why a worker ended by itself; pending without a worker.
async fn end_of(worker: &mut Option<JoinHandle<Result<(), StoreError>>>) -> String {
    let Some(worker) = worker else { return std::future::pending().await };
    match worker.await {
        Ok(Ok(())) => "without a reason".to_owned(),
        Ok(Err(error)) => error.chain(),
        Err(died) => died.to_string(),
    }
}
