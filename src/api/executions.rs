//! `/scenes/{scene_id}/executions`: a simulated robot does a task in a finished scene.
//!
//! The answer is computed while the client waits, one at a time in a process, and it is not stored: the same scene,
//! task, robot and seed give the same bytes again.

use std::sync::Arc;

use axum::Json;
use axum::extract::{Path, Request, State};
use axum::http::header;
use axum::response::{IntoResponse, Response};
use serde::Deserialize;
use serde_json::Value;

use super::Api;
use super::admission::overloaded;
use super::error::{FieldError, Problem, ProblemType};
use super::json_body::{json_bytes, media_type, parse};
use super::parent::ParentBundle;
use super::query::Parameters;
use super::scenes::{find, parse_id};
use super::submission::check_text;
use scene::request::MAX_SEED;

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
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
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
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
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
#[derive(Clone, Debug)]
pub struct ExecutionRequest {
    pub task: RequestedTask,
    pub seed: u64,
    pub base: Option<BasePlace>,
    pub video: bool,
    pub format: ExecutionFormat,
}

/// An instruction for a robot, or a task.
#[derive(Clone, Debug)]
pub enum RequestedTask {
    Text {
        text: String,
        robot: String,
    },
    /// In its JSON form.
    Task(Value),
}

/// An execution in the form that was asked for.
pub enum ExecutionAnswer {
    Document(Value),
    Archive(Vec<u8>),
}

/// The execution of a task in the scene of an archive. It computes for seconds, so it blocks. Made by
/// `app::executions::execute_task`.
pub type ExecuteTask =
    Arc<dyn Fn(&[u8], &ExecutionRequest) -> Result<ExecutionAnswer, Problem> + Send + Sync>;

/// `POST /scenes/{scene_id}/executions`.
pub async fn run(
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
    let body = json_bytes(&api, body).await?;
    let asked = validate(parse(&body.bytes)?, format, api.settings.max_text_chars)?;
    let _permit = api.requests.clone().try_acquire_owned().map_err(|_| overloaded())?;
    let scene = find(&api, &scene_id).await?;
    let bundle = ParentBundle::of(&api, &scene, true).await?;
    let permit = api.executions.clone().try_acquire_owned().map_err(|_| overloaded())?;
    let execute = api.execute_task.clone();
    let answer = bundle.compute(&api, &scene_id, permit, move |archive| execute(archive, &asked)).await?;
    Ok(match answer {
        ExecutionAnswer::Document(document) => Json(document).into_response(),
        ExecutionAnswer::Archive(bytes) => {
            ([(header::CONTENT_TYPE, "application/zip")], bytes).into_response()
        }
    })
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
