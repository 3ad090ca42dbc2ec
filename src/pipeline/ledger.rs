//! The ledger of one job, as the calls of its stages see it: rows of the store, under the job's lease. Calls about a
//! finished scene outside any job are rows of its last job.

use std::collections::BTreeMap;
use std::sync::{Mutex, PoisonError};

use bytes::Bytes;
use futures::future::BoxFuture;

use ports::ledger::{Entry, Intent, Ledger, LedgerError, OnUnknown, Settlement, Task};
use scene::{InstanceId, JobId, MicroUsd, SceneId, TenantId};
use store::calls::{CallEnd, NewCall, Reservation};
use store::tasks::TaskEnd;
use store::{Digest, Lease, Store, StoreError};

/// The maker of a call.
pub enum Caller {
    /// A stage of the job.
    Job(Lease),
    /// A request about a finished scene, whose last job this is.
    Scene { tenant_id: TenantId, scene_id: SceneId, job_id: JobId },
}

impl Caller {
    fn job_id(&self) -> &JobId {
        match self {
            Self::Job(lease) => &lease.job_id,
            Self::Scene { job_id, .. } => job_id,
        }
    }
}

/// Age at which a call of a request that was never settled counts as of unknown outcome: longer than any call takes.
const GIVEN_UP_AFTER_MS: i64 = 3_600_000;

/// Ledger of one run of one stage, or of one request.
pub struct JobLedger {
    pub store: Store,
    pub caller: Caller,
    pub stage: &'static str,
    pub instance: Option<InstanceId>,
    /// Number of answers of this run, by the digest of their question.
    had: Mutex<BTreeMap<String, u32>>,
}

impl JobLedger {
    pub fn new(store: Store, lease: Lease, stage: &'static str, instance: Option<InstanceId>) -> Self {
        Self { store, caller: Caller::Job(lease), stage, instance, had: Mutex::default() }
    }

    /// The ledger of a request about a finished scene, whose last job this is.
    pub fn about(
        store: Store,
        tenant_id: TenantId,
        scene_id: SceneId,
        job_id: JobId,
        stage: &'static str,
    ) -> Self {
        let caller = Caller::Scene { tenant_id, scene_id, job_id };
        Self { store, caller, stage, instance: None, had: Mutex::default() }
    }

    /// The lease under which jobs of vendors are followed; requests start none.
    fn lease(&self) -> Result<&Lease, LedgerError> {
        match &self.caller {
            Caller::Job(lease) => Ok(lease),
            Caller::Scene { .. } => Err(LedgerError::Unavailable(
                "a request about a scene cannot wait for jobs of vendors".to_owned(),
            )),
        }
    }

    /// Adds `more` to the number of answers to a question in this run, and returns the sum.
    fn had(&self, request_digest: &str, more: u32) -> u32 {
        let mut had = self.had.lock().unwrap_or_else(PoisonError::into_inner);
        let count = had.entry(request_digest.to_owned()).or_default();
        *count += more;
        *count
    }

    /// Key that is the same for every try of the same question here, however often the worker dies in between; another
    /// job (a retry that a client requested) has another one.
    fn key_of(&self, request_digest: &str) -> String {
        let instance = self.instance.as_ref().map_or("", InstanceId::as_str);
        let key = format!("{}\n{}\n{instance}\n{request_digest}", self.caller.job_id(), self.stage);
        Digest::of(key.as_bytes()).as_str()[..32].to_owned()
    }
}

