//! What calls cost: reserved before a call is sent, settled when it is over. Where the books are kept, ports do not
//! know; they are handed a [`Ledger`].

use bytes::Bytes;
use futures::future::BoxFuture;
use serde::{Deserialize, Serialize};

use super::Port;

pub use scene::MicroUsd;

/// A call that is about to be sent.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Intent {
    pub port: Port,
    /// Adapter, as in its [`Adapter`](super::Adapter) (`openai/chat`).
    pub provider: String,
    pub model: String,
    /// Where it goes, without secrets and queries.
    pub endpoint: String,
    /// `describe`, `recognize`.
    pub operation: &'static str,
    /// Digest of everything that is sent but the secrets: the same question has the same.
    pub request_digest: String,
    /// 1 for the first try of this question.
    pub attempt: u32,
    /// The most that it can cost.
    pub reserved: MicroUsd,
    /// Body of the request.
    pub sent_bytes: u64,
    /// What to do where an earlier try of the same question may have been answered, and the answer lost.
    pub on_unknown: OnUnknown,
}

/// What to do about a call whose answer was lost, so that nobody knows whether it was made and billed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum OnUnknown {
    /// The job fails, and a person decides.
    Fail,
    /// It is sent again, and may be billed twice; both count toward the budget.
    Resend,
}

/// A reservation that was granted.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Entry {
    /// Of the ledger's row.
    pub id: i64,
    /// The same for every try of the same question in one stage of one job: vendors that know idempotency keys answer
    /// it once.
    pub idempotency_key: String,
    /// Of the question.
    pub request_digest: String,
}

/// How a call ended.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Settlement {
    /// `None` = unknown; then what was reserved counts.
    pub cost: Option<MicroUsd>,
    pub received_bytes: u64,
    pub input_tokens: Option<u64>,
    pub output_tokens: Option<u64>,
    /// `answered`, `outcome_unknown`, or the code of a failure.
    pub outcome: &'static str,
    /// The vendor's id of the job it has begun, where the answer comes later.
    pub task: Option<String>,
    /// The answer, if it is one; kept in case that its stage dies before it is done.
    pub answer: Option<Bytes>,
}

/// A vendor's job that was submitted for this question, and is not over.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Task {
    /// Of the call that submitted it.
    pub entry_id: i64,
    /// The vendor's id.
    pub id: String,
    /// What came of it, if it was fetched.
    pub file: Option<Bytes>,
}

/// The outcome of a call that was answered as it should be.
pub const ANSWERED: &str = "answered";

/// The outcome of a call of which nobody knows whether the vendor answered and billed it.
pub const OUTCOME_UNKNOWN: &str = "outcome_unknown";

/// Why a call may not be made, or could not be written down.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum LedgerError {
    #[error(
        "it may cost {asked}, and {committed} of the scene's budget of {budget} are spent or reserved; submit the \
         scene with a larger options.budget_usd"
    )]
    OverBudget { asked: MicroUsd, committed: MicroUsd, budget: MicroUsd },
    #[error(
        "an earlier try of this question may have been answered and billed, and its answer was lost; look at the \
         vendor's records, then retry the job, or set providers.on_unknown = resend"
    )]
    OutcomeUnknown,
    #[error("{0}")]
    LeaseLost(String),
    #[error("{0}")]
    Unavailable(String),
}

/// The books of one job.
pub trait Ledger: Send + Sync {
    /// Writes the call down and sets its cost aside, or refuses; nothing is sent before this is committed.
    fn reserve(&self, intent: Intent) -> BoxFuture<'_, Result<Entry, LedgerError>>;

    /// Writes down how the call ended.
    fn settle(&self, entry: Entry, settlement: Settlement) -> BoxFuture<'_, Result<(), LedgerError>>;

    /// An answer that was kept, to a question that was asked before by a worker that died. A question that one run of a
    /// stage asks twice has two answers, in the order in which they came.
    fn answer(&self, request_digest: String) -> BoxFuture<'_, Result<Option<Bytes>, LedgerError>>;

    /// The vendor's job for a question that was asked before, by this worker or one that died.
    fn task(&self, request_digest: String) -> BoxFuture<'_, Result<Option<Task>, LedgerError>>;

    /// Keeps what came of a vendor's job: vendors delete it soon.
    fn fetched(&self, entry_id: i64, file: Bytes) -> BoxFuture<'_, Result<(), LedgerError>>;

    /// Writes down that nothing more comes of a vendor's job; the next question like it is a new one.
    fn over(&self, entry_id: i64) -> BoxFuture<'_, Result<(), LedgerError>>;

    /// Whether somebody has asked for the job to be cancelled: then nobody will come for what vendors work on.
    fn is_cancelled(&self) -> BoxFuture<'_, bool>;
}

/// Books for calls outside any job, as benchmarks make them: what costs nothing is granted, all else refused.
#[derive(Clone, Copy, Debug)]
pub struct NoBudget;

impl Ledger for NoBudget {
    fn reserve(&self, intent: Intent) -> BoxFuture<'_, Result<Entry, LedgerError>> {
        Box::pin(async move {
            if intent.reserved > MicroUsd::ZERO {
                let (committed, budget) = (MicroUsd::ZERO, MicroUsd::ZERO);
                return Err(LedgerError::OverBudget { asked: intent.reserved, committed, budget });
            }
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
