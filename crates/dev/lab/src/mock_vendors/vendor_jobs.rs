//! Simulated vendor jobs: an id immediately, a file later.

use std::collections::BTreeMap;
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use bytes::Bytes;

/// Maximum number of remembered jobs; the oldest are dropped first.
const REMEMBERED: usize = 1024;

/// Status of a job.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum VendorJob {
    Working,
    Done(Bytes),
    Cancelled,
}

/// All jobs of all protocols.
#[derive(Debug, Default)]
pub(super) struct VendorJobs(Mutex<JobTable>);

#[derive(Debug, Default)]
struct JobTable {
    last_number: u64,
    /// Completion time and file; no file = cancelled.
    jobs: BTreeMap<u64, (Instant, Option<Bytes>)>,
}

impl VendorJobs {
    /// Starts a job that ends with this file after a while; returns its number.
    pub fn begin(&self, file: Bytes, takes: Duration) -> u64 {
        let mut table = self.table();
        table.last_number += 1;
        let number = table.last_number;
        table.jobs.insert(number, (Instant::now() + takes, Some(file)));
        if table.jobs.len() > REMEMBERED {
            table.jobs.pop_first();
        }
        number
    }

    /// `None` for an unknown job.
    pub fn status(&self, number: u64) -> Option<VendorJob> {
        let table = self.table();
        let (done_at, file) = table.jobs.get(&number)?;
        Some(match file {
            None => VendorJob::Cancelled,
            Some(_) if Instant::now() < *done_at => VendorJob::Working,
            Some(file) => VendorJob::Done(file.clone()),
        })
    }

    /// Cancels the job; `false` if it is unknown.
    pub fn cancel(&self, number: u64) -> bool {
        self.table().jobs.get_mut(&number).map(|(_, file)| *file = None).is_some()
    }

    fn table(&self) -> std::sync::MutexGuard<'_, JobTable> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn jobs_finish_after_their_duration_and_can_be_cancelled() {
        let jobs = VendorJobs::default();
        let slow = jobs.begin("a".into(), Duration::from_secs(3600));
        let quick = jobs.begin("b".into(), Duration::ZERO);
        assert_eq!(jobs.status(slow), Some(VendorJob::Working));
        assert_eq!(jobs.status(quick), Some(VendorJob::Done("b".into())));
        assert!(jobs.cancel(slow) && !jobs.cancel(99));
        assert_eq!((jobs.status(slow), jobs.status(99)), (Some(VendorJob::Cancelled), None));
    }
}
