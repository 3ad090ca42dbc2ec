//! A valid submission becomes a scene with a job, once for each idempotency key; the answer is the scene.
//!
//! `worker::Worker::run` claims the job.

use std::time::Duration;

use axum::Json;
use axum::extract::FromRequestParts;
use axum::http::request::Parts;
use axum::http::{HeaderMap, HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};

use super::Api;
use super::audit_trail::RequestRecord;
use super::extract::TenantApi;
use super::idempotency::{KeyScope, idempotency_key, scoped};
use super::limits::{check_bytes, refusal};
use super::scenes::{find, latest_job};
use super::views::{JobView, SceneView};
use crate::app::submission::Submission;
use crate::problem::Problem;
use crate::spans;
use scene::{JobId, SceneId};
use store::lifecycle::SceneState;
use store::limits::LimitReached;
use store::scenes::{NewRows, SubmitOutcome};

/// Options in the headers of a request for new work: `Idempotency-Key` and `Prefer`.
pub struct SubmissionOptions {
    pub(super) idempotency_key: Option<String>,
    /// Longest time that the client waits for the answer.
    pub(super) wait: Option<Duration>,
    record: RequestRecord,
}

impl FromRequestParts<Api> for SubmissionOptions {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, api: &Api) -> Result<Self, Problem> {
        Ok(Self {
            idempotency_key: idempotency_key(&parts.headers)?,
            wait: preferred_wait(&parts.headers, api.settings.max_wait_secs),
            record: parts.extensions.get::<RequestRecord>().cloned().unwrap_or_default(),
        })
    }
}

/// Enqueues a submission, waits as long as the client prefers, and answers with the scene.
///
/// # Errors
///
/// A [`Problem`] where there is no space for the scene, the key came with another body, or the store does not answer.
pub(super) async fn enqueue(
    api: &TenantApi,
    submission: Submission,
    options: SubmissionOptions,
) -> Result<Response, Problem> {
    let SubmissionOptions { idempotency_key, wait, record } = options;
    let key = scoped(api, KeyScope::Scene, idempotency_key.as_deref());
    // The status of an answer that waits is not known yet.
    let record = if wait.is_some() { RequestRecord::default() } else { record };
    let Enqueued { scene_id, rows } = match enqueue_one(api, submission, key, &record).await? {
        Ok(enqueued) => enqueued,
        Err(reached) => return Ok(refusal(reached)),
    };
    if let Some(wait) = wait {
        wait_for(api, Awaited::Scene(&scene_id), wait).await?;
    }
    let (scene, job) = match (rows, wait) {
        (Some(rows), None) => {
            let outlook = api.store.outlook_of_new(&api.tenant_id, &rows).await?;
            (rows.scene, Some(JobView::new(rows.job, outlook)))
        }
        _ => (find(api, &scene_id).await?, latest_job(api, &scene_id).await?),
    };
    let status = if scene.state == SceneState::Pending { StatusCode::ACCEPTED } else { StatusCode::OK };
    // Without `Prefer` the answer is always 202: the same request gets the same answer.
    let status = if wait.is_some() { status } else { StatusCode::ACCEPTED };
    let location = format!("/scenes/{scene_id}");
    let mut response = (status, Json(SceneView::new(scene, job))).into_response();
    if let Ok(location) = HeaderValue::from_str(&location) {
        response.headers_mut().insert(header::LOCATION, location);
    }
    if let Some(wait) = wait {
        preference_applied(&mut response, wait);
    }
    Ok(response)
}

/// States that the server waited as the client preferred.
pub(super) fn preference_applied(response: &mut Response, wait: Duration) {
    if let Ok(applied) = HeaderValue::from_str(&format!("wait={}", wait.as_secs())) {
        response.headers_mut().insert("preference-applied", applied);
    }
}

/// A scene that was enqueued, now or by an earlier request with the same key.
pub(super) struct Enqueued {
    pub scene_id: SceneId,
    /// Rows that were written now.
    rows: Option<Box<NewRows>>,
}

/// Enqueues a submission; the key has its scope. Inner `Err` where a limit leaves no room. A new scene is recorded with
/// the answer 202 in its own transaction.
///
/// # Errors
///
/// As [`enqueue`].
pub(super) async fn enqueue_one(
    api: &TenantApi,
    submission: Submission,
    idempotency_key: Option<String>,
    record: &RequestRecord,
) -> Result<Result<Enqueued, LimitReached>, Problem> {
    check_bytes(api).await?;
    let budget_usd = api.settings.usual_budget_usd;
    let schedule = submission.schedule(&api.app.config().queue);
    let new = submission.into_row(&api.store, api.tenant_id.clone(), budget_usd, idempotency_key).await?;
    let _turn = api.submissions.of(&api.tenant_id).await;
    let entry = record.take(StatusCode::ACCEPTED);
    let outcome = api.store.submit_scheduled(new, schedule, entry.clone()).await;
    if !matches!(outcome, Ok(SubmitOutcome::Created { .. })) {
        record.give_back(entry);
    }
    match outcome? {
        SubmitOutcome::Created { scene_id, job_id, rows } => {
            metrics::counter!("tabletopgen_scenes_submitted_total").increment(1);
            spans::submitted(Some(&scene_id), &job_id);
            Ok(Ok(Enqueued { scene_id, rows: Some(rows) }))
        }
        SubmitOutcome::Replayed { scene_id, job_id } => {
            spans::submitted(Some(&scene_id), &job_id);
            Ok(Ok(Enqueued { scene_id, rows: None }))
        }
        SubmitOutcome::Refused(reached) => Ok(Err(reached)),
        SubmitOutcome::KeyReused => Err(Problem::key_reused("scene")),
    }
}

/// `Prefer: wait=N`; what cannot be understood is ignored, as preferences are.
fn preferred_wait(headers: &HeaderMap, max_secs: u64) -> Option<Duration> {
    let preferences = headers.get_all("prefer").into_iter().filter_map(|value| value.to_str().ok());
    preferences
        .flat_map(|value| value.split(','))
        .find_map(|preference| preference.trim().strip_prefix("wait=")?.trim().parse::<u64>().ok())
        .map(|seconds| Duration::from_secs(seconds.min(max_secs)))
}

/// Work whose end a client waits for.
pub(super) enum Awaited<'a> {
    /// All jobs of a scene.
    Scene(&'a SceneId),
    Job(&'a JobId),
}

impl Awaited<'_> {
    async fn has_ended(&self, api: &TenantApi) -> Result<bool, Problem> {
        Ok(match self {
            Self::Scene(id) => {
                let scene = api.store.scene(&api.tenant_id, id).await?;
                scene.is_none_or(|scene| scene.state != SceneState::Pending)
            }
            Self::Job(id) => {
                let job = api.store.job(&api.tenant_id, id).await?;
                job.is_none_or(|job| job.state.is_final())
            }
        })
    }
}

/// Returns when the work has ended, or after `wait`, or when the process is to end.
pub(super) async fn wait_for(api: &TenantApi, awaited: Awaited<'_>, wait: Duration) -> Result<(), Problem> {
    let deadline = tokio::time::Instant::now() + wait;
    let mut changes = api.store.changes();
    while !awaited.has_ended(api).await? {
        tokio::select! {
            () = tokio::time::sleep_until(deadline) => return Ok(()),
            () = api.shutdown.cancelled() => return Ok(()),
            _ = changes.changed() => {}
        }
    }
    Ok(())
}
