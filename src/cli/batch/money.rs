//! The total budget of a batch, where one is given and something can cost money.

use crate::app::config::Config;
use crate::cli::Failure;
use batches::{BatchBudget, Grant};
use scene::MicroUsd;
use scene::request::MAX_BUDGET_USD;

/// The budget, or that there is none.
pub(super) struct Money(Option<BatchBudget>);

/// The amount of `--budget`.
pub(super) fn checked(usd: f64) -> Result<MicroUsd, Failure> {
    if (0.0..=MAX_BUDGET_USD * 1000.0).contains(&usd) {
        return Ok(MicroUsd::of_usd(usd));
    }
    Err(Failure::usage(format!("--budget must be from 0 to {} US dollars", MAX_BUDGET_USD * 1000.0)))
}

impl Money {
    /// Without remote models nothing costs anything, and nothing has to wait for money.
    pub(super) fn new(config: &Config, total: Option<MicroUsd>) -> Self {
        Self(total.filter(|_| config.calls_remote_models()).map(BatchBudget::new))
    }

    /// Whether costs have to be known.
    pub(super) fn is_limited(&self) -> bool {
        self.0.is_some()
    }

    /// Cost of the requests that have ended; `None` where it is not known.
    pub(super) fn spent(&self) -> Option<MicroUsd> {
        self.0.as_ref().map(BatchBudget::spent)
    }

    /// The budget of a request that wants so much.
    pub(super) fn promise(&mut self, wanted: MicroUsd) -> Grant {
        self.0.as_mut().map_or(Grant::Granted(wanted), |budget| budget.promise(wanted))
    }

    /// A request that began in an earlier run has this budget.
    pub(super) fn note_promise(&mut self, promised: MicroUsd) {
        if let Some(budget) = &mut self.0 {
            budget.note_promise(promised);
        }
    }

    /// A request with this budget ended.
    pub(super) fn settle(&mut self, promised: MicroUsd, spent: MicroUsd) {
        if let Some(budget) = &mut self.0 {
            budget.settle(promised, spent);
        }
    }
}
