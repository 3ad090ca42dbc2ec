//! `/scenes/{scene_id}/edits`: a new scene, made from a finished one by operations or by an instruction in words.

use std::collections::BTreeMap;

use axum::Json;
use axum::response::{IntoResponse, Response};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::admission::overloaded;
use super::enqueue::{SubmissionOptions, enqueue};
use super::extract::{JsonBody, JsonRequest, PathId, TenantApi};
use super::query::{NoParameters, Parameters, Time};
use super::scene_body::terms;
use super::{instructions, parent};
use crate::app::edit_scene::{EditOrder, ParentBundle, Prediction};
use crate::app::submission::Submission;
use crate::problem::Problem;
use crate::schemas::edits::EditOperations;
use crate::schemas::narrowed_types;
use crate::schemas::scene_request::Labels;
use crate::schemas::values::{AllowQuarantined, Deadline, NotBefore, OptionalSeed, Priority, SceneText};
use scene::request::{RequestOptions, SceneSettings};
use scene::{SceneId, SceneRequest};

/// The body of an edit, not validated.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct EditBody {
    #[schemars(with = "Option<EditOperations>")]
    pub operations: Option<Vec<Value>>,
    #[schemars(with = "Option<SceneText>")]
    pub text: Option<String>,
    #[schemars(with = "AllowQuarantined")]
    pub allow_quarantined: bool,
    #[schemars(with = "OptionalSeed")]
    pub seed: Option<u64>,
    #[schemars(with = "Labels")]
    pub labels: BTreeMap<String, String>,
    pub options: EditOptions,
    #[schemars(with = "Priority")]
    pub priority: Option<i64>,
    #[schemars(with = "NotBefore")]
    pub not_before: Option<Time>,
    #[schemars(with = "Deadline")]
    pub deadline: Option<Time>,
}

/// Exactly one of `operations` and `text` states the change.
#[derive(JsonSchema)]
#[schemars(untagged)]
pub enum EditSubmission {
    Operations(OperationsEdit),
    Instruction(InstructionEdit),
}

narrowed_types! {
    "An edit as a list of operations." OperationsEdit = EditBody, Some("operations"), &["text"];
    "An edit as an instruction in English words." InstructionEdit = EditBody, Some("text"), &["operations"];
}

/// Options of an edit.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct EditOptions {
    /// The most that calls of remote models may cost together; the server's usual budget when absent.
    #[schemars(range(min = 0.0, max = 10000.0))]
    pub budget_usd: Option<f64>,
    /// A robot that is tried in the finished scene, such as `panda`: its grasps of each object, what it can pick up,
    /// and tasks. Takes seconds for each object.
    #[schemars(length(min = 1, max = 63))]
    pub robot: Option<String>,
    #[schemars(with = "SceneSettings")]
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
        EditOrder { operations, text, program: None, terms }
    }
}

impl JsonRequest for EditBody {
    type Schema = EditSubmission;
    const EXAMPLE: &str = r#"{"operations": [{"op": "remove", "target": "the lamp"}]}"#;
    const IS_SMALL: bool = false;
}

/// The edit as it is understood.
#[derive(Serialize, JsonSchema)]
pub(super) struct ValidatedEdit {
    #[schemars(extend("const" = true))]
    valid: bool,
    request: SceneRequest,
    /// Places and collisions of the result; null where nothing is predicted.
    prediction: Option<Prediction>,
}

/// The checked edit. Words are read beside the objects of the parent: what stands there needs no article.
async fn checked(
    api: &TenantApi,
    scene_id: &SceneId,
    body: EditBody,
    parent: &ParentBundle,
) -> Result<Submission, Problem> {
    let mut order = body.order();
    if let Some(text) = api.app.instruction_of(&order) {
        order.program = Some(instructions::edit_program(api, scene_id, parent, text).await?);
    }
    api.app.check_edit(order, parent)
}

/// `POST /scenes/{scene_id}/edits`.
pub async fn submit(
    api: TenantApi,
    PathId(scene_id): PathId<SceneId>,
    _: Parameters<NoParameters>,
    options: SubmissionOptions,
    JsonBody { value: body, memory: _memory }: JsonBody<EditBody>,
) -> Result<Response, Problem> {
    let _permit = api.requests.clone().try_acquire_owned().map_err(|_| overloaded())?;
    let parent = parent::bundle_of(&api, &scene_id, body.allow_quarantined).await?;
    let submission = checked(&api, &scene_id, body, &parent).await?;
    enqueue(&api, submission.child_of(scene_id), options).await
}

/// `POST /scenes/{scene_id}/edits/validate`.
pub async fn validate(
    api: TenantApi,
    PathId(scene_id): PathId<SceneId>,
    _: Parameters<NoParameters>,
    JsonBody { value: body, memory: _memory }: JsonBody<EditBody>,
) -> Result<Response, Problem> {
    let _permit = api.requests.clone().try_acquire_owned().map_err(|_| overloaded())?;
    let parent = parent::bundle_of(&api, &scene_id, body.allow_quarantined).await?;
    let submission = checked(&api, &scene_id, body, &parent).await?;
    // One archive in memory for each of a few requests at a time.
    let permit = api.decoders.of(&api.tenant_id).await;
    let (app, request) = (api.app.clone(), submission.request);
    let predict = move |archive: &[u8]| {
        let prediction = app.predict_edit(&request, archive)?;
        Ok(ValidatedEdit { valid: true, request, prediction })
    };
    let document = parent::compute_with(&api, &scene_id, &parent, permit, predict).await?;
    Ok(Json(document).into_response())
}
