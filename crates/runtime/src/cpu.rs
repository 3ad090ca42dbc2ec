//! The one bounded pool all heavy computation runs on, so that jobs share the cores instead of fighting over them,
//! and the tasks that talk to the network and the database are never held up.

use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;

use tokio::sync::oneshot;

/// Handle on the pool; cloning shares it.
#[derive(Clone)]
pub struct Cpu {
    pool: Arc<rayon::ThreadPool>,
}

/// The computation panicked, or was dropped with the pool.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("a computation died: {0}")]
pub struct Died(pub String);

impl Cpu {
    /// A pool of `threads` (0 = one per core). Results must not depend on the number.
    pub fn new(threads: usize) -> Result<Self, rayon::ThreadPoolBuildError> {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .thread_name(|index| format!("cpu-{index}"))
            .stack_size(16 << 20)
            .build()?;
        Ok(Self { pool: Arc::new(pool) })
    }

    /// Runs `work` on the pool; rayon's parallel iterators inside it use the same pool.
    pub async fn run<T, W>(&self, work: W) -> Result<T, Died>
    where
        T: Send + 'static,
        W: FnOnce() -> T + Send + 'static,
    {
        let (answer, result) = oneshot::channel();
        self.pool.spawn(move || {
            // Whoever asked may have gone; then nobody wants the answer.
            let _ = answer.send(catch_unwind(AssertUnwindSafe(work)));
        });
        match result.await {
            Ok(Ok(value)) => Ok(value),
            Ok(Err(panic)) => Err(Died(panic_text(&*panic))),
            Err(_) => Err(Died("it was dropped before it answered".into())),
        }
    }
}

/// What a panic said.
pub fn panic_text(panic: &(dyn Any + Send)) -> String {
    let text = panic.downcast_ref::<&str>().map(|text| (*text).to_owned());
    text.or_else(|| panic.downcast_ref::<String>().cloned()).unwrap_or_else(|| "no message".into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[tokio::test]
    async fn answers_come_back_and_panics_become_errors() {
        let cpu = Cpu::new(2).expect("pool");
        assert_eq!(cpu.run(|| 6 * 7).await, Ok(42));
        assert_eq!(cpu.run(rayon::current_num_threads).await, Ok(2));
        assert_eq!(cpu.run(|| panic!("no such mug")).await, Err::<(), _>(Died("no such mug".into())));
        assert_eq!(cpu.run(|| 1).await, Ok(1), "the pool survives");
    }
}
