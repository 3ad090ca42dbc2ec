//! Parameters of a batch beside its requests.

use schemars::JsonSchema;
use serde::Deserialize;

use crate::schemas::values;
use scene::MicroUsd;
use scene::request::MAX_BUDGET_USD;

/// Largest budget of a batch: that of a thousand of the dearest scenes, US dollars.
const MAX_BATCH_BUDGET_USD: f64 = 1000.0 * MAX_BUDGET_USD;

/// Parameters of `POST /batches`.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct SubmitParameters {
    /// For people; need not be unique.
    #[schemars(with = "Option<values::BatchName>")]
    pub(super) name: Option<BatchName>,
    /// The most that calls of remote models for all requests may cost together.
    #[schemars(with = "Option<values::BatchBudget>")]
    pub(super) budget_usd: Option<QueryBudget>,
}

/// Name of a batch.
#[derive(Clone, Debug, Deserialize, PartialEq, Eq)]
#[serde(try_from = "String")]
pub(super) struct BatchName(pub(super) String);

impl TryFrom<String> for BatchName {
    type Error = &'static str;

    fn try_from(text: String) -> Result<Self, Self::Error> {
        let is_fine = (1..=255).contains(&text.chars().count()) && !text.chars().any(char::is_control);
        if is_fine { Ok(Self(text)) } else { Err("must have 1 to 255 characters, none of control") }
    }
}

/// A budget in a JSON body.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq)]
#[serde(try_from = "f64")]
pub(super) struct BudgetUsd(f64);

impl BudgetUsd {
    pub(super) fn amount(self) -> MicroUsd {
        MicroUsd::of_usd(self.0)
    }
}

impl TryFrom<f64> for BudgetUsd {
    type Error = String;

    fn try_from(usd: f64) -> Result<Self, Self::Error> {
        let is_fine = (0.0..=MAX_BATCH_BUDGET_USD).contains(&usd);
        is_fine.then_some(Self(usd)).ok_or_else(|| format!("must be from 0 to {MAX_BATCH_BUDGET_USD}"))
    }
}

/// A budget in a query.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq)]
#[serde(try_from = "String")]
pub(super) struct QueryBudget(pub(super) BudgetUsd);

impl TryFrom<String> for QueryBudget {
    type Error = String;

    fn try_from(text: String) -> Result<Self, Self::Error> {
        let usd: f64 = text.parse().map_err(|_| "must be a number of US dollars, such as 12.5".to_owned())?;
        usd.try_into().map(Self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn budgets_are_finite_and_not_negative() {
        let read = |text: &str| QueryBudget::try_from(text.to_owned()).map(|budget| budget.0.amount());
        assert_eq!(read("12.5"), Ok(MicroUsd(12_500_000)));
        assert_eq!(read("0"), Ok(MicroUsd(0)));
        for text in ["-1", "nan", "inf", "1e9", "ten", ""] {
            assert!(read(text).is_err(), "{text}");
        }
    }

    #[test]
    fn names_are_short_and_visible() {
        for (name, is_fine) in [("Küche 7", true), ("", false), ("a\nb", false), (&"x".repeat(256), false)] {
            assert_eq!(BatchName::try_from(name.to_owned()).is_ok(), is_fine, "{name}");
        }
    }
}
