//! `/scenes/{scene_id}/edits`: a new scene, made from a finished one by operations or by an instruction in words.
//!
//! [`validate`] is a function of its own, so that the command line refuses the same requests.

use std::collections::BTreeMap;

use axum::Json;
use axum::extract::{Path, Request, State};
use axum::response::{IntoResponse, Response};
use serde::Deserialize;
use serde_json::{Value, json};

use super::admission::overloaded;
use super::body::BodyReader;
use super::edit_operations;
use super::enqueue::{Delivery, enqueue};
use super::error::{FieldError, Problem, ProblemType};
use super::json_body::{media_type, parse_apart};
use super::parent::ParentBundle;
use super::query::{Parameters, Time};
use super::scenes::{SubmitParameters, find, parse_id};
use super::submission::{Submission, check_text};
use super::terms::Terms;
use super::{Api, ReadInstruction, Validate};
use scene::request::RequestOptions;
use scene::{EditOperation, Input, SceneId, SceneRequest};

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

/// `POST /scenes/{scene_id}/edits`.
pub async fn submit(
    State(api): State<Api>,
    Path(scene_id): Path<String>,
    Parameters(SubmitParameters { validate_only }): Parameters<SubmitParameters>,
    request: Request,
) -> Result<Response, Problem> {
    let scene_id = parse_id(&scene_id)?;
    let delivery = Delivery::of(&api, request.headers())?;
    let (parts, body) = request.into_parts();
    if media_type(&parts.headers) != "application/json" {
        return Err(Problem::new(
            ProblemType::UnsupportedMediaType,
            "body_format",
            "send application/json such as {\"operations\": [{\"op\": \"remove\", \"target\": \"the lamp\"}]}",
        ));
    }
    let reader = BodyReader::new(&api, &parts, body, api.settings.max_body_bytes);
    let (body, _memory) = parse_apart::<EditBody>(&api, reader.collect().await?).await?;
    let _permit = api.requests.clone().try_acquire_owned().map_err(|_| overloaded())?;
    let scene = find(&api, &scene_id).await?;
    let parent = ParentBundle::of(&api, &scene, body.allow_quarantined).await?;
    let submission =
        validate(body, &parent, api.settings.max_text_chars, &api.validate, &api.read_instruction)?;
    if validate_only {
        let prediction = predict(&api, &scene_id, &parent, &submission.request).await?;
        let document = json!({ "valid": true, "request": submission.request, "prediction": prediction });
        return Ok(Json(document).into_response());
    }
    enqueue(&api, submission.child_of(scene_id), delivery).await
}

/// Prediction of the edit, without a job; one archive in memory for each of a few requests at a time.
async fn predict(
    api: &Api,
    scene_id: &SceneId,
    parent: &ParentBundle,
    request: &SceneRequest,
) -> Result<Option<Value>, Problem> {
    let permit = api.decoders.clone().acquire_owned().await.map_err(|_| overloaded())?;
    let (predict, request) = (api.predict.clone(), request.clone());
    parent.compute(api, scene_id, permit, move |archive| predict(&request, archive)).await
}

/// Validates an edit of the parent; the result may be enqueued, once it has the parent's row.
///
/// # Errors
///
/// A [`Problem`] with every violation of the body.
pub fn validate(
    body: EditBody,
    parent: &ParentBundle,
    max_text_chars: usize,
    validate_settings: &Validate,
    read_instruction: &ReadInstruction,
) -> Result<Submission, Problem> {
    let EditBody { operations, text, seed, labels, options, priority, not_before, deadline, .. } = body;
    let EditOptions { budget_usd, robot, set } = options;
    let options = RequestOptions { budget_usd, robot, set, ..RequestOptions::default() };
    let terms = Terms { seed, labels, options, priority, not_before, deadline };
    let mut errors = terms.errors();
    let (operations, text) = match (operations, text) {
        (Some(items), None) => (edit_operations::read(&items), None),
        (None, Some(text)) => {
            let (operations, text) = read_text(&text, max_text_chars, read_instruction);
            (operations.map_err(|error| vec![error]), text)
        }
        (Some(_), Some(_)) => (Err(one_source("both are there")), None),
        (None, None) => (Err(one_source("there is neither")), None),
    };
    let operations = operations.unwrap_or_else(|wrong| {
        errors.extend(wrong);
        Vec::new()
    });
    if !errors.is_empty() {
        return Err(Problem::invalid(errors));
    }
    let (parent, bundle_sha256) = (parent.id.clone(), parent.digest.to_string());
    terms.submission(Input::Edit { parent, bundle_sha256, operations, text }, validate_settings)
}

fn one_source(which: &str) -> Vec<FieldError> {
    vec![FieldError::new("", format!("give `operations` or `text`, one of them; {which}"))]
}

/// The operations of an instruction, and the instruction without surrounding white space.
fn read_text(
    text: &str,
    max_chars: usize,
    read_instruction: &ReadInstruction,
) -> (Result<Vec<EditOperation>, FieldError>, Option<String>) {
    if !text.contains(char::is_alphanumeric) {
        return (Err(FieldError::new("/text", "is empty; say what to change")), None);
    }
    match check_text(text, max_chars) {
        Ok(text) => (read_instruction(&text), Some(text)),
        Err(detail) => (Err(FieldError::new("/text", detail)), None),
    }
}
