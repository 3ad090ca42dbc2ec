//! What follows when background work (a freeze, an attempt of a recording, assembling) did not come to its end: the
//! rules of jobs. A panic and a disk that refuses count as attempts; what storage has no space for burns none.

use std::io;
use std::time::Duration;

use super::{Settings, backoff};
use store::{Setback, StoreError};

/// What follows.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Verdict {
    /// The same again would fail again.
    Refused { code: &'static str, message: String },
    /// It is tried again, by the rules of jobs: what storage could not write burns no attempt.
    Again { code: &'static str, charged: bool },
    /// Another process may begin it again at once.
    GivenUp,
}

impl Verdict {
    /// A panic.
    pub(crate) fn of_panic() -> Self {
        Self::Again { code: "internal_error", charged: true }
    }

    /// An error of the store.
    pub(crate) fn of_store(error: &StoreError) -> Self {
        Self::Again { code: "store_unavailable", charged: error.outage().is_none() }
    }

    /// An error of the folder that the work is done in.
    pub(crate) fn of_work_folder(kind: io::ErrorKind) -> Self {
        let is_full = matches!(kind, io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded);
        Self::Again { code: "work_folder_unusable", charged: !is_full }
    }
}

/// The setback of an `attempt` (from 1) that is made again unless it was the last one.
pub(crate) fn setback(
    code: &'static str,
    message: String,
    charged: bool,
    attempt: i64,
    settings: &Settings,
) -> Setback {
    let delay = match charged {
        true => backoff::full_delay(attempt, settings),
        false => Duration::from_millis(settings.backoff_cap_ms),
    };
    Setback { code, message, delay, charged, max_attempts: settings.max_attempts }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_storage_could_not_write_burns_no_attempt() {
        let again = |code, charged| Verdict::Again { code, charged };
        assert_eq!(Verdict::of_work_folder(io::ErrorKind::StorageFull), again("work_folder_unusable", false));
        assert_eq!(
            Verdict::of_work_folder(io::ErrorKind::PermissionDenied),
            again("work_folder_unusable", true)
        );
        assert_eq!(Verdict::of_store(&StoreError::WriterStopped), again("store_unavailable", false));
    }
}
