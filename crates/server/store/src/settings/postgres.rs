//! Section `[store.postgres]` of the settings: limits of everything that is asked of PostgreSQL.

use std::time::Duration;

use serde::{Deserialize, Serialize};

/// Section `[store.postgres]`. No statement, lock, transaction or connection is without a limit.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq, Eq)]
#[serde(deny_unknown_fields)]
pub struct PostgresSettings {
    /// Longest wait for a connection, a free one of this process or a new one, milliseconds (100..=60,000).
    pub acquire_timeout_ms: u64,
    /// Longest time of one statement, milliseconds (100..=600,000); `statement_timeout` of the session.
    pub statement_timeout_ms: u64,
    /// Longest wait of a statement for a lock, milliseconds (100..=600,000); `lock_timeout` of the session.
    pub lock_timeout_ms: u64,
    /// Longest silence of this process inside a transaction, milliseconds (100..=600,000);
    /// `idle_in_transaction_session_timeout`. Less than the lease of a job.
    pub idle_transaction_timeout_ms: u64,
    /// Longest wait of this process for the answer to a read or to a transaction, milliseconds (100..=600,000). It ends
    /// what the server cannot end itself, as it is frozen or cut off; the connection is closed then.
    pub answer_timeout_ms: u64,
    /// The same for statements and transactions that take long: migrations, sweeps, sums, batches, seconds
    /// (1..=86,400).
    pub long_timeout_secs: u64,
    /// The server closes a connection whose other end does not acknowledge for this long, seconds (1..=7,200);
    /// `tcp_user_timeout` and the keepalives of the session.
    pub tcp_timeout_secs: u64,
}

/// The limits of one read or transaction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Limits {
    /// Longest wait of this process for the answer.
    pub(crate) answer: Duration,
    /// The server's limit of each statement, where it differs from that of the session. Locks are never waited for
    /// longer than the session says.
    pub(crate) statement: Option<Duration>,
}

impl PostgresSettings {
    pub(crate) fn acquire_timeout(&self) -> Duration {
        Duration::from_millis(self.acquire_timeout_ms)
    }

    pub(crate) fn long_timeout(&self) -> Duration {
        Duration::from_secs(self.long_timeout_secs)
    }

    /// Limits of what a request or a heartbeat waits for.
    pub(crate) fn prompt(&self) -> Limits {
        Limits { answer: Duration::from_millis(self.answer_timeout_ms), statement: None }
    }

    /// Limits of work that takes long.
    pub(crate) fn unhurried(&self) -> Limits {
        let long = self.long_timeout();
        Limits { answer: long + self.prompt().answer, statement: Some(long) }
    }

    /// The statements that give a session its limits.
    #[cfg(feature = "postgres")]
    pub(crate) fn session(&self) -> String {
        let Self { statement_timeout_ms, lock_timeout_ms, idle_transaction_timeout_ms, .. } = self;
        // A third of the time for the first question, the rest for four that repeat it.
        let (all_ms, idle_secs) =
            (self.tcp_timeout_secs.saturating_mul(1000), (self.tcp_timeout_secs / 3).max(1));
        let interval_secs = (self.tcp_timeout_secs.saturating_sub(idle_secs) / 4).max(1);
        format!(
            "SET statement_timeout = {statement_timeout_ms}; SET lock_timeout = {lock_timeout_ms}; \
             SET idle_in_transaction_session_timeout = {idle_transaction_timeout_ms}; \
             SET tcp_user_timeout = {all_ms}; SET tcp_keepalives_idle = {idle_secs}; \
             SET tcp_keepalives_interval = {interval_secs}; SET tcp_keepalives_count = 4"
        )
    }
}

impl Limits {
    /// The statement that gives a transaction its own limit; `None` where that of the session serves.
    pub(crate) fn transaction(&self) -> Option<String> {
        let milliseconds = self.statement?.as_millis();
        Some(format!("SET LOCAL statement_timeout = {milliseconds}"))
    }
}
