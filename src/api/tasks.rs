//! `/scenes/{scene_id}/tasks`: what a robot could do in a finished scene, with goals that are decided from poses.

use std::sync::Arc;

use axum::Json;
use axum::extract::{Path, State};
use axum::response::{IntoResponse, Response};
use serde::Deserialize;
use serde_json::Value;

use super::Api;
use super::admission::overloaded;
use super::error::{Problem, ProblemType};
use super::parent::ParentBundle;
use super::query::Parameters;
use super::scenes::{find, parse_id};
use super::submission::check_text;
use scene::request::MAX_SEED;

/// Most tasks of one answer.
pub const MAX_TASKS: usize = 50;
/// Most of those that are rehearsed.
const MAX_REHEARSED: usize = 10;

/// Order of tasks by a client.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct TasksRequest {
    /// Name of a robot in `config/robots/`.
    pub robot: String,
    /// Number of proposals, 1..=50.
    pub count: usize,
    /// The same scene, seed and robot give the same proposals.
    pub seed: u64,
    /// An instruction to read in place of proposals.
    pub text: Option<String>,
    /// Whether only tasks are proposed whose grasps hold in simulation and whose motions the arm can make. Takes
    /// seconds for each object. An instruction is not rehearsed.
    pub rehearsed: bool,
}

impl Default for TasksRequest {
    fn default() -> Self {
        Self { robot: "panda".to_owned(), count: 5, seed: 0, text: None, rehearsed: true }
    }
}

impl TasksRequest {
    /// Whether proposals are asked for that are rehearsed.
    fn is_rehearsed(&self) -> bool {
        self.rehearsed && self.text.is_none()
    }
}

/// The tasks of the scene in an archive. It computes, so it blocks. Made by `app::tasks::propose_tasks`.
pub type ProposeTasks = Arc<dyn Fn(&[u8], &TasksRequest) -> Result<Value, Problem> + Send + Sync>;

/// `GET /scenes/{scene_id}/tasks`.
pub async fn list(
    State(api): State<Api>,
    Path(scene_id): Path<String>,
    Parameters(request): Parameters<TasksRequest>,
) -> Result<Response, Problem> {
    let scene_id = parse_id(&scene_id)?;
    check(&request, api.settings.max_text_chars)?;
    let _permit = api.requests.clone().try_acquire_owned().map_err(|_| overloaded())?;
    let scene = find(&api, &scene_id).await?;
    let bundle = ParentBundle::of(&api, &scene, true).await?;
    // Rehearsals simulate for seconds, as executions do; the rest takes milliseconds.
    let permit = if request.is_rehearsed() {
        api.executions.clone().try_acquire_owned().map_err(|_| overloaded())?
    } else {
        api.decoders.clone().acquire_owned().await.map_err(|_| overloaded())?
    };
    let propose = api.propose_tasks.clone();
    let document = bundle.compute(&api, &scene_id, permit, move |archive| propose(archive, &request)).await?;
    Ok(Json(document).into_response())
}

/// Checks the values of a request; the command line has the same bounds.
///
/// # Errors
///
/// [`Problem`] for a count out of range, or a text that is empty or too long.
pub fn check(request: &TasksRequest, max_text_chars: usize) -> Result<(), Problem> {
    let invalid = |name: &str, why: String| {
        let detail = format!("query parameters: {name} {why}");
        Problem::new(ProblemType::MalformedRequest, "invalid_parameter", detail)
    };
    if !(1..=MAX_TASKS).contains(&request.count) {
        return Err(invalid("count", format!("must be a whole number from 1 to {MAX_TASKS}")));
    }
    if request.is_rehearsed() && request.count > MAX_REHEARSED {
        let why = format!(
            "must be at most {MAX_REHEARSED} where tasks are rehearsed; more are proposed with rehearsed=false \
             (--no-rehearse)"
        );
        return Err(invalid("count", why));
    }
    if request.seed > MAX_SEED {
        return Err(invalid("seed", format!("must be at most {MAX_SEED}")));
    }
    match &request.text {
        Some(text) => check_text(text, max_text_chars).map(|_| ()).map_err(|why| invalid("text", why)),
        None => Ok(()),
    }
}
