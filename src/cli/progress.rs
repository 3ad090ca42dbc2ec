//! A line per stage on standard error, made of the job's events; and the times of the stages.
//!
//! A stage's line is written when it is over: name, instances done of how many, seconds. On a terminal
//! the running stage is shown meanwhile. What was found from an earlier run says so.

use std::io::{IsTerminal, Write};

use serde::Serialize;

use super::terminal;
use crate::pipeline::CONCURRENT_STAGES;
use store::events::Event;

/// One stage, as far as events tell.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct StageTime {
    pub stage: String,
    /// Instances it worked on; 0 when it works on the whole scene.
    pub instances: usize,
    /// Number of its runs that were found instead of computed.
    pub found: usize,
    /// From its first event to its last, milliseconds.
    pub wall_ms: i64,
    /// Sum over its runs of the time computing took (now, or when it was computed), milliseconds.
    pub work_ms: i64,
    #[serde(skip)]
    started_at_ms: i64,
    #[serde(skip)]
    begun: usize,
    #[serde(skip)]
    done: usize,
    #[serde(skip)]
    shown: bool,
}

/// Progress of a job, from its events.
pub struct Progress {
    stages: Vec<StageTime>,
    /// Present stage of the job, in words.
    running: String,
    live: bool,
    quiet: bool,
}

impl Progress {
    /// `quiet` writes nothing.
    pub fn new(quiet: bool) -> Self {
        let quiet = quiet || terminal::is_quiet();
        let live = std::io::stderr().is_terminal() && !quiet;
        Self { stages: Vec::new(), running: "before the first stage".to_owned(), live, quiet }
    }

    /// Takes the next event.
    pub fn see(&mut self, event: &Event) {
        let text = |name: &str| event.data[name].as_str().unwrap_or_default().to_owned();
        let stage = text("stage");
        let per_instance = event.data["instance"].is_string();
        match event.kind.as_str() {
            "stage_started" => {
                self.running = format!("in stage {stage}");
                self.close_all_but(&stage);
                self.stage(&stage, event.at_ms).begun += 1;
                self.show_live(&stage);
            }
            "stage_finished" => {
                self.close_all_but(&stage);
                let cached = event.data["cached"] == true;
                let elapsed_ms = event.data["elapsed_ms"].as_i64().unwrap_or(0);
                let time = self.stage(&stage, event.at_ms);
                time.done += 1;
                time.begun = time.begun.max(time.done);
                time.instances += usize::from(per_instance);
                time.found += usize::from(cached);
                time.work_ms += elapsed_ms;
                time.wall_ms = event.at_ms - time.started_at_ms;
                match per_instance {
                    true => self.show_live(&stage),
                    false => self.close_all_but(""),
                }
            }
            "stage_progress" => self.line(&format!("  {stage}: {}", text("message"))),
            "job_retrying" => {
                let seconds = event.data["delay_ms"].as_f64().unwrap_or(0.0) / 1000.0;
                let message = event.data["failure"]["message"].as_str().unwrap_or_default();
                self.line(&format!("  {message}; trying again in {seconds:.1} s"));
            }
            "job_succeeded" | "job_failed" | "job_cancelled" => self.finish(),
            _ => {}
        }
    }

    /// Writes the lines of the stages that are over, where no further event is to come.
    pub fn finish(&mut self) {
        self.close_all_but("");
    }

    /// Present or last stage of the job, in words.
    pub fn place(&self) -> &str {
        &self.running
    }

    /// Times of the stages, in the order the job came to them.
    pub fn into_times(self) -> Vec<StageTime> {
        self.stages
    }

    fn stage(&mut self, name: &str, at_ms: i64) -> &mut StageTime {
        let index = self.stages.iter().position(|time| time.stage == name).unwrap_or_else(|| {
            self.stages.push(StageTime {
                stage: name.to_owned(),
                instances: 0,
                found: 0,
                wall_ms: 0,
                work_ms: 0,
                started_at_ms: at_ms,
                begun: 0,
                done: 0,
                shown: false,
            });
            self.stages.len() - 1
        });
        &mut self.stages[index]
    }

