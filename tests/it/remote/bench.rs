//! Parts shared by tests of remote adapters: books that remember everything, impatient endpoints, names of errors.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use bytes::Bytes;
use futures::future::BoxFuture;
use http_client::circuit_breaker::CircuitBreaker;
use http_client::rate_limit::RateLimiter;
use http_client::{AddressPolicy, HttpClient, Secret};
use ports::ledger::{Entry, Intent, Ledger, LedgerError, MicroUsd, OnUnknown, Settlement, Task};
use ports::{Call, Port, ProviderError};
use remote::endpoint::Auth;
use remote::settings::EndpointSettings;
use remote::{Endpoint, LimitSettings};
use runtime::CancelFlag;
use runtime::CpuPool;

/// Books that remember everything, with a budget.
pub struct Book {
    pub rows: Mutex<Vec<(Intent, Option<Settlement>)>>,
    /// Results of vendors' jobs, by row; `None` = nothing more will come.
    pub files: Mutex<BTreeMap<i64, Option<Bytes>>>,
    pub cancelled: AtomicBool,
    pub budget: MicroUsd,
}

impl Book {
    pub fn with_budget(micro_usd: i64) -> Arc<Self> {
        Arc::new(Self {
            rows: Mutex::default(),
            files: Mutex::default(),
            cancelled: AtomicBool::new(false),
            budget: MicroUsd(micro_usd),
        })
    }

    /// A call whose books these are.
    pub fn call(self: &Arc<Self>) -> Call {
        let mut call = Call::without_budget(CpuPool::new(1).unwrap(), CancelFlag::default());
        call.ledger = self.clone();
        call
    }

    /// Outcomes in order; `None` for what is under way.
    pub fn outcomes(&self) -> Vec<Option<&'static str>> {
        self.rows.lock().unwrap().iter().map(|(_, end)| end.as_ref().map(|end| end.outcome)).collect()
    }

    /// Spent sum, with unknown costs at the reserved amount.
    pub fn spent(&self) -> i64 {
        let rows = self.rows.lock().unwrap();
        rows.iter()
            .map(|(intent, end)| end.as_ref().and_then(|end| end.cost).unwrap_or(intent.reserved).0)
            .sum()
    }
}

impl Ledger for Book {
    fn reserve(&self, intent: Intent) -> BoxFuture<'_, Result<Entry, LedgerError>> {
        Box::pin(async move {
            let committed = MicroUsd(self.spent());
            if committed.0 + intent.reserved.0 > self.budget.0 {
                return Err(LedgerError::OverBudget {
                    asked: intent.reserved,
                    committed,
                    budget: self.budget,
                });
            }
            let mut rows = self.rows.lock().unwrap();
            let request_digest = intent.request_digest.clone();
            let idempotency_key = request_digest.clone();
            let entry = Entry { id: rows.len() as i64 + 1, idempotency_key, request_digest };
            rows.push((intent, None));
            Ok(entry)
        })
    }

    fn settle(&self, entry: Entry, settlement: Settlement) -> BoxFuture<'_, Result<(), LedgerError>> {
        Box::pin(async move {
            let previous = self.rows.lock().unwrap()[entry.id as usize - 1].1.replace(settlement);
            assert_eq!(previous, None, "settled once");
            Ok(())
        })
    }

    fn answer(&self, _request_digest: String) -> BoxFuture<'_, Result<Option<Bytes>, LedgerError>> {
        Box::pin(async { Ok(None) })
    }

    fn task(&self, request_digest: String) -> BoxFuture<'_, Result<Option<Task>, LedgerError>> {
        Box::pin(async move {
            let (rows, files) = (self.rows.lock().unwrap(), self.files.lock().unwrap());
            let mut tasks = rows.iter().enumerate().rev().filter_map(|(index, (intent, end))| {
                let id = end.as_ref()?.task.clone().filter(|_| intent.request_digest == request_digest)?;
                let entry_id = index as i64 + 1;
                match files.get(&entry_id) {
                    None => Some(Task { entry_id, id, file: None }),
                    Some(Some(file)) => Some(Task { entry_id, id, file: Some(file.clone()) }),
                    Some(None) => None,
                }
            });
            Ok(tasks.next())
        })
    }

    fn fetched(&self, entry_id: i64, file: Bytes) -> BoxFuture<'_, Result<(), LedgerError>> {
        Box::pin(async move {
            self.files.lock().unwrap().insert(entry_id, Some(file));
            Ok(())
        })
    }

    fn over(&self, entry_id: i64) -> BoxFuture<'_, Result<(), LedgerError>> {
        Box::pin(async move {
            self.files.lock().unwrap().insert(entry_id, None);
            Ok(())
        })
    }

    fn is_cancelled(&self) -> BoxFuture<'_, bool> {
        Box::pin(async { self.cancelled.load(Ordering::Relaxed) })
    }
}

/// Patience that lets a test fail in a moment.
pub fn make_quick(limits: &mut LimitSettings) {
    limits.attempt_timeout_secs = 1;
    limits.total_timeout_secs = 20;
    limits.max_tries = 3;
    limits.pause_base_ms = 2;
    limits.pause_cap_ms = 50;
    limits.max_answer_bytes = limits.max_answer_bytes.min(2 << 20);
    limits.calls_per_minute = 1_000_000;
    limits.breaker_failures = 100;
}

/// An endpoint on this machine.
pub fn endpoint(
    port: Port,
    provider: &str,
    settings: &EndpointSettings,
    key: &str,
    on_unknown: OnUnknown,
) -> Endpoint {
    let rules = AddressPolicy::new(true, "127.0.0.1");
    let limits = &settings.limits;
    Endpoint {
        port,
        provider: provider.into(),
        model: "a-model".into(),
        base_url: settings.base_url.clone(),
        key: Secret::new(key),
        auth: Auth::Bearer,
        idempotency_header: String::new(),
        limits: limits.clone(),
        on_unknown,
        client: HttpClient::new(rules, Duration::from_secs(5)).unwrap(),
        rate_limiter: RateLimiter::new(limits.concurrency, limits.calls_per_minute),
        circuit_breaker: CircuitBreaker::new(
            limits.breaker_failures,
            Duration::from_secs(limits.breaker_rest_secs),
        ),
    }
}

/// Class and code of an error, as clients see them.
pub fn class(error: &ProviderError) -> String {
    match error {
        ProviderError::Rejected { code, .. } => format!("rejected {code}"),
        ProviderError::Transient { code, .. } => format!("transient {code}"),
        ProviderError::Refused { code, .. } => format!("refused {code}"),
        ProviderError::Misconfigured { code, .. } => format!("misconfigured {code}"),
        ProviderError::RateLimited { retry_after, .. } => {
            format!("rate_limited {}", retry_after.unwrap_or_default().as_secs())
        }
        other => panic!("{other}"),
    }
}
