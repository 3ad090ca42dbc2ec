//! `/scenes/{scene_id}/variants`: several new scenes, made from a finished one by operations that seeds draw.
//!
//! [`validate`] is a function of its own, so that the command line refuses the same requests.

use std::collections::BTreeMap;

use axum::Json;
use axum::extract::{Path, Request, State};
use axum::http::{HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use serde::{Deserialize, Serialize};
use serde_json::json;

use super::admission::overloaded;
use super::body::BodyReader;
use super::edits::EditOptions;
use super::enqueue::{Delivery, enqueue_one, queue_full};
use super::error::{FieldError, Problem, ProblemType};
use super::json_body::{media_type, parse_apart};
use super::parent::ParentBundle;
use super::query::{Parameters, Time};
use super::scenes::{SubmitParameters, find, parse_id};
use super::submission::Submission;
use super::terms::{Terms, draw_seed};
use super::{Api, Validate};
use runtime::seed::child_seed;
use scene::request::{MAX_SEED, RequestOptions};
use scene::variant::MAX_VARIANTS;
use scene::{Input, Randomize, SceneId, Violation};

/// The body of a request for variants, not validated.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct VariantsBody {
    pub count: u32,
    /// Differences between variants; everything where it is absent.
    pub randomize: Option<Randomize>,
    /// Whether the parent may be a scene whose certificate says quarantine.
    pub allow_quarantined: bool,
    pub seed: Option<u64>,
    pub labels: BTreeMap<String, String>,
    pub options: EditOptions,
    pub priority: Option<i64>,
    pub not_before: Option<Time>,
    pub deadline: Option<Time>,
}

impl Default for VariantsBody {
    fn default() -> Self {
        Self {
            count: 1,
            randomize: None,
            allow_quarantined: false,
            seed: None,
            labels: BTreeMap::new(),
            options: EditOptions::default(),
            priority: None,
            not_before: None,
            deadline: None,
        }
    }
}

/// A request for variants that is valid.
pub struct Variants {
    /// Seed from which the seed of every variant is drawn.
    pub seed: u64,
    pub randomize: Randomize,
    /// One per variant, in order.
    pub submissions: Vec<Submission>,
}

/// The answer: the scenes in order.
#[derive(Serialize)]
struct VariantsView {
    parent: SceneId,
    seed: u64,
    randomize: Randomize,
    scenes: Vec<VariantView>,
    /// Variants for which the queue has no room; the same request with the same Idempotency-Key goes on.
    remaining: usize,
}

#[derive(Serialize)]
struct VariantView {
    id: SceneId,
    seed: u64,
    link: String,
}

/// `POST /scenes/{scene_id}/variants`.
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
            "send application/json such as {\"count\": 20, \"randomize\": {\"layout\": true}}",
        ));
    }
    let reader = BodyReader::new(&api, &parts, body, api.settings.max_body_bytes);
    let (body, _memory) = parse_apart::<VariantsBody>(&api, reader.collect().await?).await?;
    let _permit = api.requests.clone().try_acquire_owned().map_err(|_| overloaded())?;
    let scene = find(&api, &scene_id).await?;
    let parent = ParentBundle::of(&api, &scene, body.allow_quarantined).await?;
    // A key without a seed names the same variants when it comes again.
    let drawn = delivery.idempotency_key.as_ref().map(|key| child_seed(0, key) & MAX_SEED);
    let body = VariantsBody { seed: body.seed.or(drawn), ..body };
    let Variants { seed, randomize, submissions } = validate(body, &parent, &api.validate)?;
    if validate_only {
        let requests: Vec<_> = submissions.iter().map(|submission| &submission.request).collect();
        return Ok(Json(json!({ "valid": true, "requests": requests })).into_response());
    }
    let mut view = VariantsView {
        parent: scene_id.clone(),
        seed,
        randomize,
        remaining: submissions.len(),
        scenes: Vec::with_capacity(submissions.len()),
    };
    let mut retry_after_secs = None;
    for (index, submission) in submissions.into_iter().enumerate() {
        let key = delivery.idempotency_key.as_ref().map(|key| format!("{key}/{index}"));
        let seed = submission.request.seed;
        match enqueue_one(&api, submission.child_of(scene_id.clone()), key).await? {
            Ok(enqueued) => {
                let link = format!("/scenes/{}", enqueued.scene_id);
                view.scenes.push(VariantView { id: enqueued.scene_id, seed, link });
                view.remaining -= 1;
            }
            Err(full) if view.scenes.is_empty() => return Ok(queue_full(full)),
            Err(full) => {
                retry_after_secs = Some(full.retry_after_secs);
                break;
            }
        }
    }
    let mut response = (StatusCode::ACCEPTED, Json(view)).into_response();
    if let Some(seconds) = retry_after_secs {
        response.headers_mut().insert(header::RETRY_AFTER, HeaderValue::from(seconds));
    }
    Ok(response)
}

/// Validates a request for variants of the parent; the results may be enqueued, once they have the parent's row.
///
/// # Errors
///
/// A [`Problem`] with every violation of the body.
pub fn validate(
    body: VariantsBody,
    parent: &ParentBundle,
    validate_settings: &Validate,
) -> Result<Variants, Problem> {
    let VariantsBody { count, randomize, seed, labels, options, priority, not_before, deadline, .. } = body;
    let EditOptions { budget_usd, robot, set } = options;
    let options = RequestOptions { budget_usd, robot, set, ..RequestOptions::default() };
    let terms = Terms { seed, labels, options, priority, not_before, deadline };
    let mut errors = terms.errors();
    if !(1..=MAX_VARIANTS).contains(&count) {
        errors.push(FieldError::new("/count", format!("must be from 1 to {MAX_VARIANTS}")));
    }
    let randomize = randomize.unwrap_or_default();
    for Violation { pointer, detail } in randomize.violations() {
        errors.push(FieldError::new(format!("/randomize{pointer}"), detail));
    }
    if !errors.is_empty() {
        return Err(Problem::invalid(errors));
    }
    let randomize = randomize.or_usual();
    let seed = seed.unwrap_or_else(draw_seed);
    let of_variant = |index: u32| {
        let seed = Some(child_seed(seed, &format!("variant {index}")) & MAX_SEED);
        let input =
            Input::Variant { parent: parent.id.clone(), bundle_sha256: parent.digest.to_string(), randomize };
        Terms { seed, ..terms.clone() }.submission(input, validate_settings)
    };
    let submissions = (0..count).map(of_variant).collect::<Result<_, _>>()?;
    Ok(Variants { seed, randomize, submissions })
}
