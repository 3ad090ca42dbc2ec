//! Progress on standard error, and the summary at the end.
//!
//! On a terminal one line shows the progress and is written over; elsewhere every request that ends has a line.

use std::io::{IsTerminal, Write};
use std::path::PathBuf;

use serde_json::json;

use super::records::{ERRORS, OUTPUT};
use crate::cli::terminal;
use batches::pace::in_words;
use batches::{OutputLine, Pace, RequestCounts, RequestState};
use scene::MicroUsd;

/// Cells of the bar.
const BAR_CELLS: u64 = 24;

/// Output of the progress.
#[derive(Clone, Copy)]
pub(super) struct Report {
    is_live: bool,
    is_quiet: bool,
}

/// Results of a run.
pub(super) struct Summary {
    pub(super) counts: RequestCounts,
    pub(super) pace: Pace,
    pub(super) spent: Option<MicroUsd>,
    pub(super) out: PathBuf,
}

impl Report {
    /// `is_quiet` writes nothing.
    pub(super) fn new(is_quiet: bool) -> Self {
        let is_quiet = is_quiet || terminal::is_quiet();
        Self { is_live: std::io::stderr().is_terminal() && !is_quiet, is_quiet }
    }

    /// A line of the file will not do.
    pub(super) fn wrong(&self, message: &str) {
        self.line(message);
    }

    /// A request came to its end.
    pub(super) fn ended(&self, line: &OutputLine, counts: &RequestCounts) {
        let has_failed = line.state != RequestState::Succeeded;
        // On a terminal the bar shows the rest.
        if has_failed || !self.is_live {
            let name = line.custom_id.as_deref().unwrap_or("?");
            let error = line.error.as_ref().map(|error| format!(": {} ({})", error.message, error.code));
            let (done, all) = (counts.finished(), counts.computed());
            let error = error.unwrap_or_default();
            self.line(&format!("{done}/{all} {name} {} {:.1} s{error}", line.state.as_str(), line.stages_s));
        }
    }

    /// Shows how far the batch is.
    pub(super) fn show(&self, counts: &RequestCounts, pace: Pace) {
        if self.is_live {
            // A failure here cannot be reported anywhere.
            let _ = write!(std::io::stderr().lock(), "\r\x1b[K{}", bar(counts, pace));
        }
    }

    /// Ends the line of the progress.
    pub(super) fn close(&self) {
        if self.is_live {
            terminal::note("");
        }
    }

    fn line(&self, line: &str) {
        if !self.is_quiet {
            let clear = if self.is_live { "\r\x1b[K" } else { "" };
            terminal::note(&format!("{clear}{line}"));
        }
    }
}

/// `[=====     ] 12/100  340 scenes/h  15 min 30 s left  2 failed`
fn bar(counts: &RequestCounts, pace: Pace) -> String {
    let (done, all) = (counts.finished(), counts.computed());
    let cells = (BAR_CELLS * done / all.max(1)) as usize;
    let mut text = format!("[{:<width$}] {done}/{all}", "=".repeat(cells), width = BAR_CELLS as usize);
    if let (Some(per_hour), Some(left)) = (pace.per_hour(), pace.time_left(counts.remaining())) {
        text.push_str(&format!("  {per_hour:.0} scenes/h  {} left", in_words(left)));
    }
    for (count, word) in problems(counts) {
        text.push_str(&format!("  {count} {word}"));
    }
    text
}

/// Requests that have no scene that passes, by state.
fn problems(counts: &RequestCounts) -> impl Iterator<Item = (u64, &'static str)> {
    let RequestCounts { failed, quarantined, cancelled, invalid, .. } = *counts;
    let all =
        [(failed, "failed"), (quarantined, "quarantined"), (cancelled, "cancelled"), (invalid, "invalid")];
    all.into_iter().filter(|(count, _)| *count > 0)
}

impl Summary {
    /// For people.
    pub(super) fn text(&self) -> String {
        let counts = &self.counts;
        let mut text = format!("{} of {} requests succeeded", counts.succeeded, counts.total);
        if counts.duplicate > 0 {
            text.push_str(&format!(", {} duplicate", counts.duplicate));
        }
        for (count, word) in problems(counts) {
            text.push_str(&format!(", {count} {word}"));
        }
        if let Some(per_hour) = self.pace.per_hour() {
            let elapsed = in_words(self.pace.elapsed);
            text.push_str(&format!("; {} in {elapsed}, {per_hour:.0} scenes per hour", self.pace.finished));
        }
        if let Some(spent) = self.spent {
            text.push_str(&format!("; spent {spent}"));
        }
        let path = |name: &str| self.out.join(name).display().to_string();
        text.push_str(&format!("\n{}\n", path(OUTPUT)));
        if problems(counts).any(|(_, word)| word != "quarantined") {
            text.push_str(&format!("{}\n", path(ERRORS)));
        }
        text
    }

    /// For programs.
    pub(super) fn document(&self) -> String {
        let path = |name: &str| self.out.join(name).display().to_string();
        let document = json!({
            "request_counts": self.counts,
            "finished_in_this_run": self.pace.finished,
            "elapsed_s": self.pace.elapsed.as_secs_f64(),
            "scenes_per_hour": self.pace.per_hour(),
            "spent_usd": self.spent.map(MicroUsd::usd),
            "output": path(OUTPUT),
            "errors": path(ERRORS),
            "failure": null,
        });
        format!("{document:#}\n")
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;

    fn counts(states: &[(RequestState, u64)]) -> RequestCounts {
        let mut counts = RequestCounts::default();
        for (state, count) in states {
            (0..*count).for_each(|_| counts.add(*state));
        }
        counts
    }

    #[test]
    fn the_bar_shows_progress_pace_and_problems() {
        use RequestState as S;
        let fresh = counts(&[(S::Pending, 8), (S::Running, 2)]);
        assert_eq!(bar(&fresh, Pace::default()), format!("[{}] 0/10", " ".repeat(24)));
        let half =
            counts(&[(S::Pending, 4), (S::Running, 1), (S::Succeeded, 4), (S::Failed, 1), (S::Duplicate, 7)]);
        let pace = Pace { finished: 5, elapsed: Duration::from_secs(60) };
        let expected =
            format!("[{}{}] 5/10  300 scenes/h  1 min 0 s left  1 failed", "=".repeat(12), " ".repeat(12));
        assert_eq!(bar(&half, pace), expected);
        assert!(bar(&counts(&[(S::Invalid, 2)]), Pace::default()).ends_with("0/0  2 invalid"));
    }

    #[test]
    fn the_summary_names_the_files_and_what_went_wrong() {
        use RequestState as S;
        let summary = |counts| Summary { counts, pace: Pace::default(), spent: None, out: "out".into() };
        let good = summary(counts(&[(S::Succeeded, 3), (S::Duplicate, 1)]));
        assert_eq!(good.text(), "3 of 4 requests succeeded, 1 duplicate\nout/output.jsonl\n");
        let bad = Summary {
            spent: Some(MicroUsd(1_500_000)),
            ..summary(counts(&[(S::Succeeded, 1), (S::Invalid, 1)]))
        };
        assert_eq!(
            bad.text(),
            "1 of 2 requests succeeded, 1 invalid; spent $1.500000\nout/output.jsonl\nout/errors.jsonl\n"
        );
        let document: serde_json::Value = serde_json::from_str(&bad.document()).expect("JSON");
        assert_eq!(document["request_counts"]["invalid"], 1);
    }
}
