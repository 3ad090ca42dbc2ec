//! How a failed turn ends: by its class, for good or back to the queue with a delay (exponential, full
//! jitter, so that jobs that failed together do not come back together).

use std::time::Duration;

use super::Settings;
use crate::job::{Failure, FailureClass};
use crate::pipeline::error::{StageError, StageErrorClass};
use crate::store::queue::Outcome;

/// The outcome of a stage's error in attempt `attempt` (from 1); `None` where the worker itself stopped
/// the stage and knows why. `fraction` in 0..1 is the jitter.
pub fn outcome_of(error: &StageError, attempt: i64, fraction: f64, settings: &Settings) -> Option<Outcome> {
    let class = match error.class {
        StageErrorClass::Transient => FailureClass::Transient,
        StageErrorClass::RateLimited { .. } => FailureClass::RateLimited,
        StageErrorClass::Permanent => FailureClass::Permanent,
        StageErrorClass::Refused => FailureClass::Refused,
        StageErrorClass::OverBudget => FailureClass::OverBudget,
        StageErrorClass::Crashed => FailureClass::Crashed,
        StageErrorClass::Interrupted | StageErrorClass::LeaseLost => return None,
    };
    let failure = Failure { class, code: error.code.to_owned(), message: error.message.clone() };
    if !class.is_retryable() {
        return Some(Outcome::Failed(failure));
    }
    let jittered = delay(attempt, fraction, settings);
    let (delay, charged) = match error.class {
        // Its provider said when; waiting is not failing.
        StageErrorClass::RateLimited { retry_after: Some(after) } => (after.max(jittered), false),
        StageErrorClass::RateLimited { retry_after: None } => (jittered, false),
        _ => (jittered, true),
    };
    Some(Outcome::Retry { failure, delay, charged, max_attempts: settings.max_attempts })
}

/// `fraction` of `min(cap, base * 2^(attempt - 1))`.
fn delay(attempt: i64, fraction: f64, settings: &Settings) -> Duration {
    let doublings = u32::try_from(attempt.saturating_sub(1)).unwrap_or(0).min(20);
    let ceiling = settings.backoff_base_ms.saturating_mul(1 << doublings).min(settings.backoff_cap_ms);
    Duration::from_secs_f64(ceiling as f64 / 1000.0 * fraction)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn settings() -> Settings {
        Settings {
            concurrency: 1,
            cpu_threads: 1,
            fan_out: 1,
            lease_secs: 30,
            heartbeat_secs: 5,
            poll_ms: 1000,
            max_attempts: 3,
            backoff_base_ms: 1000,
            backoff_cap_ms: 5000,
            drain_grace_secs: 1,
            stage_timeout_secs: 60,
        }
    }

    #[test]
    fn delays_double_up_to_the_cap_and_jitter_spreads_them() {
        let seconds = |attempt, fraction| delay(attempt, fraction, &settings()).as_secs_f64();
        assert_eq!([1, 2, 3, 4, 90].map(|attempt| seconds(attempt, 1.0)), [1.0, 2.0, 4.0, 5.0, 5.0]);
        assert_eq!(seconds(2, 0.25), 0.5);
    }

    #[test]
    fn the_class_decides_between_failing_and_trying_again() {
        let outcome = |error: StageError| outcome_of(&error, 1, 0.5, &settings());
        assert!(matches!(
            outcome(StageError::transient("t", "m")),
            Some(Outcome::Retry { charged: true, .. })
        ));
        assert!(matches!(outcome(StageError::crashed("m")), Some(Outcome::Retry { charged: true, .. })));
        let patience = Duration::from_secs(40);
        assert!(matches!(
            outcome(StageError::rate_limited("r", "m", Some(patience))),
            Some(Outcome::Retry { charged: false, delay, .. }) if delay == patience
        ));
        for error in [
            StageError::permanent("p", "m"),
            StageError::refused("r", "m"),
            StageError::over_budget("o", "m"),
        ] {
            assert!(matches!(outcome(error), Some(Outcome::Failed(_))));
        }
        assert!(outcome(StageError::interrupted()).is_none());
    }
}
