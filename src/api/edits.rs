//! `/scenes/{scene_id}/edits`: a new scene, made from a finished one by operations or by an instruction in words.

use std::collections::BTreeMap;

use axum::Json;
use axum::response::{IntoResponse, Response};
use serde::Deserialize;
use serde_json::{Value, json};

use super::admission::overloaded;
use super::enqueue::{Delivery, enqueue};
use super::extract::{JsonBody, JsonRequest, PathId, TenantApi};
use super::parent;
use super::query::{Parameters, Time};
use super::scene_body::terms;
use super::scenes::{SubmitParameters, find};
use crate::app::edit_scene::EditOrder;
use crate::problem::Problem;
use scene::SceneId;
use scene::request::RequestOptions;

/// The body of an edit, not validated.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct EditBody {
    /// Operations as JSON, or [`Self::text`].
    pub operations: Option<Vec<Value>>,
    /// An instruction in words.
    pub text: Option<String>,
    /// Whether the parent may be a scene whose certificate says quarantine.
    pub allow_quarantined: bool,
    pub seed: Option<u64>,
    pub labels: BTreeMap<String, String>,
    pub options: EditOptions,
    pub priority: Option<i64>,
    pub not_before: Option<Time>,
    pub deadline: Option<Time>,
}

/// The options that an edit may have; the others are about texts and images.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct EditOptions {
    pub budget_usd: Option<f64>,
    pub robot: Option<String>,
    pub set: BTreeMap<String, String>,
}

impl EditOptions {
    pub(super) fn options(self) -> RequestOptions {
        let Self { budget_usd, robot, set } = self;
        RequestOptions { budget_usd, robot, set, ..RequestOptions::default() }
    }
}

impl EditBody {
    fn order(self) -> EditOrder {
        let Self { operations, text, seed, labels, options, priority, not_before, deadline, .. } = self;
        let terms = terms(seed, labels, options.options(), (priority, not_before, deadline));
        EditOrder { operations, text, terms }
    }
}

impl JsonRequest for EditBody {
    const EXAMPLE: &str = r#"{"operations": [{"op": "remove", "target": "the lamp"}]}"#;
    const IS_SMALL: bool = false;
}

/// `POST /scenes/{scene_id}/edits`.
pub async fn submit(
    api: TenantApi,
    PathId(scene_id): PathId<SceneId>,
    Parameters(SubmitParameters { validate_only }): Parameters<SubmitParameters>,
    delivery: Delivery,
    JsonBody { value: body, memory: _memory }: JsonBody<EditBody>,
) -> Result<Response, Problem> {
    let _permit = api.requests.clone().try_acquire_owned().map_err(|_| overloaded())?;
    let scene = find(&api, &scene_id).await?;
    let parent = parent::bundle_of(&api, &scene, body.allow_quarantined).await?;
    let submission = api.app.check_edit(body.order(), &parent)?;
    if !validate_only {
        return enqueue(&api, submission.child_of(scene_id), delivery).await;
    }
    // One archive in memory for each of a few requests at a time.
    let permit = api.decoders.clone().acquire_owned().await.map_err(|_| overloaded())?;
    let (app, request) = (api.app.clone(), submission.request);
    let predict = move |archive: &[u8]| {
        let prediction = app.predict_edit(&request, archive)?;
        Ok(json!({ "valid": true, "request": request, "prediction": prediction }))
    };
    let document = parent::compute_with(&api, &scene_id, &parent, permit, predict).await?;
    Ok(Json(document).into_response())
}
