//! Jobs that a vendor works on for a while: an id at once, a file later.

use std::collections::BTreeMap;
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use bytes::Bytes;

/// Most jobs that are remembered; the oldest go first.
const REMEMBERED: usize = 1024;

/// A job, as somebody who looks at it finds it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum VendorJob {
    Working,
    Done(Bytes),
    Cancelled,
}

/// All jobs of all protocols.
#[derive(Debug, Default)]
pub(super) struct VendorJobs(Mutex<Book>);

#[derive(Debug, Default)]
struct Book {
    begun: u64,
    /// Done from that time on; no file = cancelled.
    jobs: BTreeMap<u64, (Instant, Option<Bytes>)>,
}

impl VendorJobs {
    /// Begins a job that ends with this file after a while; its number.
    pub fn begin(&self, file: Bytes, takes: Duration) -> u64 {
        let mut book = self.book();
        book.begun += 1;
        let number = book.begun;
        book.jobs.insert(number, (Instant::now() + takes, Some(file)));
        if book.jobs.len() > REMEMBERED {
            book.jobs.pop_first();
        }
        number
    }

    /// `None` for a job that nobody has begun.
    pub fn look(&self, number: u64) -> Option<VendorJob> {
        let book = self.book();
        let (done_at, file) = book.jobs.get(&number)?;
        Some(match file {
            None => VendorJob::Cancelled,
            Some(_) if Instant::now() < *done_at => VendorJob::Working,
            Some(file) => VendorJob::Done(file.clone()),
        })
    }

    /// Whether there was such a job.
    pub fn cancel(&self, number: u64) -> bool {
        self.book().jobs.get_mut(&number).map(|(_, file)| *file = None).is_some()
    }

    fn book(&self) -> std::sync::MutexGuard<'_, Book> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn jobs_take_their_time_and_can_be_cancelled() {
        let jobs = VendorJobs::default();
        let slow = jobs.begin("a".into(), Duration::from_secs(3600));
        let quick = jobs.begin("b".into(), Duration::ZERO);
        assert_eq!(jobs.look(slow), Some(VendorJob::Working));
        assert_eq!(jobs.look(quick), Some(VendorJob::Done("b".into())));
        assert!(jobs.cancel(slow) && !jobs.cancel(99));
        assert_eq!((jobs.look(slow), jobs.look(99)), (Some(VendorJob::Cancelled), None));
    }
}