    /// Writes the lines of stages with nothing under way, except that of `current` and of what may run beside
    /// it.
    fn close_all_but(&mut self, current: &str) {
        let over = |time: &StageTime| {
            let beside = [time.stage.as_str(), current].iter().all(|stage| CONCURRENT_STAGES.contains(stage));
            !time.shown && time.stage != current && !beside && time.done == time.begun
        };
        let lines: Vec<String> = self.stages.iter().filter(|time| over(time)).map(line_of).collect();
        self.stages.iter_mut().filter(|time| over(time)).for_each(|time| time.shown = true);
        lines.iter().for_each(|line| self.line(line));
    }

    fn line(&self, line: &str) {
        if !self.quiet {
            let clear = if self.live { "\r\x1b[K" } else { "" };
            terminal::note(&format!("{clear}{line}"));
        }
    }

    fn show_live(&self, name: &str) {
        if let Some(time) = self.stages.iter().find(|time| self.live && time.stage == name) {
            let count = if time.begun > 1 { format!("{}/{}", time.done, time.begun) } else { String::new() };
            let _ = write!(std::io::stderr().lock(), "\r\x1b[K{name:<14} {count:>7} ...");
        }
    }
}

fn line_of(time: &StageTime) -> String {
    let count = if time.instances > 0 { format!("{}/{}", time.done, time.begun) } else { String::new() };
    let seconds = time.wall_ms as f64 / 1000.0;
    let found = match time.found {
        0 => String::new(),
        all if all == time.done => "  found, not computed".to_owned(),
        some => format!("  {some} found, not computed"),
    };
    format!("{:<14} {count:>7} {seconds:>8.2} s{found}", time.stage)
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn times_and_lines_come_from_events() {
        let mut progress = Progress::new(true);
        let mut at_ms = 0;
        let mut see = |kind: &str, data: serde_json::Value| {
            at_ms += 10;
            progress.see(&Event { seq: at_ms, at_ms, kind: kind.into(), data });
        };
        see("stage_started", json!({ "stage": "reference" }));
        see("stage_finished", json!({ "stage": "reference", "elapsed_ms": 9, "cached": false }));
        for name in ["mug_1", "mug_2"] {
            see("stage_started", json!({ "stage": "reconstruct", "instance": name }));
        }
        for name in ["mug_2", "mug_1"] {
            let data = json!({ "stage": "reconstruct", "instance": name, "elapsed_ms": 5, "cached": false });
            see("stage_finished", data);
        }
        see("stage_finished", json!({ "stage": "bundle", "elapsed_ms": 700, "cached": true }));
        let times = progress.into_times();
        let seen: Vec<_> =
            times.iter().map(|t| (t.stage.as_str(), t.instances, t.found, t.wall_ms, t.work_ms)).collect();
        assert_eq!(
            seen,
            [("reference", 0, 0, 10, 9), ("reconstruct", 2, 0, 30, 10), ("bundle", 0, 1, 0, 700)]
        );
        assert_eq!(line_of(&times[1]), "reconstruct        2/2     0.03 s");
        assert!(line_of(&times[2]).ends_with("0.00 s  found, not computed"));
    }

    #[test]
    fn a_stage_is_not_over_while_the_one_beside_it_runs() {
        let mut progress = Progress::new(true);
        let mut see = |kind: &str, stage: &str, instance: &str| {
            let data = json!({ "stage": stage, "instance": instance, "elapsed_ms": 5, "cached": false });
            progress.see(&Event { seq: 0, at_ms: 0, kind: kind.into(), data });
            progress.stages.iter().filter(|time| time.shown).map(line_of).collect::<Vec<_>>()
        };
        for (stage, instance) in [("decompose", "mug_1"), ("rotate", "mug_1"), ("decompose", "mug_2")] {
            see("stage_started", stage, instance);
            assert!(see("stage_finished", stage, instance).is_empty());
        }
        let shown = see("stage_started", "place", "");
        assert_eq!(shown.len(), 2);
        assert!(shown[0].contains("decompose") && shown[0].contains("2/2"), "{shown:?}");
    }
}
