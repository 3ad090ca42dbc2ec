//! `/scenes/{scene_id}/tasks`: what a robot could do in a finished scene, with goals that are decided from poses.

use axum::Json;
use axum::response::{IntoResponse, Response};

use super::admission::overloaded;
use super::extract::{PathId, TenantApi};
use super::instructions::read_tasks;
use super::parent;
use super::query::{Parameters, invalid_parameter};
use crate::app::executions::TaskSource;
use crate::app::tasks::TasksRequest;
use crate::problem::Problem;
use scene::SceneId;

/// `GET /scenes/{scene_id}/tasks`.
pub async fn list(
    api: TenantApi,
    PathId(scene_id): PathId<SceneId>,
    Parameters(request): Parameters<TasksRequest>,
) -> Result<Response, Problem> {
    let checked = request.check(api.settings.max_text_chars);
    checked.map_err(|error| invalid_parameter(&format!("{} {}", &error.pointer[1..], error.detail)))?;
    let _permit = api.requests.clone().try_acquire_owned().map_err(|_| overloaded())?;
    let bundle = parent::bundle_of(&api, &scene_id, true).await?;
    let read = match &request.text {
        Some(text) => {
            let mut task = TaskSource::Text(text.clone());
            read_tasks(&api, &scene_id, &bundle, std::iter::once(&mut task), &request.robot).await?;
            Some(task)
        }
        None => None,
    };
    // Rehearsals simulate for seconds, as executions do; the rest takes milliseconds.
    let permit = match request.is_rehearsed() {
        true => (Some(api.rehearsals.clone().try_acquire_owned().map_err(|_| overloaded())?), None),
        false => (None, Some(api.decoders.of(&api.tenant_id).await)),
    };
    let app = api.app.clone();
    let propose = move |archive: &[u8]| app.propose_tasks(archive, &request, read);
    let found = parent::compute_with(&api, &scene_id, &bundle, permit, propose).await?;
    Ok(Json(found).into_response())
}
