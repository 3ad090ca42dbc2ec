//! Statements of requests of every kind beside their source: seed, labels, options and schedule.

use std::collections::BTreeMap;

use jiff::Timestamp;

use crate::problem::FieldError;
use scene::request::{MAX_SEED, RequestOptions};
use scene::{Violation, labels};

/// Largest priority, and smallest below zero.
const MAX_PRIORITY: i64 = 100;

/// Seed, labels, options and schedule of a request, not validated.
#[derive(Clone, Debug, Default)]
pub struct Terms {
    /// Drawn where it is absent.
    pub seed: Option<u64>,
    pub labels: BTreeMap<String, String>,
    pub options: RequestOptions,
    /// Orders the jobs of the client; more is sooner.
    pub priority: i64,
    /// The job starts no earlier, milliseconds since 1970.
    pub not_before_ms: Option<i64>,
    /// The job fails if it has not ended by then, milliseconds since 1970.
    pub deadline_ms: Option<i64>,
}

impl Terms {
    /// Every violation, with pointers into the body.
    pub fn errors(&self) -> Vec<FieldError> {
        let mut errors = Vec::new();
        let mut wrong = |pointer: &str, detail: String| errors.push(FieldError::new(pointer, detail));
        if self.seed.is_some_and(|seed| seed > MAX_SEED) {
            wrong("/seed", format!("must be at most {MAX_SEED}"));
        }
        for Violation { pointer, detail } in labels::violations(&self.labels) {
            wrong(&format!("/labels{pointer}"), detail);
        }
        for Violation { pointer, detail } in self.options.violations() {
            wrong(&format!("/options{pointer}"), detail);
        }
        self.check_schedule(&mut wrong);
        errors
    }

    fn check_schedule(&self, wrong: &mut impl FnMut(&str, String)) {
        let Self { priority, not_before_ms, deadline_ms, .. } = *self;
        if !(-MAX_PRIORITY..=MAX_PRIORITY).contains(&priority) {
            wrong("/priority", format!("must be from -{MAX_PRIORITY} to {MAX_PRIORITY}"));
        }
        if deadline_ms.is_some_and(|deadline_ms| deadline_ms <= not_before_ms.unwrap_or(0)) {
            wrong("/deadline", "must be later than `not_before`".into());
        } else if deadline_ms.is_some_and(|deadline_ms| deadline_ms <= Timestamp::now().as_millisecond()) {
            wrong("/deadline", "has passed already".into());
        }
    }
}
