//! The bounded thread pool for heavy computation.
//!
//! All jobs share one pool, so the number of busy cores is bounded, and asynchronous tasks for the network and the
//! database never wait for a computation.

use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;

use tokio::sync::oneshot;

/// Handle of the pool. Clones share it.
#[derive(Clone)]
pub struct CpuPool {
    pool: Arc<rayon::ThreadPool>,
}

/// The computation panicked, or was dropped with the pool. Holds the reason.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("a computation died: {0}")]
pub struct ComputationFailed(pub String);

impl CpuPool {
    /// A pool of `threads` threads (0 = one per core). Results must not depend on the number.
    ///
    /// # Errors
    ///
    /// The operating system cannot start the threads.
    pub fn new(threads: usize) -> Result<Self, rayon::ThreadPoolBuildError> {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .thread_name(|index| format!("cpu-{index}"))
            .stack_size(16 << 20)
            .build()?;
        Ok(Self { pool: Arc::new(pool) })
    }

    /// Runs `work` on the pool; rayon's parallel iterators inside it use the same pool.
    ///
    /// # Errors
    ///
    /// [`ComputationFailed`] if `work` panics or the pool ends before it ran.
    pub async fn run<T, W>(&self, work: W) -> Result<T, ComputationFailed>
    where
        T: Send + 'static,
        W: FnOnce() -> T + Send + 'static,
    {
        let (answer, result) = oneshot::channel();
        self.pool.spawn(move || {
            // The caller may have dropped the future; then the result is discarded.
            let _ = answer.send(catch_unwind(AssertUnwindSafe(work)));
        });
        match result.await {
            Ok(Ok(value)) => Ok(value),
            Ok(Err(panic)) => Err(ComputationFailed(panic_text(&*panic))),
            Err(_) => Err(ComputationFailed("it was dropped before it answered".into())),
        }
    }
}

/// The message of a panic payload.
pub fn panic_text(panic: &(dyn Any + Send)) -> String {
    let text = panic.downcast_ref::<&str>().map(|text| (*text).to_owned());
    text.or_else(|| panic.downcast_ref::<String>().cloned()).unwrap_or_else(|| "no message".into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[tokio::test]
    async fn run_returns_results_and_turns_panics_into_errors() {
        let cpu = CpuPool::new(2).expect("pool");
        assert_eq!(cpu.run(|| 6 * 7).await, Ok(42));
        assert_eq!(cpu.run(rayon::current_num_threads).await, Ok(2));
        assert_eq!(
            cpu.run(|| panic!("no such mug")).await,
            Err::<(), _>(ComputationFailed("no such mug".into()))
        );
        assert_eq!(cpu.run(|| 1).await, Ok(1), "the pool survives");
    }
}
