//! Instructions about a finished scene: who reads them, and refusals for clients.

use std::sync::Arc;

use super::App;
use super::executions::bundle_of;
use crate::pipeline::error::{StageError, StageErrorClass};
use crate::pipeline::ledger::JobLedger;
use crate::pipeline::task_scene::of_archive;
use crate::problem::{FieldError, Problem, ProblemType};
use editing::EditableObject;
use ports::ledger::Purse;
use ports::{Call, Instruction, InstructionReader, ProviderError};
use runtime::{CancelFlag, CpuPool};
use scene::request::RequestOptions;
use scene::{EditProgram, JobId, SceneId, TenantId};
use store::Store;
use tasks::{Refusal, Task, TaskScene};

/// The stage in whose name instructions are booked.
const STAGE: &str = "instruction";

/// The reader of instructions of a process.
#[derive(Clone)]
pub struct Reader {
    pub reader: Arc<dyn InstructionReader>,
    /// Whether a remote model reads, which takes seconds and may cost.
    pub is_remote: bool,
}

impl std::fmt::Debug for Reader {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Reader").field("is_remote", &self.is_remote).finish_non_exhaustive()
    }
}

/// A request to read instructions: who computes, and where calls of remote models are booked.
pub struct Reading {
    call: Call,
    /// The job in which calls are booked and answers are kept.
    kept_in: Option<(Store, JobId)>,
}

impl Reading {
    /// For a command: calls may cost together what a scene usually may.
    pub fn of_command(cpu: CpuPool, usual_budget_usd: f64) -> Self {
        let ledger = Purse::new(RequestOptions::default().budget(usual_budget_usd));
        let call = Call::without_budget(cpu, CancelFlag::default());
        Self { call: Call { ledger: Arc::new(ledger), ..call }, kept_in: None }
    }

    /// About a finished scene of a tenant, under whose budget calls are booked.
    ///
    /// # Errors
    ///
    /// A [`Problem`] where the tenant has no such scene.
    pub async fn about(
        app: &App,
        store: &Store,
        cpu: CpuPool,
        tenant_id: &TenantId,
        scene_id: &SceneId,
    ) -> Result<Self, Problem> {
        let call = Call::without_budget(cpu, CancelFlag::default());
        if !app.asks_models() {
            return Ok(Self { call, kept_in: None });
        }
        let job = store.latest_job(tenant_id, scene_id).await?;
        let job = job.ok_or_else(|| Problem::not_found("scene", scene_id.as_str()))?;
        let kept_in = Some((store.clone(), job.id.clone()));
        let ledger = JobLedger::about(store.clone(), tenant_id.clone(), scene_id.clone(), job.id, STAGE);
        Ok(Self { call: Call { ledger: Arc::new(ledger), ..call }, kept_in })
    }

    /// Forgets kept answers that cannot be used, so that the next request asks the model again.
    async fn without_unusable<T>(&self, read: Result<T, ProviderError>) -> Result<T, ProviderError> {
        if let (Err(error), Some((store, job_id))) = (&read, &self.kept_in)
            && error.discards_recorded_answers()
            && let Err(error) = store.forget_answers_about(job_id, STAGE).await
        {
            tracing::warn!(error = error.chain(), "unusable answers could not be forgotten");
        }
        read
    }
}

/// A finished scene in which an instruction names objects.
pub struct InstructedScene(TaskScene);

impl InstructedScene {
    /// The scene in an archive. It computes, so it blocks.
    ///
    /// # Errors
    ///
    /// A [`Problem`] for an archive that cannot be read.
    pub fn of_archive(archive: &[u8]) -> Result<Self, Problem> {
        Ok(Self(bundle_of(archive)?.tasks))
    }
}

/// The objects of the scene in an archive; none where the archive cannot be read, which fails the job with the reason.
/// It computes, so it blocks.
pub fn objects_of(archive: &[u8]) -> Arc<[EditableObject]> {
    match of_archive(archive) {
        Ok(scene) => scene.tasks.described().into(),
        Err(_) => Arc::new([]),
    }
}

impl App {
    /// Whether a remote model reads instructions.
    pub fn asks_models(&self) -> bool {
        self.reader.is_remote
    }

    /// The program of an edit in words.
    ///
    /// # Errors
    ///
    /// A [`Problem`] with the words that are not understood, or of the model that does not answer.
    pub async fn read_edit(
        &self,
        text: String,
        objects: Arc<[EditableObject]>,
        reading: &Reading,
    ) -> Result<EditProgram, Problem> {
        let read = self.reader.reader.read_edit(&reading.call, Instruction { text, objects }).await;
        reading.without_unusable(read).await.map_err(|error| match error {
            ProviderError::Rejected { reason, .. } => {
                Problem::invalid(vec![FieldError::new("/text", reason)])
            }
            other => not_read(other),
        })
    }

    /// The task of an instruction.
    ///
    /// # Errors
    ///
    /// A [`Problem`] with the words that are not understood, for phrases that do not say which objects they mean, or of
    /// the model that does not answer.
    pub async fn read_task(
        &self,
        text: &str,
        InstructedScene(scene): &InstructedScene,
        robot: &str,
        reading: &Reading,
    ) -> Result<Task, Problem> {
        let instruction = Instruction { text: text.to_owned(), objects: scene.described().into() };
        let read = self.reader.reader.read_task(&reading.call, instruction).await;
        let program = reading.without_unusable(read).await.map_err(not_read)?;
        tasks::text::task_of_program(text, &program, scene, robot).map_err(|refusal| refused(&refusal))
    }
}

/// A refused task, for clients.
pub(super) fn refused(refusal: &Refusal) -> Problem {
    Problem::new(ProblemType::InvalidRequest, refusal.code(), refusal.to_string())
}

/// Failure to read an instruction, for clients.
fn not_read(error: ProviderError) -> Problem {
    let error = StageError::from(error);
    let kind = match error.class {
        StageErrorClass::Permanent | StageErrorClass::Refused => ProblemType::InvalidRequest,
        StageErrorClass::OverBudget => ProblemType::Conflict,
        StageErrorClass::Transient | StageErrorClass::RateLimited { .. } | StageErrorClass::LeaseLost => {
            ProblemType::Unavailable
        }
        StageErrorClass::Crashed | StageErrorClass::Cancelled => ProblemType::Internal,
    };
    if kind != ProblemType::InvalidRequest {
        tracing::warn!(error = error.chain(), "an instruction could not be read");
    }
    Problem::new(kind, error.code, error.message)
}
