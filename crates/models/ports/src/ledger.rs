//! The cost ledger of calls: costs are reserved before a call is sent and settled after it. Ports do not know the
//! storage; they receive a [`Ledger`].

use std::sync::{Mutex, PoisonError};

use bytes::Bytes;
use futures::future::BoxFuture;
use serde::{Deserialize, Serialize};

use super::Port;

pub use scene::MicroUsd;

/// A call before it is sent.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Intent {
    pub port: Port,
    /// Adapter, as in its [`Adapter`](super::Adapter) (`openai/chat`).
    pub provider: String,
    pub model: String,
    /// The URL without secrets and queries.
    pub endpoint: String,
    /// `describe`, `recognize`.
    pub operation: &'static str,
    /// Digest of the request without its secrets; equal questions have equal digests.
    pub request_digest: String,
    /// 1 for the first attempt of this question.
    pub attempt: u32,
    /// Maximum cost.
    pub reserved: MicroUsd,
    /// Size of the request body.
    pub sent_bytes: u64,
    /// The policy where an earlier attempt of the question may have been answered, and the answer was lost.
    pub on_unknown: OnUnknown,
}

/// The policy for a call whose answer was lost, so that it is unknown whether it was billed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum OnUnknown {
    /// The job fails, and the operator decides.
    Fail,
    /// The call is sent again and may be billed twice; both count toward the budget.
    Resend,
}

/// A granted reservation.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Entry {
    /// The id of the ledger row.
    pub id: i64,
    /// Equal for all attempts of a question in one stage of one job: vendors with idempotency keys answer it once.
    pub idempotency_key: String,
    /// The digest of the question.
    pub request_digest: String,
}

/// The outcome of a call.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Settlement {
    /// `None` = unknown; then the reservation counts.
    pub cost: Option<MicroUsd>,
    pub received_bytes: u64,
    pub input_tokens: Option<u64>,
    pub output_tokens: Option<u64>,
    /// `answered`, `outcome_unknown`, or the code of a failure.
    pub outcome: &'static str,
    /// The vendor's id of the started job, where the result comes later.
    pub task: Option<String>,
    /// The usable answer, kept in case the stage dies before it completes.
    pub answer: Option<Bytes>,
}

/// A submitted job of a vendor that has not ended.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Task {
    /// The ledger row of the submitting call.
    pub entry_id: i64,
    /// The vendor's id.
    pub id: String,
    /// The downloaded file, if any.
    pub file: Option<Bytes>,
}

/// The outcome of an answered call.
pub const ANSWERED: &str = "answered";

/// The outcome of a call where it is unknown whether the vendor answered and billed it.
pub const OUTCOME_UNKNOWN: &str = "outcome_unknown";

/// Reason why a call is refused or could not be recorded.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum LedgerError {
    #[error(
        "it may cost {asked}, and {committed} of the scene's budget of {budget} are spent or reserved; submit the \
         scene with a larger options.budget_usd"
    )]
    OverBudget { asked: MicroUsd, committed: MicroUsd, budget: MicroUsd },
    #[error(
        "it may cost {asked}, and {committed} of the {limit} that its tenant may spend in a month are spent or reserved; \
         retry the job in the next month, or have the operator raise store.limits.usd_per_month"
    )]
    OverMonth { asked: MicroUsd, committed: MicroUsd, limit: MicroUsd },
    #[error(
        "an earlier try of this question may have been answered and billed, and its answer was lost; read the \
         vendor's records, then retry the job, or set providers.on_unknown = resend"
    )]
    OutcomeUnknown,
    #[error("{0}")]
    LeaseLost(String),
    #[error("{0}")]
    Unavailable(String),
}

/// The ledger of one job.
pub trait Ledger: Send + Sync {
    /// Records a call and reserves its cost, or refuses. It is committed before the call is sent.
    fn reserve(&self, intent: Intent) -> BoxFuture<'_, Result<Entry, LedgerError>>;

    /// Records the outcome of a call.
    fn settle(&self, entry: Entry, settlement: Settlement) -> BoxFuture<'_, Result<(), LedgerError>>;

    /// The kept answer to a question of a worker that died. A question that one run of a stage asks twice has two
    /// answers, in order.
    fn answer(&self, request_digest: String) -> BoxFuture<'_, Result<Option<Bytes>, LedgerError>>;

    /// The vendor's job of an earlier question, by this worker or one that died.
    fn task(&self, request_digest: String) -> BoxFuture<'_, Result<Option<Task>, LedgerError>>;

    /// Keeps the file of a vendor's job, since vendors delete it soon.
    fn fetched(&self, entry_id: i64, file: Bytes) -> BoxFuture<'_, Result<(), LedgerError>>;

    /// Records that a vendor's job ended without a file; the next equal question starts a new one.
    fn over(&self, entry_id: i64) -> BoxFuture<'_, Result<(), LedgerError>>;

    /// Whether cancellation of the job was requested; then no worker collects the jobs of vendors.
    fn is_cancelled(&self) -> BoxFuture<'_, bool>;
}

/// The ledger of calls outside any job, such as those of a command: it grants them up to a budget, and forgets them
/// with the process.
#[derive(Debug)]
pub struct Purse {
    budget: MicroUsd,
    committed: Mutex<MicroUsd>,
}

impl Purse {
    pub fn new(budget: MicroUsd) -> Self {
        Self { budget, committed: Mutex::new(MicroUsd::ZERO) }
    }
}

impl Ledger for Purse {
    fn reserve(&self, intent: Intent) -> BoxFuture<'_, Result<Entry, LedgerError>> {
        Box::pin(async move {
            let mut committed = self.committed.lock().unwrap_or_else(PoisonError::into_inner);
            let (asked, budget) = (intent.reserved, self.budget);
            let after = MicroUsd(committed.0.saturating_add(asked.0));
            // Free calls are always granted.
            if asked > MicroUsd::ZERO && after > budget {
                return Err(LedgerError::OverBudget { asked, committed: *committed, budget });
            }
            *committed = after;
            let request_digest = intent.request_digest;
            Ok(Entry { id: 0, idempotency_key: request_digest.clone(), request_digest })
        })
    }

    fn settle(&self, _entry: Entry, _settlement: Settlement) -> BoxFuture<'_, Result<(), LedgerError>> {
        Box::pin(async { Ok(()) })
    }

    fn answer(&self, _request_digest: String) -> BoxFuture<'_, Result<Option<Bytes>, LedgerError>> {
        Box::pin(async { Ok(None) })
    }

    fn task(&self, _request_digest: String) -> BoxFuture<'_, Result<Option<Task>, LedgerError>> {
        Box::pin(async { Ok(None) })
    }

    fn fetched(&self, _entry_id: i64, _file: Bytes) -> BoxFuture<'_, Result<(), LedgerError>> {
        Box::pin(async { Ok(()) })
    }

    fn over(&self, _entry_id: i64) -> BoxFuture<'_, Result<(), LedgerError>> {
        Box::pin(async { Ok(()) })
    }

    fn is_cancelled(&self) -> BoxFuture<'_, bool> {
        Box::pin(async { false })
    }
}
