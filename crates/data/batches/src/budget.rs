//! The total cost that the remote calls of all requests of a batch may have.
//!
//! Every request gets a budget of its own before it begins, out of what is neither spent nor promised to another
//! request. The sum of all costs can therefore not exceed the total, however many requests run at the same time.

use scene::MicroUsd;

/// Money of a batch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BatchBudget {
    total: MicroUsd,
    spent: MicroUsd,
    /// Budgets of requests that have not ended.
    promised: MicroUsd,
}

/// Answer to a request for money.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Grant {
    /// The budget of the request.
    Granted(MicroUsd),
    /// Too little is free now; ask again when a running request has ended.
    Wait,
    /// Budget that is spent.
    Exhausted,
}

impl BatchBudget {
    pub fn new(total: MicroUsd) -> Self {
        Self { total, spent: MicroUsd::ZERO, promised: MicroUsd::ZERO }
    }

    /// Cost of the requests that have ended.
    pub fn spent(&self) -> MicroUsd {
        self.spent
    }

    /// Promises a request the budget that it wants. The last requests get what is left.
    pub fn promise(&mut self, wanted: MicroUsd) -> Grant {
        let free = MicroUsd(self.total.0 - self.spent.0 - self.promised.0);
        let granted = if free >= wanted {
            wanted
        } else if self.promised > MicroUsd::ZERO {
            return Grant::Wait;
        } else if free > MicroUsd::ZERO {
            free
        } else {
            return Grant::Exhausted;
        };
        self.promised.0 += granted.0;
        Grant::Granted(granted)
    }

    /// Notes the promise to a request that began in an earlier run.
    pub fn note_promise(&mut self, promised: MicroUsd) {
        self.promised.0 += promised.0;
    }

    /// Ends a promise with what the request did spend.
    pub fn settle(&mut self, promised: MicroUsd, spent: MicroUsd) {
        self.promised.0 = (self.promised.0 - promised.0).max(0);
        self.spent.0 += spent.0;
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn the_last_request_gets_the_rest_and_then_nothing_is_left() {
        let mut budget = BatchBudget::new(MicroUsd(250));
        assert_eq!(budget.promise(MicroUsd(100)), Grant::Granted(MicroUsd(100)));
        assert_eq!(budget.promise(MicroUsd(100)), Grant::Granted(MicroUsd(100)));
        assert_eq!(budget.promise(MicroUsd(100)), Grant::Wait, "50 are free, and more may become free");
        budget.settle(MicroUsd(100), MicroUsd(10));
        assert_eq!(budget.promise(MicroUsd(100)), Grant::Granted(MicroUsd(100)));
        budget.settle(MicroUsd(100), MicroUsd(100));
        budget.settle(MicroUsd(100), MicroUsd(100));
        assert_eq!(budget.promise(MicroUsd(100)), Grant::Granted(MicroUsd(40)));
        budget.settle(MicroUsd(40), MicroUsd(40));
        assert_eq!((budget.promise(MicroUsd(1)), budget.spent()), (Grant::Exhausted, MicroUsd(250)));
        assert_eq!(budget.promise(MicroUsd(0)), Grant::Granted(MicroUsd(0)), "what costs nothing may go on");
    }

    proptest! {
        #[test]
        fn requests_never_spend_more_than_the_total(
            total in 0_i64..1000,
            steps in prop::collection::vec((0_i64..300, 0_i64..100), 1..60),
        ) {
            let mut budget = BatchBudget::new(MicroUsd(total));
            let mut running = Vec::new();
            for (wanted, share_percent) in steps {
                match budget.promise(MicroUsd(wanted)) {
                    Grant::Granted(granted) => running.push(granted),
                    Grant::Wait => {
                        prop_assert!(!running.is_empty());
                        let granted: MicroUsd = running.remove(0);
                        budget.settle(granted, MicroUsd(granted.0 * share_percent / 100));
                    }
                    Grant::Exhausted => prop_assert!(running.iter().all(|granted| granted.0 == 0)),
                }
                let promised: i64 = running.iter().map(|granted| granted.0).sum();
                prop_assert!(budget.spent().0 + promised <= total);
            }
        }
    }
}
