//! `/scenes/{scene_id}/variants`: several new scenes, made from a finished one by operations that seeds draw.

use std::collections::BTreeMap;

use axum::Json;
use axum::http::{HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::admission::overloaded;
use super::audit_trail::RequestRecord;
use super::edits::EditOptions;
use super::enqueue::enqueue_one;
use super::extract::{JsonBody, JsonRequest, PathId, TenantApi};
use super::idempotency::{IdempotencyKey, KeyScope, scoped};
use super::limits::refusal;
use super::parent;
use super::query::{NoParameters, Parameters, Time};
use super::scene_body::terms;
use crate::app::variants::{Variants, VariantsOrder};
use crate::problem::Problem;
use crate::schemas::scene_request::Labels;
use crate::schemas::values::{
    AllowQuarantined, Deadline, Id, MAX_INTEGER, NotBefore, OptionalSeed, Priority,
};
use runtime::seed::child_seed;
use scene::request::MAX_SEED;
use scene::{Randomize, SceneId, SceneRequest};

/// Number of variants, and the differences between them.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
#[schemars(rename = "VariantsSubmission")]
pub struct VariantsBody {
    #[schemars(range(min = 1, max = 1000))]
    pub count: u32,
    /// Differences; everything where it is absent or names nothing.
    pub randomize: Option<Randomize>,
    /// Whether the parent may be a scene whose certificate says quarantine.
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
    type Schema = Self;
    const EXAMPLE: &str = r#"{"count": 20, "randomize": {"layout": true}}"#;
    const IS_SMALL: bool = false;
}

/// The variants of a scene, in order.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "Variants")]
pub(super) struct VariantsView {
    #[schemars(with = "Id")]
    parent: SceneId,
    /// Seed that the seeds of the variants are drawn from.
    #[schemars(range(min = 0, max = MAX_INTEGER))]
    seed: u64,
    randomize: Randomize,
    scenes: Vec<VariantView>,
    /// Variants for which a limit leaves no room; the same request with the same Idempotency-Key goes on.
    #[schemars(range(min = 0, max = 1000))]
    remaining: usize,
}

/// One variant.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "Variant")]
pub(super) struct VariantView {
    #[schemars(with = "Id")]
    id: SceneId,
    #[schemars(range(min = 0, max = MAX_INTEGER))]
    seed: u64,
    link: String,
}

/// The requests of the variants as they are understood.
#[derive(Serialize, JsonSchema)]
pub(super) struct ValidatedVariants {
    #[schemars(extend("const" = true))]
    valid: bool,
    requests: Vec<SceneRequest>,
}

/// `POST /scenes/{scene_id}/variants`.
pub async fn submit(
    api: TenantApi,
    PathId(scene_id): PathId<SceneId>,
    _: Parameters<NoParameters>,
    IdempotencyKey(idempotency_key): IdempotencyKey,
    JsonBody { value: body, memory: _memory }: JsonBody<VariantsBody>,
) -> Result<Response, Problem> {
    let _permit = api.requests.clone().try_acquire_owned().map_err(|_| overloaded())?;
    let parent = parent::bundle_of(&api, &scene_id, body.allow_quarantined).await?;
    // A key without a seed names the same variants when it comes again.
    let drawn = idempotency_key.as_ref().map(|key| child_seed(0, key) & MAX_SEED);
    let body = VariantsBody { seed: body.seed.or(drawn), ..body };
    let variants = api.app.check_variants(body.order(), &parent)?;
    enqueue_all(&api, scene_id, variants, idempotency_key).await
}

/// `POST /scenes/{scene_id}/variants/validate`.
pub async fn validate(
    api: TenantApi,
    PathId(scene_id): PathId<SceneId>,
    _: Parameters<NoParameters>,
    JsonBody { value: body, memory: _memory }: JsonBody<VariantsBody>,
) -> Result<Response, Problem> {
    let _permit = api.requests.clone().try_acquire_owned().map_err(|_| overloaded())?;
    let parent = parent::bundle_of(&api, &scene_id, body.allow_quarantined).await?;
    let variants = api.app.check_variants(body.order(), &parent)?;
    let requests = variants.submissions.into_iter().map(|submission| submission.request).collect();
    Ok(Json(ValidatedVariants { valid: true, requests }).into_response())
}

/// Enqueues variants in order until a limit leaves no room.
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
        let key = scoped(api, KeyScope::Variant(index), idempotency_key.as_deref());
        let seed = submission.request.seed;
        match enqueue_one(api, submission.child_of(view.parent.clone()), key, &RequestRecord::default())
            .await?
        {
            Ok(enqueued) => {
                let link = format!("/scenes/{}", enqueued.scene_id);
                view.scenes.push(VariantView { id: enqueued.scene_id, seed, link });
                view.remaining -= 1;
            }
            Err(reached) if view.scenes.is_empty() => return Ok(refusal(reached)),
            Err(reached) => {
                retry_after_secs = Some(reached.retry_after_secs);
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
