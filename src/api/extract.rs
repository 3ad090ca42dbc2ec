//! Typed extractors: the tenant of a request, the id in a path, and a JSON body within its limits.

use std::ops::Deref;
use std::str::FromStr;

use axum::extract::{FromRequest, FromRequestParts, RawPathParams, Request};
use axum::http::request::Parts;
use axum::http::{Extensions, HeaderMap};
use schemars::JsonSchema;
use serde::de::DeserializeOwned;

use super::Api;
use super::body::{BodyReader, ReceivedBody};
use super::body_memory::Reservation;
use super::json_body::{MAX_SMALL_BODY_BYTES, media_type, parse_apart};
use super::principal::Principal;
use crate::problem::{Problem, ProblemType};
use scene::{BatchId, DatasetId, JobId, KeyId, RecordingId, SceneId, TenantId, WebhookId};
use store::DEFAULT_TENANT;

/// The state that handlers share, on behalf of the tenant that a request comes from.
#[derive(Clone)]
pub struct TenantApi {
    api: Api,
    pub tenant_id: TenantId,
    pub principal: Principal,
}

impl Deref for TenantApi {
    type Target = Api;

    fn deref(&self) -> &Api {
        &self.api
    }
}

impl FromRequestParts<Api> for TenantApi {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, api: &Api) -> Result<Self, Problem> {
        // The gate of the route has put it there.
        let Some(principal) = parts.extensions.get::<Principal>().cloned() else {
            let detail = "this route has no principal, which is a bug of the server; report it";
            return Err(Problem::new(ProblemType::Internal, "internal_error", detail));
        };
        Ok(Self { api: api.clone(), tenant_id: principal.tenant_id.clone(), principal })
    }
}

/// An id that paths have, and the name of what it identifies.
pub trait ResourceId: FromStr {
    const NAME: &str;
}

impl ResourceId for SceneId {
    const NAME: &str = "scene";
}

impl ResourceId for JobId {
    const NAME: &str = "job";
}

impl ResourceId for BatchId {
    const NAME: &str = "batch";
}

impl ResourceId for DatasetId {
    const NAME: &str = "dataset";
}

impl ResourceId for KeyId {
    const NAME: &str = "key";
}

impl ResourceId for RecordingId {
    const NAME: &str = "recording of episodes";
}

impl ResourceId for WebhookId {
    const NAME: &str = "webhook";
}

/// The id in a path, its first parameter. A text that is no id identifies nothing.
pub struct PathId<T>(pub T);

impl<T: ResourceId> FromRequestParts<Api> for PathId<T> {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, api: &Api) -> Result<Self, Problem> {
        let parameters = RawPathParams::from_request_parts(parts, api).await;
        let parameters = parameters.map_err(|_| Problem::not_found(T::NAME, parts.uri.path()))?;
        let text = parameters.iter().next().map_or("", |(_, text)| text);
        text.parse().map(Self).map_err(|_| Problem::not_found(T::NAME, text))
    }
}

/// The last parameter of a path: the name of something below a resource.
pub struct PathName(pub String);

impl FromRequestParts<Api> for PathName {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, api: &Api) -> Result<Self, Problem> {
        let parameters = RawPathParams::from_request_parts(parts, api).await;
        let parameters = parameters.map_err(|_| Problem::not_found("name", parts.uri.path()))?;
        Ok(Self(parameters.iter().last().map_or_else(String::new, |(_, text)| text.to_owned())))
    }
}

/// The type of a JSON body.
pub trait JsonRequest: DeserializeOwned + Send + 'static {
    /// The type that describes it in the contract.
    type Schema: JsonSchema;
    /// A body for those who send another media type.
    const EXAMPLE: &str;
    /// Whether it states a few values: larger ones are refused early.
    const IS_SMALL: bool = true;
}

/// The value of a body of the media type `application/json`. The memory is that of the body and the value.
pub struct JsonBody<T> {
    pub value: T,
    pub memory: Reservation,
}

impl<T: JsonRequest> FromRequest<Api> for JsonBody<T> {
    type Rejection = Problem;

    async fn from_request(request: Request, api: &Api) -> Result<Self, Problem> {
        if !is_json(request.headers()) {
            let detail = format!("send application/json such as {}", T::EXAMPLE);
            return Err(Problem::new(ProblemType::UnsupportedMediaType, "body_format", detail));
        }
        let tenant_id = tenant_of(request.extensions());
        let (value, memory) = parse_apart(api, &tenant_id, collected::<T>(request, api).await?).await?;
        Ok(Self { value, memory })
    }
}

/// The value of a JSON body, or the default where there is no body.
pub struct OptionalJsonBody<T>(pub T);

impl<T: JsonRequest + Default> FromRequest<Api> for OptionalJsonBody<T> {
    type Rejection = Problem;

    async fn from_request(request: Request, api: &Api) -> Result<Self, Problem> {
        let (is_json, tenant_id) = (is_json(request.headers()), tenant_of(request.extensions()));
        let body = collected::<T>(request, api).await?;
        if body.is_empty() {
            return Ok(Self(T::default()));
        }
        if !is_json {
            let detail = format!("send application/json such as {}, or no body", T::EXAMPLE);
            return Err(Problem::new(ProblemType::UnsupportedMediaType, "body_format", detail));
        }
        Ok(Self(parse_apart(api, &tenant_id, body).await?.0))
    }
}

/// The tenant of a request; the usual one where its route has no principal.
fn tenant_of(extensions: &Extensions) -> TenantId {
    extensions
        .get::<Principal>()
        .map_or_else(|| DEFAULT_TENANT.clone(), |principal| principal.tenant_id.clone())
}

fn is_json(headers: &HeaderMap) -> bool {
    media_type(headers) == "application/json"
}

async fn collected<T: JsonRequest>(request: Request, api: &Api) -> Result<ReceivedBody, Problem> {
    let (parts, body) = request.into_parts();
    let max_bytes = match T::IS_SMALL {
        true => MAX_SMALL_BODY_BYTES.min(api.settings.max_body_bytes),
        false => api.settings.max_body_bytes,
    };
    BodyReader::new(api, &parts, body, max_bytes).collect().await
}
