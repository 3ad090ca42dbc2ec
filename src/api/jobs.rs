//! `/jobs`: list, show, stages, cancel, retry.

use axum::Json;
use axum::http::StatusCode;
use axum::response::{IntoResponse, Response};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::accepted::accepted_at;
use super::extract::{JsonRequest, OptionalJsonBody, PathId, TenantApi};
use super::limits::{check_bytes, refused};
use super::query::{IdFilter, Page, PageSize, PageToken, Parameters, Time};
use super::views::{JobView, StageView};
use crate::problem::{Problem, ProblemType};
use crate::schemas::words;
use crate::spans;
use scene::JobId;
use store::jobs::{JobFilter, JobRow, RetryOutcome};
use store::lifecycle::{JobKind, JobState};
use store::queue::CancelOutcome;

/// Parameters of `GET /jobs`.
#[derive(Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ListParameters {
    #[schemars(with = "Option<words::JobState>")]
    state: Option<JobState>,
    #[schemars(with = "Option<words::JobKind>")]
    kind: Option<JobKind>,
    /// Only jobs of this scene.
    scene: Option<IdFilter>,
    /// Only jobs of this dataset.
    dataset: Option<IdFilter>,
    /// Only jobs of this recording. They are removed when it ends.
    recording: Option<IdFilter>,
    /// Only jobs of this batch.
    batch: Option<IdFilter>,
    created_after: Option<Time>,
    page_size: PageSize,
    page_token: Option<PageToken>,
}

/// A page of jobs.
#[derive(Serialize, JsonSchema)]
pub(super) struct JobPage {
    jobs: Vec<JobView>,
    /// Null on the last page.
    next_page_token: Option<String>,
}

/// `GET /jobs`.
pub async fn list(
    api: TenantApi,
    Parameters(parameters): Parameters<ListParameters>,
) -> Result<Response, Problem> {
    let size = parameters.page_size;
    let filter = JobFilter {
        state: parameters.state,
        kind: parameters.kind,
        scene: parameters.scene.and_then(IdFilter::id),
        dataset: parameters.dataset.and_then(IdFilter::id),
        recording: parameters.recording.and_then(IdFilter::id),
        batch: parameters.batch.and_then(IdFilter::id),
        created_after_ms: parameters.created_after.map(Time::as_ms),
        before_id: parameters.page_token.and_then(PageToken::last_id),
        limit: size.rows_to_read(),
    };
    let rows = api.store.jobs(&api.tenant_id, filter).await?;
    let Page { rows, next_page_token } = size.page_of(rows, |job| PageToken::after(job.id.as_str()));
    let jobs = views(&api, rows.into_iter().map(Some).collect()).await?;
    let page = JobPage { jobs: jobs.into_iter().flatten().collect(), next_page_token };
    Ok(Json(page).into_response())
}

/// `GET /jobs/{job_id}`.
pub async fn show(api: TenantApi, PathId(job_id): PathId<JobId>) -> Result<Response, Problem> {
    let job = find(&api, &job_id).await?;
    Ok(Json(view(&api, job).await?).into_response())
}

/// The stages of a job.
#[derive(Serialize, JsonSchema)]
pub(super) struct StageList {
    stages: Vec<StageView>,
}

/// `GET /jobs/{job_id}/stages`.
pub async fn stages(api: TenantApi, PathId(job_id): PathId<JobId>) -> Result<Response, Problem> {
    find(&api, &job_id).await?;
    let rows = api.store.stages(&api.tenant_id, &job_id).await?;
    Ok(Json(StageList { stages: rows.into_iter().map(StageView::new).collect() }).into_response())
}

/// `POST /jobs/{job_id}/cancel`.
pub async fn cancel(api: TenantApi, PathId(job_id): PathId<JobId>) -> Result<Response, Problem> {
    match api.store.cancel(&api.tenant_id, &job_id).await? {
        CancelOutcome::Accepted(_) => {
            let job = find(&api, &job_id).await?;
            Ok((StatusCode::ACCEPTED, Json(view(&api, job).await?)).into_response())
        }
        CancelOutcome::TooLate(state) => Err(Problem::new(
            ProblemType::Conflict,
            "job_already_ended",
            format!("this job has {state} already; there is nothing to cancel"),
        )),
        CancelOutcome::NotFound => Err(Problem::not_found("job", job_id.as_str())),
    }
}

