//! Rate limits: the calls with one key that run concurrently, and those that start within a minute.
//!
//! Endpoints with the same key and base URL share a limiter. Starts are evenly spaced and reserved in order of arrival;
//! idle time is not saved up. A limiter can be paused for all callers, as a vendor's `Retry-After` requests.
//!
//! The crate `governor` does not replace it: its waiting callers compete for each start instead of reserving one in
//! order, and it has no pause that applies to callers that already wait.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard};
use std::time::{Duration, Instant};

use tokio::sync::{OwnedSemaphorePermit, Semaphore};

use super::Secret;

/// The limits of one key; clones share them.
#[derive(Clone, Debug)]
pub struct RateLimiter {
    slots: Arc<Semaphore>,
    schedule: Arc<Mutex<Schedule>>,
    spacing: Duration,
}

#[derive(Debug)]
struct Schedule {
    /// Earliest start of the next call.
    next: Instant,
    /// No call starts earlier; set after a `Retry-After`.
    paused_until: Instant,
}

/// The permit of one call; dropping it frees its slot.
#[derive(Debug)]
pub struct CallPermit {
    _slot: Option<OwnedSemaphorePermit>,
}

/// The limiters of all keys, by base URL and fingerprint of the key.
#[derive(Debug, Default)]
pub struct RateLimiters(BTreeMap<(String, Option<[u8; 32]>), RateLimiter>);

impl RateLimiters {
    /// The limiter of a key at a base URL. The first endpoint that asks for it sets its limits.
    pub fn limiter(
        &mut self,
        base_url: &str,
        key: Option<&Secret>,
        concurrency: usize,
        calls_per_minute: u32,
    ) -> RateLimiter {
        let limiter = self.0.entry((base_url.to_owned(), key.map(Secret::fingerprint)));
        limiter.or_insert_with(|| RateLimiter::new(concurrency, calls_per_minute)).clone()
    }
}

impl RateLimiter {
    /// A limiter of `concurrency` calls at the same time and `calls_per_minute` evenly spaced starts.
    pub fn new(concurrency: usize, calls_per_minute: u32) -> Self {
        let now = Instant::now();
        Self {
            slots: Arc::new(Semaphore::new(concurrency.clamp(1, Semaphore::MAX_PERMITS))),
            schedule: Arc::new(Mutex::new(Schedule { next: now, paused_until: now })),
            spacing: Duration::from_secs(60) / calls_per_minute.max(1),
        }
    }

    /// Waits for a slot and a start. A caller that stops waiting leaves its start unused, which only slows others.
    pub async fn acquire(&self) -> CallPermit {
        // The semaphore is never closed.
        let slot = self.slots.clone().acquire_owned().await.ok();
        let start = self.reserve_start(Instant::now());
        tokio::time::sleep_until(start.into()).await;
        loop {
            let paused_until = self.lock().paused_until;
            if paused_until <= Instant::now() {
                return CallPermit { _slot: slot };
            }
            tokio::time::sleep_until(paused_until.into()).await;
        }
    }

    /// Reserves the earliest start for a call that arrives at `now`; the following start is one spacing later.
    fn reserve_start(&self, now: Instant) -> Instant {
        let mut schedule = self.lock();
        let start = schedule.next.max(now);
        schedule.next = start + self.spacing;
        start
    }

    /// Lets no call start before `until`.
    pub fn pause_until(&self, until: Instant) {
        let mut schedule = self.lock();
        schedule.paused_until = schedule.paused_until.max(until);
    }

    fn lock(&self) -> MutexGuard<'_, Schedule> {
        self.schedule.lock().expect("no code panics while it holds this lock")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn starts_are_evenly_spaced_without_credit_for_idle_time() {
        let limiter = RateLimiter::new(8, 120);
        let now = Instant::now() + Duration::from_secs(5);
        let half = Duration::from_millis(500);
        let starts: Vec<Instant> = (0..3).map(|_| limiter.reserve_start(now)).collect();
        assert_eq!(starts, [now, now + half, now + 2 * half]);
        let later = now + Duration::from_secs(60);
        assert_eq!(limiter.reserve_start(later), later);
        assert_eq!(limiter.reserve_start(later), later + half);
    }

    #[tokio::test]
    async fn limiters_share_slots_by_key_and_free_them_on_drop() {
        let mut all = RateLimiters::default();
        let (one, two) = (Secret::new("one"), Secret::new("two"));
        let limiter = all.limiter("https://a", one.as_ref(), 1, 1_000_000);
        let same = all.limiter("https://a", one.as_ref(), 9, 1);
        let other = all.limiter("https://a", two.as_ref(), 1, 1_000_000);
        let held = limiter.acquire().await;
        assert_eq!(same.slots.available_permits(), 0);
        assert_eq!(other.slots.available_permits(), 1);
        drop(held);
        let _ = same.acquire().await;
    }

    #[tokio::test]
    async fn pause_until_delays_every_caller() {
        let limiter = RateLimiter::new(4, 1_000_000);
        let until = Instant::now() + Duration::from_millis(60);
        limiter.pause_until(until);
        let _ = limiter.acquire().await;
        assert!(Instant::now() >= until);
    }
}
