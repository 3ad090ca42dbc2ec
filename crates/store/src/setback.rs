//! Background work that did not come to its end: how often it is tried again, and when. The rules hold for datasets
//! and recordings alike, and are those of jobs.

use std::time::Duration;

/// Why an attempt at background work did not come to its end, and what follows.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Setback {
    /// Stable, `[a-z0-9_]+`.
    pub code: &'static str,
    /// A sentence with advice.
    pub message: String,
    /// Until the next attempt.
    pub delay: Duration,
    /// Whether it counts as an attempt; the `max_attempts`-th since the last progress is the end.
    pub charged: bool,
    pub max_attempts: u32,
}

/// What follows a setback.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AfterSetback {
    /// The work is done again, after the delay.
    Again,
    /// That was the last attempt: the work failed, or was given up.
    Ended,
}

impl Setback {
    /// Whether this `attempt` (from 1) was the last one.
    pub(crate) fn is_end(&self, attempt: i64) -> bool {
        self.charged && attempt >= i64::from(self.max_attempts)
    }

    /// The attempts that count after it.
    pub(crate) fn counted(&self, attempt: i64) -> i64 {
        if self.charged { attempt } else { (attempt - 1).max(0) }
    }

    /// When the work may be done again, milliseconds since 1970.
    pub(crate) fn again_at_ms(&self, now_ms: i64) -> i64 {
        now_ms.saturating_add(i64::try_from(self.delay.as_millis()).unwrap_or(i64::MAX / 4))
    }
}
