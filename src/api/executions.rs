//! `/scenes/{scene_id}/executions` and `/executions`: a simulated robot does a task in a finished scene.
//!
//! An execution is a job (see `executor`), and has its id; with `Prefer: wait` one request brings the answer, too. The
//! same scene, task, robot and seed give the same bytes again.

use std::sync::Arc;

use axum::extract::{Path, Request, State};
use axum::http::{HeaderMap, Method};
use axum::response::Response;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use super::accepted::accepted_at;
use super::admission::overloaded;
use super::download::{Content, Download, respond};
use super::enqueue::{preference_applied, preferred_wait};
use super::error::{FieldError, Problem, ProblemType};
use super::json_body::{json_bytes, media_type, parse};
use super::parent::ParentBundle;
use super::query::Parameters;
use super::scenes::{find, parse_id};
use super::submission::check_text;
use super::{Api, jobs};
use scene::JobId;
use scene::job::{FailureClass, JobState};
use scene::request::MAX_SEED;
use store::DEFAULT_TENANT;
use store::executions::NewExecution;
use store::jobs::JobRow;

/// The body of a request, not validated.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ExecutionBody {
    /// An instruction in words, or [`Self::task`].
    pub text: Option<String>,
    /// A task as `GET /scenes/{scene_id}/tasks` gives it; it names its robot.
    pub task: Option<Value>,
    /// The robot of an instruction in words.
    pub robot: String,
    pub seed: u64,
    /// Place of the robot's base; chosen if absent.
    pub base: Option<BasePlace>,
    /// Whether the archive has a video.
    pub video: bool,
}

/// Place of a robot's base, in the frame of the scene, and its direction: turned by `yaw_rad` about the vertical.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BasePlace {
    pub x_m: f64,
    pub y_m: f64,
    /// Above the top of the table.
    pub z_m: f64,
    pub yaw_rad: f64,
}

impl BasePlace {
    /// No number is greater than this, in meters and radians.
    const MAX: f64 = 10.0;

    /// Checks that no number is out of range.
    ///
    /// # Errors
    /// The name of the first that is, and what is wrong with it.
    pub fn check(&self) -> Result<(), (&'static str, String)> {
        let named = [("x_m", self.x_m), ("y_m", self.y_m), ("z_m", self.z_m), ("yaw_rad", self.yaw_rad)];
        match named.into_iter().find(|(_, value)| !(-Self::MAX..=Self::MAX).contains(value)) {
            Some((name, value)) => {
                Err((name, format!("is {value}; it must be from {} to {}", -Self::MAX, Self::MAX)))
            }
            None => Ok(()),
        }
    }
}

impl Default for ExecutionBody {
    fn default() -> Self {
        Self { text: None, task: None, robot: "panda".to_owned(), seed: 0, base: None, video: false }
    }
}

/// The form of the answer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ExecutionFormat {
    /// Verdict, task and motion as one document.
    #[default]
    Json,
    /// The files that `tabletopgen execute --out` writes.
    Zip,
}

/// Parameters of the request.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ExecutionParameters {
    format: ExecutionFormat,
}

/// Order of an execution.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct ExecutionRequest {
    pub task: RequestedTask,
    pub seed: u64,
    pub base: Option<BasePlace>,
    pub video: bool,
    pub format: ExecutionFormat,
}

/// An instruction for a robot, or a task.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum RequestedTask {
    Text {
        text: String,
        robot: String,
    },
    /// In its JSON form.
    Task(Value),
}

impl ExecutionRequest {
    /// Form of the stored request.
    const VERSION: u32 = 1;

    /// The request as it is stored.
    fn stored(&self) -> Value {
        json!({ "version": Self::VERSION, "order": self })
    }

    /// Inverse of [`Self::stored`].
    ///
    /// # Errors
    ///
    /// Another version wrote the request.
    pub fn of_stored(stored: &Value) -> Result<Self, serde_json::Error> {
        Self::deserialize(&stored["order"])
    }
}

