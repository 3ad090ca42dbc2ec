//! Bodies of changes: a JSON merge patch (RFC 7396) of the media type `application/merge-patch+json`.

use axum::extract::{FromRequest, Request};
use axum::http::HeaderValue;
use axum::response::{IntoResponse, Response};

use super::Api;
use super::body::BodyReader;
use super::contract::operation::{Describe, Operation};
use super::extract::JsonRequest;
use super::json_body::{MAX_SMALL_BODY_BYTES, media_type, parse};
use crate::problem::{Problem, ProblemType};

const MEDIA_TYPE: &str = "application/merge-patch+json";

/// The value of a merge patch.
pub struct MergePatch<T>(pub T);

impl<T: JsonRequest> FromRequest<Api> for MergePatch<T> {
    type Rejection = Response;

    async fn from_request(request: Request, api: &Api) -> Result<Self, Response> {
        if media_type(request.headers()) != MEDIA_TYPE {
            let detail = format!("send {MEDIA_TYPE} such as {}", T::EXAMPLE);
            let refusal = Problem::new(ProblemType::UnsupportedMediaType, "body_format", detail);
            let mut response = refusal.into_response();
            // RFC 5789, section 2.2.
            response.headers_mut().insert("accept-patch", HeaderValue::from_static(MEDIA_TYPE));
            return Err(response);
        }
        let (parts, body) = request.into_parts();
        let max_bytes = MAX_SMALL_BODY_BYTES.min(api.settings.max_body_bytes);
        let body = BodyReader::new(api, &parts, body, max_bytes).collect().await;
        let body = body.map_err(IntoResponse::into_response)?;
        parse(&body.bytes).map(Self).map_err(IntoResponse::into_response)
    }
}

impl<T: JsonRequest> Describe for MergePatch<T> {
    fn describe(operation: &mut Operation<'_>) {
        operation.reads::<T::Schema>(MEDIA_TYPE);
        operation.shows(MEDIA_TYPE, T::EXAMPLE);
    }
}
