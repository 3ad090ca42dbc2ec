//! Answers that are no good news, in the shapes vendors use, and JSON answers.

use axum::body::Body;
use axum::http::StatusCode;
use axum::response::{IntoResponse, Response};
use serde_json::{Value, json};

use ports::ProviderError;

/// A JSON answer.
pub(super) fn answer(status: StatusCode, value: &Value) -> Response {
    let content_type = [("content-type", "application/json")];
    (status, content_type, Body::from(value.to_string())).into_response()
}

/// Why a question gets no answer.
#[derive(Debug)]
pub(super) enum Refusal {
    /// The request is not as the protocol wants it.
    Wrong(String),
    /// Something it names is not there.
    Missing(String),
    /// The embedded ports have no answer.
    Unable(String),
}

impl Refusal {
    fn status(&self) -> StatusCode {
        match self {
            Self::Wrong(_) => StatusCode::BAD_REQUEST,
            Self::Missing(_) => StatusCode::NOT_FOUND,
            Self::Unable(_) => StatusCode::UNPROCESSABLE_ENTITY,
        }
    }

    fn told(&self) -> &str {
        match self {
            Self::Wrong(told) | Self::Missing(told) | Self::Unable(told) => told,
        }
    }

    /// As OpenAI says it.
    pub(super) fn openai(self) -> Response {
        let error = json!({
            "message": self.told(), "type": "invalid_request_error", "param": null, "code": "invalid_value",
        });
        answer(self.status(), &json!({ "error": error }))
    }

    /// As FastAPI says it, and Replicate.
    pub(super) fn detail(self) -> Response {
        answer(self.status(), &json!({ "detail": self.told(), "status": self.status().as_u16() }))
    }

    /// As Hunyuan3D's server says everything.
    pub(super) fn hunyuan3d(self) -> Response {
        answer(StatusCode::NOT_FOUND, &json!({ "text": self.told(), "error_code": 1 }))
    }
}

impl From<ProviderError> for Refusal {
    fn from(error: ProviderError) -> Self {
        Self::Unable(error.to_string())
    }
}