/// Checks a request as far as that needs no scene. Made by `app::executions::check`.
pub type CheckExecution = Arc<dyn Fn(&ExecutionRequest) -> Result<(), Problem> + Send + Sync>;

/// `POST /scenes/{scene_id}/executions`.
pub async fn submit(
    State(api): State<Api>,
    Path(scene_id): Path<String>,
    Parameters(ExecutionParameters { format }): Parameters<ExecutionParameters>,
    request: Request,
) -> Result<Response, Problem> {
    let scene_id = parse_id(&scene_id)?;
    let (parts, body) = request.into_parts();
    if media_type(&parts.headers) != "application/json" {
        let detail = "send application/json such as {\"text\": \"put the apple in the bowl\"}";
        return Err(Problem::new(ProblemType::UnsupportedMediaType, "body_format", detail));
    }
    let wait = preferred_wait(&parts.headers, api.settings.max_wait_secs);
    let body = json_bytes(&api, body).await?;
    let asked = validate(parse(&body.bytes)?, format, api.settings.max_text_chars)?;
    (api.check_execution)(&asked)?;
    let _permit = api.requests.clone().try_acquire_owned().map_err(|_| overloaded())?;
    let scene = find(&api, &scene_id).await?;
    let bundle = ParentBundle::of(&api, &scene, true).await?;
    let new = NewExecution {
        tenant_id: DEFAULT_TENANT.clone(),
        scene_id,
        request: asked.stored(),
        bundle: bundle.digest,
    };
    let job_id = api.store.submit_execution(new).await?;
    let Some(wait) = wait else { return accepted(&api, &job_id).await };
    jobs::wait_for(&api, &job_id, wait).await?;
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
    State(api): State<Api>,
    Path(execution_id): Path<String>,
    method: Method,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let unknown = || Problem::not_found("execution", &execution_id);
    let job_id: JobId = execution_id.parse().map_err(|_| unknown())?;
    let job = api.store.job(&DEFAULT_TENANT, &job_id).await?.ok_or_else(unknown)?;
    answer(&api, job, &method, &headers).await
}

/// The answer of an ended execution.
async fn answer(api: &Api, job: JobRow, method: &Method, headers: &HeaderMap) -> Result<Response, Problem> {
    let execution = api.store.execution(&DEFAULT_TENANT, &job.id).await?;
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
async fn accepted(api: &Api, job_id: &JobId) -> Result<Response, Problem> {
    let view = jobs::view(api, jobs::find(api, job_id).await?).await?;
    Ok(accepted_at(&view.links.this, &view))
}

/// Checks the values of a body.
fn validate(
    body: ExecutionBody,
    format: ExecutionFormat,
    max_text_chars: usize,
) -> Result<ExecutionRequest, Problem> {
    let ExecutionBody { text, task, robot, seed, base, video } = body;
    let mut errors = Vec::new();
    if seed > MAX_SEED {
        errors.push(FieldError::new("/seed", format!("must be at most {MAX_SEED}")));
    }
    if let Some(Err((name, why))) = base.map(|base| base.check()) {
        errors.push(FieldError::new(format!("/base/{name}"), why));
    }
    if video && format == ExecutionFormat::Json {
        errors.push(FieldError::new("/video", "a video is in the archive alone; ask with format=zip"));
    }
    let task = match (text, task) {
        (Some(text), None) => match check_text(&text, max_text_chars) {
            Ok(text) => Some(RequestedTask::Text { text, robot }),
            Err(why) => {
                errors.push(FieldError::new("/text", why));
                None
            }
        },
        (None, Some(task)) => Some(RequestedTask::Task(task)),
        (both, _) => {
            let which = if both.is_some() { "both are there" } else { "there is neither" };
            errors.push(FieldError::new("", format!("give `text` or `task`, one of them; {which}")));
            None
        }
    };
    match task {
        Some(task) if errors.is_empty() => Ok(ExecutionRequest { task, seed, base, video, format }),
        _ => Err(Problem::invalid(errors)),
    }
}
