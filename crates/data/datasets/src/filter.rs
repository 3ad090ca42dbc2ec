//! Conditions on certificate, content and labels that select scenes.
//!
//! The text form is a list of `key=value` with commas: `verdict=any,min_objects=3,category=mug,label.state=succeeded`.

use std::collections::BTreeMap;
use std::str::FromStr;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::batch_output::BatchRecord;
use crate::facts::SceneFacts;

/// Conditions; a scene must meet all. The default accepts every scene that passed its certificate.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
#[schemars(
    rename = "DatasetFilter",
    description = "Conditions; a scene must meet all. Those that are absent hold, but that the verdict must be `pass`."
)]
pub struct Filter {
    pub verdict: VerdictCondition,
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0, max = 1_000_000))]
    pub min_objects: Option<usize>,
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0, max = 1_000_000))]
    pub max_objects: Option<usize>,
    /// Each category must occur.
    pub required_categories: Vec<String>,
    /// None of the categories may occur.
    pub excluded_categories: Vec<String>,
    /// Labels of the batch's record, by name.
    pub labels: BTreeMap<String, String>,
}

/// Condition on the certificate.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
#[schemars(description = "Condition on the verdict of a scene.")]
pub enum VerdictCondition {
    #[default]
    Pass,
    Quarantine,
    Any,
}

/// The reason why a text is no filter; the message states the correction.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum FilterError {
    #[error("{0:?} is not of the form KEY=VALUE")]
    NoValue(String),
    #[error("{key} needs a whole number, not {value:?}")]
    NotWhole { key: String, value: String },
    #[error("verdict is pass, quarantine or any, not {0:?}")]
    Verdict(String),
    #[error(
        "{0:?} is no condition; give verdict, min_objects, max_objects, category, not_category or label.NAME"
    )]
    UnknownKey(String),
}

impl Filter {
    /// The first condition that the scene does not meet, by its name; `None` for a scene that is selected.
    pub fn refusal(&self, facts: &SceneFacts, record: Option<&BatchRecord>) -> Option<&'static str> {
        let count = facts.objects.len();
        let has = |category: &String| facts.objects.iter().any(|object| object.category == *category);
        let meets_label = |(name, value): (&String, &String)| {
            record.and_then(|record| record.label(name)).is_some_and(|label| label == *value)
        };
        let verdict = match self.verdict {
            VerdictCondition::Pass => facts.passed(),
            VerdictCondition::Quarantine => !facts.passed(),
            VerdictCondition::Any => true,
        };
        let conditions = [
            ("verdict", verdict),
            ("min_objects", self.min_objects.is_none_or(|min| count >= min)),
            ("max_objects", self.max_objects.is_none_or(|max| count <= max)),
            ("required_category", self.required_categories.iter().all(has)),
            ("excluded_category", !self.excluded_categories.iter().any(has)),
            ("label", self.labels.iter().all(meets_label)),
        ];
        conditions.into_iter().find(|(_, met)| !met).map(|(name, _)| name)
    }

    /// Adds one condition in its text form.
    ///
    /// # Errors
    ///
    /// [`FilterError`] for another key, or a value that is none of the key.
    pub fn add(&mut self, key: &str, value: &str) -> Result<(), FilterError> {
        let given = || value.to_owned();
        let number =
            || value.parse().map_err(|_| FilterError::NotWhole { key: key.to_owned(), value: given() });
        match key {
            "verdict" => {
                self.verdict = match value {
                    "pass" => VerdictCondition::Pass,
                    "quarantine" => VerdictCondition::Quarantine,
                    "any" => VerdictCondition::Any,
                    _ => return Err(FilterError::Verdict(given())),
                };
            }
            "min_objects" => self.min_objects = Some(number()?),
            "max_objects" => self.max_objects = Some(number()?),
            "category" => self.required_categories.push(value.to_owned()),
            "not_category" => self.excluded_categories.push(value.to_owned()),
            _ => match key.strip_prefix("label.") {
                Some(name) if !name.is_empty() => {
                    self.labels.insert(name.to_owned(), value.to_owned());
                }
                _ => return Err(FilterError::UnknownKey(key.to_owned())),
            },
        }
        Ok(())
    }
}

impl FromStr for Filter {
    type Err = FilterError;

    fn from_str(text: &str) -> Result<Self, FilterError> {
        let mut filter = Self::default();
        for condition in text.split(',').map(str::trim).filter(|condition| !condition.is_empty()) {
            let (key, value) =
                condition.split_once('=').ok_or_else(|| FilterError::NoValue(condition.to_owned()))?;
            filter.add(key.trim(), value.trim())?;
        }
        for list in [&mut filter.required_categories, &mut filter.excluded_categories] {
            list.sort();
            list.dedup();
        }
        Ok(filter)
    }
}