/// Options of a repeated job.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
#[schemars(rename = "Retry")]
pub struct RetryBody {
    /// Repeat this stage of the job and everything after it all the same.
    #[schemars(length(max = 100))]
    from_stage: Option<String>,
}

impl JsonRequest for RetryBody {
    type Schema = Self;
    const EXAMPLE: &str = r#"{"from_stage": "reference"}"#;
}

/// `POST /jobs/{job_id}/retry`.
pub async fn retry(
    api: TenantApi,
    PathId(job_id): PathId<JobId>,
    OptionalJsonBody(body): OptionalJsonBody<RetryBody>,
) -> Result<Response, Problem> {
    check_bytes(&api).await?;
    let conflict = |code, detail| Err(Problem::new(ProblemType::Conflict, code, detail));
    match api.store.retry(&api.tenant_id, &job_id, body.from_stage).await? {
        RetryOutcome::Created { job_id } => {
            let job = find(&api, &job_id).await?;
            spans::submitted(job.scene_id.as_ref(), &job_id);
            let view = view(&api, job).await?;
            Ok(accepted_at(&view.links.this, &view))
        }
        RetryOutcome::NotFound => Err(Problem::not_found("job", job_id.as_str())),
        RetryOutcome::StillActive => conflict(
            "job_still_active",
            "a job of this scene or dataset has not ended; cancel it first, or wait for it".to_owned(),
        ),
        RetryOutcome::NothingToRepeat => conflict(
            "nothing_to_retry",
            "the dataset is frozen or has a newer job, or a recording repeats its own jobs; submit it again"
                .to_owned(),
        ),
        RetryOutcome::SceneIs(state) => conflict(
            "scene_not_retryable",
            format!("the scene is {}; submit a new one with another seed", state.as_str()),
        ),
        RetryOutcome::Refused(reached) => Err(refused(reached)),
        RetryOutcome::NoSuchStage => conflict(
            "stage_not_reached",
            "the job never came to that `from_stage`; GET its stages for the names".to_owned(),
        ),
    }
}

/// A job that is there.
pub(super) async fn find(api: &TenantApi, job_id: &JobId) -> Result<JobRow, Problem> {
    let job = api.store.job(&api.tenant_id, job_id).await?;
    job.ok_or_else(|| Problem::not_found("job", job_id.as_str()))
}

/// A job as clients see it.
pub(super) async fn view(api: &TenantApi, job: JobRow) -> Result<JobView, Problem> {
    let id = job.id.clone();
    let view = views(api, vec![Some(job)]).await?.pop().flatten();
    view.ok_or_else(|| Problem::not_found("job", id.as_str()))
}

/// As [`view`], for the jobs of a page at once.
pub(super) async fn views(
    api: &TenantApi,
    jobs: Vec<Option<JobRow>>,
) -> Result<Vec<Option<JobView>>, Problem> {
    let known: Vec<&JobRow> = jobs.iter().flatten().collect();
    let mut outlooks = api.store.outlooks(&api.tenant_id, &known).await?.into_iter();
    let executions = known.iter().filter(|job| job.kind == JobKind::ExecuteTask);
    let executions: Vec<JobId> = executions.map(|job| job.id.clone()).collect();
    let mut scenes = api.store.executed_scenes(&api.tenant_id, &executions).await?;
    let mut view = |job: JobRow| {
        let scene_id = job.scene_id.clone().or_else(|| scenes.remove(&job.id));
        JobView::new(JobRow { scene_id, ..job }, outlooks.next().unwrap_or_default())
    };
    Ok(jobs.into_iter().map(|job| job.map(&mut view)).collect())
}