impl Ledger for JobLedger {
    fn reserve(&self, intent: Intent) -> BoxFuture<'_, Result<Entry, LedgerError>> {
        Box::pin(async move {
            let request_digest = intent.request_digest;
            let idempotency_key = self.key_of(&request_digest);
            let call = NewCall {
                stage: self.stage.to_owned(),
                instance: self.instance.as_ref().map_or("", InstanceId::as_str).to_owned(),
                port: intent.port.to_string(),
                provider: intent.provider,
                model: intent.model,
                endpoint: intent.endpoint,
                operation: intent.operation.to_owned(),
                request_digest: request_digest.clone(),
                idempotency_key: idempotency_key.clone(),
                attempt: intent.attempt,
                reserved_micro_usd: intent.reserved.0,
                sent_bytes: intent.sent_bytes,
                refuse_after_unknown: intent.on_unknown == OnUnknown::Fail,
            };
            let reserved = match &self.caller {
                Caller::Job(lease) => self.store.reserve_call(lease, call).await.map_err(not_written)?,
                Caller::Scene { tenant_id, scene_id, .. } => {
                    let reserved =
                        self.store.reserve_call_about(tenant_id, scene_id, call, GIVEN_UP_AFTER_MS);
                    let gone = || LedgerError::Unavailable("the scene was deleted meanwhile".to_owned());
                    reserved.await.map_err(not_written)?.ok_or_else(gone)?
                }
            };
            match reserved {
                Reservation::Granted(id) => Ok(Entry { id, idempotency_key, request_digest }),
                Reservation::OverBudget { committed, budget } => Err(LedgerError::OverBudget {
                    asked: intent.reserved,
                    committed: MicroUsd(committed),
                    budget: MicroUsd(budget),
                }),
                Reservation::OverMonth { committed, limit } => Err(LedgerError::OverMonth {
                    asked: intent.reserved,
                    committed: MicroUsd(committed),
                    limit: MicroUsd(limit),
                }),
                Reservation::OutcomeUnknown => Err(LedgerError::OutcomeUnknown),
            }
        })
    }

    fn settle(&self, entry: Entry, settlement: Settlement) -> BoxFuture<'_, Result<(), LedgerError>> {
        Box::pin(async move {
            let kept = settlement.answer.is_some();
            // The blob first: a row never names what is not there.
            let answer = match settlement.answer {
                Some(answer) => Some(self.store.blobs().put(answer).await.map_err(not_written)?),
                None => None,
            };
            let end = CallEnd {
                settled_micro_usd: settlement.cost.map(|cost| cost.0),
                outcome: settlement.outcome.to_owned(),
                received_bytes: settlement.received_bytes,
                input_tokens: settlement.input_tokens,
                output_tokens: settlement.output_tokens,
                task: settlement.task,
                answer,
            };
            match &self.caller {
                Caller::Job(lease) => self.store.settle_call(lease, entry.id, end).await,
                Caller::Scene { job_id, .. } => self.store.settle_call_about(job_id, entry.id, end).await,
            }
            .map_err(not_written)?;
            if kept {
                self.had(&entry.request_digest, 1);
            }
            Ok(())
        })
    }

    fn answer(&self, request_digest: String) -> BoxFuture<'_, Result<Option<Bytes>, LedgerError>> {
        Box::pin(async move {
            let key = self.key_of(&request_digest);
            let had = match &self.caller {
                Caller::Job(_) => self.had(&request_digest, 0),
                // The same instruction about the same scene has the same answer, and is paid once.
                Caller::Scene { .. } => 0,
            };
            let digest = self.store.answer_of(self.caller.job_id(), &key, had).await.map_err(not_written)?;
            let Some(digest) = digest else { return Ok(None) };
            let answer = self.store.blobs().get(&digest).await.map_err(not_written)?;
            self.had(&request_digest, u32::from(answer.is_some()));
            Ok(answer)
        })
    }

    fn task(&self, request_digest: String) -> BoxFuture<'_, Result<Option<Task>, LedgerError>> {
        Box::pin(async move {
            let key = self.key_of(&request_digest);
            let Some(row) = self.store.task_of(self.caller.job_id(), &key).await.map_err(not_written)? else {
                return Ok(None);
            };
            let file = match &row.file {
                // A file that is gone is fetched again.
                Some(digest) => self.store.blobs().get(digest).await.map_err(not_written)?,
                None => None,
            };
            Ok(Some(Task { entry_id: row.call_id, id: row.task, file }))
        })
    }

    fn fetched(&self, entry_id: i64, file: Bytes) -> BoxFuture<'_, Result<(), LedgerError>> {
        Box::pin(async move {
            let digest = self.store.blobs().put(file).await.map_err(not_written)?;
            let lease = self.lease()?;
            self.store.note_task(lease, entry_id, TaskEnd::Fetched(digest)).await.map_err(not_written)
        })
    }

    fn over(&self, entry_id: i64) -> BoxFuture<'_, Result<(), LedgerError>> {
        Box::pin(async move {
            self.store.note_task(self.lease()?, entry_id, TaskEnd::Over).await.map_err(not_written)
        })
    }

    fn is_cancelled(&self) -> BoxFuture<'_, bool> {
        Box::pin(async move {
            match &self.caller {
                Caller::Job(lease) => self.store.is_cancelled(&lease.job_id).await.unwrap_or(false),
                Caller::Scene { .. } => false,
            }
        })
    }
}

fn not_written(error: StoreError) -> LedgerError {
    match error {
        StoreError::LeaseLost { .. } => LedgerError::LeaseLost(error.to_string()),
        _ => LedgerError::Unavailable(error.chain()),
    }
}
