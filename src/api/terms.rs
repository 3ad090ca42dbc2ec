//! Statements of requests of every kind beside their source: seed, labels, options and schedule.

use std::collections::BTreeMap;

use jiff::Timestamp;
use serde_json::json;
use uuid::Uuid;

use super::Validate;
use super::error::{FieldError, Problem};
use super::query::Time;
use super::submission::Submission;
use scene::request::{MAX_SEED, RequestOptions};
use scene::{Input, SceneRequest};
use scene::{Violation, labels};
use store::Digest;

/// Largest priority, and smallest below zero.
const MAX_PRIORITY: i64 = 100;

/// Seed, labels, options and schedule of a request, not validated.
#[derive(Clone, Debug, Default)]
pub struct Terms {
    /// Drawn where it is absent.
    pub seed: Option<u64>,
    pub labels: BTreeMap<String, String>,
    pub options: RequestOptions,
    pub priority: Option<i64>,
    pub not_before: Option<Time>,
    pub deadline: Option<Time>,
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
        let (priority, not_before_ms, deadline_ms) = self.schedule();
        if !(-MAX_PRIORITY..=MAX_PRIORITY).contains(&priority) {
            wrong("/priority", format!("must be from -{MAX_PRIORITY} to {MAX_PRIORITY}"));
        }
        if deadline_ms.is_some_and(|deadline_ms| deadline_ms <= not_before_ms.unwrap_or(0)) {
            wrong("/deadline", "must be later than `not_before`".into());
        } else if deadline_ms.is_some_and(|deadline_ms| deadline_ms <= Timestamp::now().as_millisecond()) {
            wrong("/deadline", "has passed already".into());
        }
    }

    /// Priority, and the times in milliseconds since 1970.
    fn schedule(&self) -> (i64, Option<i64>, Option<i64>) {
        let (not_before, deadline) = (self.not_before.map(Time::as_ms), self.deadline.map(Time::as_ms));
        (self.priority.unwrap_or(0), not_before, deadline)
    }

    /// The submission of a source on these terms, which must be valid.
    ///
    /// # Errors
    ///
    /// A [`Problem`] with every setting of the options that the configuration does not accept.
    pub fn submission(self, input: Input, validate_settings: &Validate) -> Result<Submission, Problem> {
        let schedule = self.schedule();
        let mut content =
            json!({ "input": input, "seed": self.seed, "labels": self.labels, "options": self.options });
        if schedule != (0, None, None) {
            content["schedule"] = json!(schedule);
        }
        let body_digest = Digest::of(content.to_string().as_bytes());
        let seed = self.seed.unwrap_or_else(draw_seed);
        let request = SceneRequest::new(input, seed, self.options);
        let errors = validate_settings(&request);
        if !errors.is_empty() {
            return Err(Problem::invalid(errors));
        }
        let (priority, not_before_ms, deadline_ms) = schedule;
        Ok(Submission {
            request,
            parent_id: None,
            labels: self.labels,
            priority,
            not_before_ms,
            deadline_ms,
            image: None,
            bundle: None,
            body_digest,
        })
    }
}

/// A random seed, for a request without one; the scene reports it.
pub(super) fn draw_seed() -> u64 {
    // The version's four bits are the same in every one; the others are random.
    let random = Uuid::new_v4().as_u128();
    ((random ^ (random >> 64)) as u64) & MAX_SEED
}
