//! Progress of work that is counted: a line on standard error every few seconds, and one at the end.

use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use super::terminal;

/// Least time between two lines.
const PERIOD: Duration = Duration::from_secs(5);

/// Progress of one command.
pub struct Counting {
    /// Name of what is counted, such as `scenes read`.
    what: &'static str,
    is_quiet: bool,
    started: Instant,
    last: Mutex<Last>,
}

/// The last line, and the first count: what was there before this command says nothing about its pace.
#[derive(Default)]
struct Last {
    written: Option<Instant>,
    first: Option<u64>,
}

impl Counting {
    pub fn new(what: &'static str, is_quiet: bool) -> Self {
        Self { what, is_quiet, started: Instant::now(), last: Mutex::default() }
    }

    /// Writes a line where it is time, or where `done` is all.
    pub fn see(&self, done: u64, all: u64) {
        self.see_with(done, all, String::new);
    }

    /// As [`Self::see`], with a detail behind the count.
    pub fn see_with(&self, done: u64, all: u64, detail: impl FnOnce() -> String) {
        if self.is_quiet {
            return;
        }
        let mut last = self.last.lock().unwrap_or_else(PoisonError::into_inner);
        let first = *last.first.get_or_insert(done);
        let since = last.written.map_or(self.started.elapsed(), |written| written.elapsed());
        if since < PERIOD && done < all {
            return;
        }
        last.written = Some(Instant::now());
        let (made, left) = (done.saturating_sub(first), all.saturating_sub(done));
        let time = match made > 0 && left > 0 {
            true => {
                format!(", {:.0} s left", self.started.elapsed().as_secs_f64() * left as f64 / made as f64)
            }
            false => String::new(),
        };
        terminal::note(&format!("  {} of {all} {}{}{time}", done.min(all), self.what, detail()));
    }
}
