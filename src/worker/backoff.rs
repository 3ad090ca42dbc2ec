//! End of a failed attempt: by its class, for good or back to the queue with a delay (exponential, full jitter, so that
//! jobs that failed together do not come back together). A failure of the store to write is not the job's fault: it
//! burns no attempt, and waits long.

use std::io::{self, ErrorKind};
use std::time::Duration;

use super::Settings;
use crate::pipeline::error::{StageError, StageErrorClass};
use store::StoreError;
use store::lifecycle::{Failure, FailureClass};
use store::queue::AttemptOutcome;

/// The outcome of a stage's error in attempt `attempt` (from 1); `None` where the worker itself stopped
/// the stage and knows why. `fraction` in 0..1 is the jitter.
pub fn outcome_of(
    error: &StageError,
    attempt: i64,
    fraction: f64,
    settings: &Settings,
) -> Option<AttemptOutcome> {
    let class = match error.class {
        StageErrorClass::Transient => FailureClass::Transient,
        StageErrorClass::RateLimited { .. } => FailureClass::RateLimited,
        StageErrorClass::Permanent => FailureClass::Permanent,
        StageErrorClass::Refused => FailureClass::Refused,
        StageErrorClass::OverBudget => FailureClass::OverBudget,
        StageErrorClass::Crashed => FailureClass::Crashed,
        StageErrorClass::Cancelled | StageErrorClass::LeaseLost => return None,
    };
    let failure = Failure { class, code: error.code.to_owned(), message: error.message.clone() };
    if !class.is_retryable() {
        return Some(AttemptOutcome::Failed(failure));
    }
    let jittered = full_delay(attempt, settings).mul_f64(fraction);
    let (delay, charged) = match error.class {
        _ if is_out_of_storage(error) => {
            (Duration::from_millis(settings.backoff_cap_ms).mul_f64(0.5 + 0.5 * fraction), false)
        }
        // Its provider said when; waiting is not failing.
        StageErrorClass::RateLimited { retry_after: Some(after) } => (after.max(jittered), false),
        StageErrorClass::RateLimited { retry_after: None } => (jittered, false),
        _ => (jittered, true),
    };
    Some(AttemptOutcome::Retry { failure, delay, charged, max_attempts: settings.max_attempts })
}

/// Whether the failure is that storage takes no writes, or that a disk is full.
fn is_out_of_storage(error: &StageError) -> bool {
    let Some(cause) = &error.cause else { return false };
    let is_full =
        |error: &io::Error| matches!(error.kind(), ErrorKind::StorageFull | ErrorKind::QuotaExceeded);
    cause.downcast_ref::<StoreError>().is_some_and(|error| error.outage().is_some())
        || cause.downcast_ref().is_some_and(is_full)
}

/// `min(cap, base * 2^(attempt - 1))`.
pub fn full_delay(attempt: i64, settings: &Settings) -> Duration {
    let doublings = u32::try_from(attempt.saturating_sub(1)).unwrap_or(0).min(20);
    let ceiling = settings.backoff_base_ms.saturating_mul(1 << doublings).min(settings.backoff_cap_ms);
    Duration::from_millis(ceiling)
}

#[cfg(test)]
mod tests {
    use super::*;
    use store::Outage;

    fn settings() -> Settings {
        Settings {
            concurrency: 1,
            cpu_threads: 1,
            fan_out: 1,
            lease_secs: 30,
            heartbeat_secs: 5,
            poll_ms: 1000,
            max_attempts: 3,
            max_deaths: 3,
            backoff_base_ms: 1000,
            backoff_cap_ms: 5000,
            drain_grace_secs: 1,
            stage_timeout_secs: 60,
            listen: String::new(),
        }
    }

    #[test]
    fn delays_double_up_to_the_cap_and_jitter_spreads_them() {
        let seconds = |attempt| full_delay(attempt, &settings()).as_secs_f64();
        assert_eq!([1, 2, 3, 4, 90].map(seconds), [1.0, 2.0, 4.0, 5.0, 5.0]);
        let error = StageError::transient("t", "m");
        let Some(AttemptOutcome::Retry { delay, .. }) = outcome_of(&error, 2, 0.25, &settings()) else {
            panic!("is tried again")
        };
        assert_eq!(delay, Duration::from_millis(500));
    }

    #[test]
    fn the_class_decides_between_failing_and_trying_again() {
        let outcome = |error: StageError| outcome_of(&error, 1, 0.5, &settings());
        assert!(matches!(
            outcome(StageError::transient("t", "m")),
            Some(AttemptOutcome::Retry { charged: true, .. })
        ));
        assert!(matches!(
            outcome(StageError::crashed("m")),
            Some(AttemptOutcome::Retry { charged: true, .. })
        ));
        let patience = Duration::from_secs(40);
        assert!(matches!(
            outcome(StageError::rate_limited("r", "m", Some(patience))),
            Some(AttemptOutcome::Retry { charged: false, delay, .. }) if delay == patience
        ));
        // A full disk is not charged as an attempt.
        let full = StoreError::Commit { doing: "x", reason: "y".into(), outage: Some(Outage::Full) };
        assert!(matches!(
            outcome(StageError::from(full)),
            Some(AttemptOutcome::Retry { charged: false, delay, .. }) if delay >= Duration::from_millis(2500)
        ));
        let disk = |kind| StageError::transient("work_folder_unusable", "m").because(io::Error::from(kind));
        for (kind, is_charged) in [(ErrorKind::StorageFull, false), (ErrorKind::PermissionDenied, true)] {
            let found = outcome(disk(kind));
            assert!(
                matches!(found, Some(AttemptOutcome::Retry { charged, .. }) if charged == is_charged),
                "{kind}: {found:?}"
            );
        }
        for error in [
            StageError::permanent("p", "m"),
            StageError::refused("r", "m"),
            StageError::over_budget("o", "m"),
        ] {
            assert!(matches!(outcome(error), Some(AttemptOutcome::Failed(_))));
        }
        assert!(outcome(StageError::cancelled()).is_none());
    }
}
