//! The breaker of an endpoint: after several failures in a row it is left alone for a while; then one call tries, and
//! its end decides.

use std::sync::{Mutex, MutexGuard};
use std::time::{Duration, Instant};

/// Shared by all calls of an endpoint.
#[derive(Debug)]
pub struct Breaker {
    failures_to_open: u32,
    rest: Duration,
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
    /// One call is trying.
    Probing,
}

/// The right to make one call. Dropped without a verdict (the call was abandoned), it changes nothing but lets
/// another one probe.
#[derive(Debug)]
pub struct Pass<'a> {
    breaker: &'a Breaker,
    probes: bool,
}

impl Breaker {
    /// Opens after `failures_to_open` failures in a row, for `rest`.
    pub fn new(failures_to_open: u32, rest: Duration) -> Self {
        Self {
            failures_to_open: failures_to_open.max(1),
            rest,
            state: Mutex::new(State::Closed { failures: 0 }),
        }
    }

    /// Leave to call, or how long to wait before asking again.
    pub fn admit(&self, now: Instant) -> Result<Pass<'_>, Duration> {
        let mut state = self.lock();
        match *state {
            State::Closed { .. } => Ok(Pass { breaker: self, probes: false }),
            State::Open { until } if now < until => Err(until - now),
            State::Open { .. } => {
                *state = State::Probing;
                Ok(Pass { breaker: self, probes: true })
            }
            State::Probing => Err(Duration::from_millis(200).min(self.rest)),
        }
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().expect("no code panics while it holds this lock")
    }
}

impl Pass<'_> {
    /// The endpoint answered, be it with a refusal.
    pub fn answered(mut self) {
        self.probes = false;
        *self.breaker.lock() = State::Closed { failures: 0 };
    }

    /// The endpoint failed.
    pub fn failed(mut self, now: Instant) {
        let open = State::Open { until: now + self.breaker.rest };
        let mut state = self.breaker.lock();
        *state = match *state {
            _ if self.probes => open,
            State::Closed { failures } if failures + 1 < self.breaker.failures_to_open => {
                State::Closed { failures: failures + 1 }
            }
            State::Closed { .. } => open,
            // Calls that were under way when it opened.
            other => other,
        };
        drop(state);
        self.probes = false;
    }
}

impl Drop for Pass<'_> {
    fn drop(&mut self) {
        if self.probes {
            // Nothing was learned: the next one probes, at once.
            *self.breaker.lock() = State::Open { until: Instant::now() };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const REST: Duration = Duration::from_secs(30);

    #[test]
    fn it_opens_after_failures_in_a_row_and_one_probe_decides() {
        let (breaker, start) = (Breaker::new(3, REST), Instant::now());
        let pass = |at| breaker.admit(at).expect("is let through");
        pass(start).failed(start);
        pass(start).failed(start);
        pass(start).answered();
        for _ in 0..3 {
            pass(start).failed(start);
        }
        assert_eq!(breaker.admit(start).expect_err("is open"), REST);
        let later = start + REST;
        let probe = pass(later);
        assert!(breaker.admit(later).is_err(), "one probe at a time");
        probe.failed(later);
        assert_eq!(breaker.admit(later).expect_err("is open again"), REST);
        pass(later + REST).answered();
        pass(later + REST).failed(later);
        assert!(breaker.admit(later).is_ok(), "one failure does not open it");
    }

    #[test]
    fn an_abandoned_probe_is_no_verdict() {
        let (breaker, start) = (Breaker::new(1, REST), Instant::now());
        breaker.admit(start).expect("is let through").failed(start);
        let later = start + REST;
        drop(breaker.admit(later).expect("probes"));
        assert!(breaker.admit(later).is_ok());
    }

    #[test]
    fn calls_under_way_when_it_opens_do_not_prolong_the_rest() {
        let (breaker, start) = (Breaker::new(1, REST), Instant::now());
        let (first, second) = (breaker.admit(start).expect("passes"), breaker.admit(start).expect("passes"));
        first.failed(start);
        second.failed(start + Duration::from_secs(10));
        assert_eq!(breaker.admit(start).expect_err("is open"), REST);
    }
}
