//! Statements of requests of every kind beside their source: seed, labels, options and schedule.

use std::collections::BTreeMap;

use jiff::Timestamp;
use serde_json::json;
use uuid::Uuid;

use super::App;
use super::submission::Submission;
use crate::problem::{FieldError, Problem};
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

impl App {
    /// The submission of a source on terms that must be valid. The settings of its options are checked by
    /// `App::violations` in `app::pipeline`.
    ///
    /// # Errors
    ///
    /// A [`Problem`] with every setting of the options that the configuration does not accept.
    pub(super) fn submission(&self, terms: Terms, input: Input) -> Result<Submission, Problem> {
        let Terms { seed, labels, options, priority, not_before_ms, deadline_ms } = terms;
        let schedule = (priority, not_before_ms, deadline_ms);
        let mut content = json!({ "input": input, "seed": seed, "labels": labels, "options": options });
        if schedule != (0, None, None) {
            content["schedule"] = json!(schedule);
        }
        let body_digest = Digest::of(content.to_string().as_bytes());
        let request = SceneRequest::new(input, seed.unwrap_or_else(draw_seed), options);
        let errors = self.violations(&request);
        if !errors.is_empty() {
            return Err(Problem::invalid(errors));
        }
        Ok(Submission {
            request,
            parent_id: None,
            labels,
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
