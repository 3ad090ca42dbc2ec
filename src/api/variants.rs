//! `/scenes/{scene_id}/variants`: several new scenes, made from a finished one by operations that seeds draw.

use std::collections::BTreeMap;

use axum::Json;
use axum::http::{HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use serde::{Deserialize, Serialize};
use serde_json::json;

use super::admission::overloaded;
use super::edits::EditOptions;
use super::enqueue::{Delivery, enqueue_one, queue_full};
use super::extract::{JsonBody, JsonRequest, PathId, TenantApi};
use super::parent;
use super::query::{Parameters, Time};
use super::scene_body::terms;
use super::scenes::{SubmitParameters, find};
use crate::app::variants::{Variants, VariantsOrder};
use crate::problem::Problem;
use runtime::seed::child_seed;
use scene::request::MAX_SEED;
use scene::{Randomize, SceneId};

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

impl VariantsBody {
    fn order(self) -> VariantsOrder {
        let Self { count, randomize, seed, labels, options, priority, not_before, deadline, .. } = self;
        let terms = terms(seed, labels, options.options(), (priority, not_before, deadline));
        VariantsOrder { count, randomize, terms }
    }
}

impl JsonRequest for VariantsBody {
    const EXAMPLE: &str = r#"{"count": 20, "randomize": {"layout": true}}"#;
    const IS_SMALL: bool = false;
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
    api: TenantApi,
    PathId(scene_id): PathId<SceneId>,
    Parameters(SubmitParameters { validate_only }): Parameters<SubmitParameters>,
    delivery: Delivery,
    JsonBody { value: body, memory: _memory }: JsonBody<VariantsBody>,
) -> Result<Response, Problem> {
    let _permit = api.requests.clone().try_acquire_owned().map_err(|_| overloaded())?;
    let scene = find(&api, &scene_id).await?;
    let parent = parent::bundle_of(&api, &scene, body.allow_quarantined).await?;
    // A key without a seed names the same variants when it comes again.
    let drawn = delivery.idempotency_key.as_ref().map(|key| child_seed(0, key) & MAX_SEED);
    let body = VariantsBody { seed: body.seed.or(drawn), ..body };
    let variants = api.app.check_variants(body.order(), &parent)?;
    if validate_only {
        let requests: Vec<_> = variants.submissions.iter().map(|submission| &submission.request).collect();
        return Ok(Json(json!({ "valid": true, "requests": requests })).into_response());
    }
    enqueue_all(&api, scene_id, variants, delivery.idempotency_key).await
}

/// Enqueues variants in order until the queue has no room.
async fn enqueue_all(
    api: &TenantApi,
    parent: SceneId,
    variants: Variants,
    idempotency_key: Option<String>,
) -> Result<Response, Problem> {
    let Variants { seed, randomize, submissions } = variants;
    let mut view = VariantsView { parent, seed, randomize, remaining: submissions.len(), scenes: Vec::new() };
    let mut retry_after_secs = None;
    for (index, submission) in submissions.into_iter().enumerate() {
        let key = idempotency_key.as_ref().map(|key| format!("{key}/{index}"));
        let seed = submission.request.seed;
        match enqueue_one(api, submission.child_of(view.parent.clone()), key).await? {
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
