//! Taking turns: how many calls with one key run at the same time, and how many begin in a minute. Endpoints with the
//! same key and base URL share their turns.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard};
use std::time::{Duration, Instant};

use tokio::sync::{OwnedSemaphorePermit, Semaphore};

use super::Secret;

/// The turns of one key; cloning shares them.
#[derive(Clone, Debug)]
pub struct Turns {
    slots: Arc<Semaphore>,
    clock: Arc<Mutex<Clock>>,
    spacing: Duration,
}

#[derive(Debug)]
struct Clock {
    /// When the next call may begin.
    next: Instant,
    /// Nobody begins before; a vendor asked for patience.
    held_until: Instant,
}

/// A call's turn; it ends when this is dropped.
#[derive(Debug)]
pub struct Turn {
    _slot: Option<OwnedSemaphorePermit>,
}

/// The turns of every key, by base URL and fingerprint.
#[derive(Debug, Default)]
pub struct AllTurns(BTreeMap<(String, Option<[u8; 32]>), Turns>);

impl AllTurns {
    /// The turns of a key at a base URL; the first endpoint that names them sets their limits.
    pub fn of(
        &mut self,
        base_url: &str,
        key: Option<&Secret>,
        concurrency: usize,
        calls_per_minute: u32,
    ) -> Turns {
        let turns = self.0.entry((base_url.to_owned(), key.map(Secret::fingerprint)));
        turns.or_insert_with(|| Turns::new(concurrency, calls_per_minute)).clone()
    }
}

impl Turns {
    pub fn new(concurrency: usize, calls_per_minute: u32) -> Self {
        let now = Instant::now();
        Self {
            slots: Arc::new(Semaphore::new(concurrency.clamp(1, Semaphore::MAX_PERMITS))),
            clock: Arc::new(Mutex::new(Clock { next: now, held_until: now })),
            spacing: Duration::from_secs(60) / calls_per_minute.max(1),
        }
    }

    /// Waits for a turn. Who stops waiting leaves a start unused, which only slows the others.
    pub async fn take(&self) -> Turn {
        // Nobody closes it.
        let slot = self.slots.clone().acquire_owned().await.ok();
        let start = self.start(Instant::now());
        tokio::time::sleep_until(start.into()).await;
        loop {
            let held_until = self.lock().held_until;
            if held_until <= Instant::now() {
                return Turn { _slot: slot };
            }
            tokio::time::sleep_until(held_until.into()).await;
        }
    }

    /// When a call that comes now may begin; the one after it, a spacing later.
    fn start(&self, now: Instant) -> Instant {
        let mut clock = self.lock();
        let start = clock.next.max(now);
        clock.next = start + self.spacing;
        start
    }

    /// Nobody begins before `until`.
    pub fn hold(&self, until: Instant) {
        let mut clock = self.lock();
        clock.held_until = clock.held_until.max(until);
    }

    fn lock(&self) -> MutexGuard<'_, Clock> {
        self.clock.lock().expect("no code panics while it holds this lock")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn starts_are_evenly_spaced_and_idle_time_is_not_saved_up() {
        let turns = Turns::new(8, 120);
        let now = Instant::now() + Duration::from_secs(5);
        let half = Duration::from_millis(500);
        let starts: Vec<Instant> = (0..3).map(|_| turns.start(now)).collect();
        assert_eq!(starts, [now, now + half, now + 2 * half]);
        let later = now + Duration::from_secs(60);
        assert_eq!(turns.start(later), later);
        assert_eq!(turns.start(later), later + half);
    }

    #[tokio::test]
    async fn slots_are_given_back_and_shared_by_key() {
        let mut all = AllTurns::default();
        let (one, two) = (Secret::new("one"), Secret::new("two"));
        let turns = all.of("https://a", one.as_ref(), 1, 1_000_000);
        let same = all.of("https://a", one.as_ref(), 9, 1);
        let other = all.of("https://a", two.as_ref(), 1, 1_000_000);
        let held = turns.take().await;
        assert_eq!(same.slots.available_permits(), 0);
        assert_eq!(other.slots.available_permits(), 1);
        drop(held);
        let _ = same.take().await;
    }

    #[tokio::test]
    async fn a_vendor_that_asks_for_patience_gets_it_from_everybody() {
        let turns = Turns::new(4, 1_000_000);
        let until = Instant::now() + Duration::from_millis(60);
        turns.hold(until);
        let _ = turns.take().await;
        assert!(Instant::now() >= until);
    }
}
