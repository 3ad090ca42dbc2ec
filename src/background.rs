//! Parts of a process that work in the background until it ends: each is started again when it panics.
//!
//! A part is a loop that no task awaits, so without this its end would go unnoticed, for as long as the process
//! lives. The panic itself is a line of the log, with its place; this adds which part it ended, and when that goes on.

use std::time::{Duration, Instant};

use tokio_util::task::AbortOnDropHandle;

/// Pause before the first new start; it doubles with every further panic.
const FIRST_PAUSE: Duration = Duration::from_secs(1);
const MAX_PAUSE: Duration = Duration::from_secs(60);

/// Runs a part until it ends by itself. Dropping the future ends it too.
pub async fn kept_running<F>(name: &'static str, part: impl Fn() -> F)
where
    F: Future<Output = ()> + Send + 'static,
{
    let mut pause = FIRST_PAUSE;
    loop {
        let began = Instant::now();
        match AbortOnDropHandle::new(tokio::spawn(part())).await {
            Err(died) if died.is_panic() => {}
            _ => return,
        }
        if began.elapsed() > MAX_PAUSE {
            pause = FIRST_PAUSE;
        }
        let pause_secs = pause.as_secs();
        tracing::error!(
            part = name,
            pause_secs,
            "a part of the process panicked; it is started again after a pause"
        );
        tokio::time::sleep(pause).await;
        pause = (pause * 2).min(MAX_PAUSE);
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;
    use std::sync::atomic::{AtomicU32, Ordering};

    use super::*;

    #[tokio::test]
    async fn a_part_that_panics_is_started_again_until_it_ends_by_itself() {
        let starts = Arc::new(AtomicU32::new(0));
        let counted = starts.clone();
        let part = move || {
            let start = counted.fetch_add(1, Ordering::Relaxed);
            async move { assert!(start == 1, "the first start panics") }
        };
        let began = Instant::now();
        kept_running("test", part).await;
        assert_eq!(starts.load(Ordering::Relaxed), 2);
        assert!(began.elapsed() >= FIRST_PAUSE, "not without a pause");
    }
}
