//! Circuit breaker of an endpoint: consecutive failures open it for a cooldown; then one probe call decides whether it
//! closes again.

use std::sync::{Mutex, MutexGuard};
use std::time::{Duration, Instant};

/// The circuit breaker that all calls of an endpoint share.
#[derive(Debug)]
pub struct CircuitBreaker {
    failures_to_open: u32,
    cooldown: Duration,
    state: Mutex<State>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    Closed {
        failures: u32,
    },
    Open {
        until: Instant,
    },
    /// One probe call is under way.
    HalfOpen,
}

/// Permission for one call. Dropping it without an outcome (an abandoned call) only lets another call probe.
#[derive(Debug)]
pub struct Permit<'a> {
    breaker: &'a CircuitBreaker,
    probes: bool,
}

impl CircuitBreaker {
    /// A closed breaker that opens after `failures_to_open` consecutive failures, for `cooldown`.
    pub fn new(failures_to_open: u32, cooldown: Duration) -> Self {
        Self {
            failures_to_open: failures_to_open.max(1),
            cooldown,
            state: Mutex::new(State::Closed { failures: 0 }),
        }
    }

    /// Permission for one call.
    ///
    /// # Errors
    ///
    /// The time after which to ask again, where the breaker is open or a probe is under way.
    pub fn admit(&self, now: Instant) -> Result<Permit<'_>, Duration> {
        let mut state = self.lock();
        match *state {
            State::Closed { .. } => Ok(Permit { breaker: self, probes: false }),
            State::Open { until } if now < until => Err(until - now),
            State::Open { .. } => {
                *state = State::HalfOpen;
                Ok(Permit { breaker: self, probes: true })
            }
            State::HalfOpen => Err(Duration::from_millis(200).min(self.cooldown)),
        }
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().expect("no code panics while it holds this lock")
    }
}

impl Permit<'_> {
    /// The endpoint answered, possibly with a refusal: the breaker closes.
    pub fn succeeded(mut self) {
        self.probes = false;
        *self.breaker.lock() = State::Closed { failures: 0 };
    }

    /// The endpoint failed: the failure counts, and a failed probe opens the breaker again.
    pub fn failed(mut self, now: Instant) {
        let open = State::Open { until: now + self.breaker.cooldown };
        let mut state = self.breaker.lock();
        *state = match *state {
            _ if self.probes => open,
            State::Closed { failures } if failures + 1 < self.breaker.failures_to_open => {
                State::Closed { failures: failures + 1 }
            }
            State::Closed { .. } => open,
            // The call was under way when the breaker opened.
            other => other,
        };
        drop(state);
        self.probes = false;
    }
}

impl Drop for Permit<'_> {
    fn drop(&mut self) {
        if self.probes {
            // The probe has no outcome: the next call probes at once.
            *self.breaker.lock() = State::Open { until: Instant::now() };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const COOLDOWN: Duration = Duration::from_secs(30);

    #[test]
    fn breaker_opens_after_consecutive_failures_and_one_probe_decides() {
        let (breaker, start) = (CircuitBreaker::new(3, COOLDOWN), Instant::now());
        let admit = |at| breaker.admit(at).expect("is let through");
        admit(start).failed(start);
        admit(start).failed(start);
        admit(start).succeeded();
        for _ in 0..3 {
            admit(start).failed(start);
        }
        assert_eq!(breaker.admit(start).expect_err("is open"), COOLDOWN);
        let later = start + COOLDOWN;
        let probe = admit(later);
        assert!(breaker.admit(later).is_err(), "one probe at a time");
        probe.failed(later);
        assert_eq!(breaker.admit(later).expect_err("is open again"), COOLDOWN);
        admit(later + COOLDOWN).succeeded();
        admit(later + COOLDOWN).failed(later);
        assert!(breaker.admit(later).is_ok(), "one failure does not open it");
    }

    #[test]
    fn abandoned_probe_lets_the_next_call_probe() {
        let (breaker, start) = (CircuitBreaker::new(1, COOLDOWN), Instant::now());
        breaker.admit(start).expect("is let through").failed(start);
        let later = start + COOLDOWN;
        drop(breaker.admit(later).expect("probes"));
        assert!(breaker.admit(later).is_ok());
    }

    #[test]
    fn failures_of_calls_under_way_do_not_extend_the_cooldown() {
        let (breaker, start) = (CircuitBreaker::new(1, COOLDOWN), Instant::now());
        let (first, second) = (breaker.admit(start).expect("passes"), breaker.admit(start).expect("passes"));
        first.failed(start);
        second.failed(start + Duration::from_secs(10));
        assert_eq!(breaker.admit(start).expect_err("is open"), COOLDOWN);
    }
}
