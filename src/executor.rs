//! Executing tasks: the work of the jobs `execute_task`. A simulated robot does a task in a finished scene; the answer,
//! done or failed, becomes a blob. The same scene, task, robot and seed give the same bytes again.

use std::sync::Arc;

use bytes::Bytes;
use futures::future::BoxFuture;
use serde_json::Value;

use crate::pipeline::error::StageError;
use crate::problem::{Problem, ProblemType};
use crate::worker::{Settings, Work, WorkAttempt};
use runtime::{ComputationFailed, CpuPool};
use store::Store;
use store::executions::{ExecutionAnswer, ExecutionRow};
use store::lifecycle::JobKind;
use store::queue::{AttemptOutcome, ClaimedWork};

/// The answer of an execution as bytes.
pub struct Answer {
    pub bytes: Bytes,
    pub media_type: &'static str,
}

/// The execution of a stored order in the scene of an archive. It computes for seconds, so it blocks. `service::worker`
/// passes `App::execute_stored` of `app::executions`.
pub type Execute = Arc<dyn Fn(&[u8], &Value) -> Result<Answer, Problem> + Send + Sync>;

/// Executes tasks.
pub struct Executor {
    store: Store,
    cpu: CpuPool,
    execute: Execute,
}

impl Executor {
    /// An executor that computes on `cpu`.
    pub fn new(store: Store, cpu: CpuPool, execute: Execute) -> Self {
        Self { store, cpu, execute }
    }

    async fn answer(&self, execution: ExecutionRow) -> Result<ExecutionAnswer, StageError> {
        let Some(archive) = self.store.blobs().get(&execution.bundle).await? else {
            let message = "the bundle of the scene is lost or damaged; download it once, which makes it again, and execute \
                           the task then";
            return Err(StageError::permanent("bundle_lost", message));
        };
        let execute = self.execute.clone();
        let executing = self.cpu.run(move || execute(&archive, &execution.request));
        let Answer { bytes, media_type } = executing.await.map_err(died)?.map_err(refused)?;
        let size = bytes.len() as u64;
        let digest = self.store.blobs().put(bytes).await?;
        Ok(ExecutionAnswer { digest, media_type: media_type.to_owned(), size })
    }
}

impl Work for Executor {
    fn kinds(&self) -> &'static [JobKind] {
        &[JobKind::ExecuteTask]
    }

    /// One for each thread that computes: an execution keeps one busy.
    fn slots(&self, settings: &Settings) -> usize {
        settings.threads()
    }

    fn run(self: Arc<Self>, attempt: WorkAttempt) -> BoxFuture<'static, Result<AttemptOutcome, StageError>> {
        Box::pin(async move {
            let ClaimedWork::ExecuteTask(execution) = &attempt.claim.work else {
                return Err(StageError::crashed("a job of another kind came to the executor; report this"));
            };
            tokio::select! {
                answer = self.answer((**execution).clone()) => Ok(AttemptOutcome::Executed(answer?)),
                () = attempt.stopped() => Err(StageError::cancelled()),
            }
        })
    }
}

fn died(died: ComputationFailed) -> StageError {
    let message = "a bug stopped this execution; the server's log has the details";
    StageError { code: "internal_error", ..StageError::crashed(message).because(died) }
}

fn refused(problem: Problem) -> StageError {
    match problem.kind {
        // Another request can be accepted for the same scene.
        ProblemType::InvalidRequest => StageError::refused(problem.own_code(), problem.message()),
        _ => StageError::permanent(problem.own_code(), problem.message()),
    }
}
