//! `/scenes/{scene_id}/executions` and `/executions`: a simulated robot does a task in a finished scene.
//!
//! An execution is a job (see `executor`), and has its id; with `Prefer: wait` one request brings the answer, too. The
//! same scene, task, robot and seed give the same bytes again.

use axum::http::{HeaderMap, Method};
use axum::response::Response;
use schemars::JsonSchema;
use serde::Deserialize;

use super::accepted::accepted_at;
use super::admission::overloaded;
use super::download::{Content, Download, respond};
use super::enqueue::{Awaited, SubmissionOptions, preference_applied, wait_for};
use super::extract::{JsonBody, JsonRequest, PathId, TenantApi};
use super::idempotency::{KeyScope, scoped};
use super::instructions::read_tasks;
use super::limits::{check_bytes, refused};
use super::query::Parameters;
use super::{jobs, parent};
use crate::app::executions::order::{ExecutionDraft, ExecutionFormat};
use crate::problem::{Problem, ProblemType};
use scene::{JobId, SceneId};
use store::Digest;
use store::executions::{NewExecution, SubmitExecutionOutcome};
use store::jobs::JobRow;
use store::lifecycle::{FailureClass, JobState};

/// Parameters of the request.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ExecutionParameters {
    /// `json`: verdict, task and motion as one document. `zip`: the files that `tabletopgen execute --out` writes, with
    /// the motion as Parquet and the robot in the scene as MJCF, URDF and USD.
    format: ExecutionFormat,
}

impl JsonRequest for ExecutionDraft {
    type Schema = Self;
    const EXAMPLE: &str = r#"{"text": "put the apple in the bowl"}"#;
}

/// `POST /scenes/{scene_id}/executions`.
pub async fn submit(
    api: TenantApi,
    PathId(scene_id): PathId<SceneId>,
    Parameters(ExecutionParameters { format }): Parameters<ExecutionParameters>,
    SubmissionOptions { idempotency_key, wait, .. }: SubmissionOptions,
    JsonBody { value: draft, memory: _memory }: JsonBody<ExecutionDraft>,
) -> Result<Response, Problem> {
    let mut order = draft.checked(format, api.settings.max_text_chars)?;
    let _permit = api.requests.clone().try_acquire_owned().map_err(|_| overloaded())?;
    let bundle = parent::bundle_of(&api, &scene_id, true).await?;
    check_bytes(&api).await?;
    let robot = order.robot.clone();
    read_tasks(&api, &scene_id, &bundle, std::iter::once(&mut order.task), &robot).await?;
    let request = order.stored();
    let body_digest = Digest::of(format!("{scene_id} {request}").as_bytes());
    let new = NewExecution {
        tenant_id: api.tenant_id.clone(),
        scene_id,
        request,
        bundle: bundle.digest,
        idempotency: scoped(&api, KeyScope::Execution, idempotency_key.as_deref())
            .map(|key| (key, body_digest)),
    };
    let job_id = match api.store.submit_execution(new).await? {
        SubmitExecutionOutcome::Created(job_id) | SubmitExecutionOutcome::Replayed(job_id) => job_id,
        SubmitExecutionOutcome::KeyReused => return Err(Problem::key_reused("execution")),
        SubmitExecutionOutcome::Refused(reached) => return Err(refused(reached)),
    };
    let Some(wait) = wait else { return accepted(&api, &job_id).await };
    wait_for(&api, Awaited::Job(&job_id), wait).await?;
    let job = jobs::find(&api, &job_id).await?;
    let mut response = match job.state.is_final() {
        true => answer(&api, job, &Method::GET, &HeaderMap::new()).await?,
        false => accepted(&api, &job_id).await?,
    };
    preference_applied(&mut response, wait);
    Ok(response)
}

/// `GET /executions/{execution_id}`.
pub async fn show(
    api: TenantApi,
    PathId(job_id): PathId<JobId>,
    method: Method,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let job = api.store.job(&api.tenant_id, &job_id).await?;
    let job = job.ok_or_else(|| Problem::not_found("execution", job_id.as_str()))?;
    answer(&api, job, &method, &headers).await
}

/// The answer of an ended execution.
async fn answer(
    api: &TenantApi,
    job: JobRow,
    method: &Method,
    headers: &HeaderMap,
) -> Result<Response, Problem> {
    let execution = api.store.execution(&api.tenant_id, &job.id).await?;
    let execution = execution.ok_or_else(|| Problem::not_found("execution", job.id.as_str()))?;
    if let Some(answer) = execution.answer {
        let what = Download {
            digest: &answer.digest,
            size: answer.size,
            media_type: &answer.media_type,
            file_name: (answer.media_type == "application/zip").then(|| format!("execution-{}.zip", job.id)),
            content: Content::Stored,
        };
        return respond(api, method, headers, what).await?.ok_or_else(|| {
            let detail = "the bytes of this execution are lost or damaged; execute the task again";
            Problem::new(ProblemType::Gone, "execution_damaged", detail)
        });
    }
    Err(match job.state {
        JobState::Failed => {
            let kind = match job.failure_class.as_deref().and_then(FailureClass::parse) {
                Some(FailureClass::Refused) => ProblemType::InvalidRequest,
                Some(FailureClass::Permanent) => ProblemType::Conflict,
                _ => ProblemType::Internal,
            };
            let detail = job.failure_message.unwrap_or_default();
            Problem {
                code: job.failure_code.unwrap_or_default().into(),
                ..Problem::new(kind, "failed", detail)
            }
        }
        JobState::Cancelled => {
            let detail = "this execution was cancelled; execute the task again";
            Problem::new(ProblemType::Conflict, "execution_cancelled", detail)
        }
        _ => {
            let detail = "this execution has no answer yet; follow the events of its job until it has ended";
            Problem::new(ProblemType::Conflict, "execution_not_ready", detail)
        }
    })
}

/// 202 with the job.
async fn accepted(api: &TenantApi, job_id: &JobId) -> Result<Response, Problem> {
    let view = jobs::view(api, jobs::find(api, job_id).await?).await?;
    Ok(accepted_at(&view.links.this, &view))
}
