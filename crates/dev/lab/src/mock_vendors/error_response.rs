//! JSON responses, and error responses in each vendor's format.

use axum::body::Body;
use axum::http::StatusCode;
use axum::response::{IntoResponse, Response};
use serde_json::{Value, json};

use ports::ProviderError;

/// A JSON response.
pub(super) fn json_response(status: StatusCode, value: &Value) -> Response {
    let content_type = [("content-type", "application/json")];
    (status, content_type, Body::from(value.to_string())).into_response()
}

/// Reason of an error response.
#[derive(Debug)]
pub(super) enum VendorError {
    /// The request violates the protocol.
    Invalid(String),
    /// A referenced resource does not exist.
    NotFound(String),
    /// The embedded ports cannot answer.
    Unsupported(String),
}

impl VendorError {
    fn status(&self) -> StatusCode {
        match self {
            Self::Invalid(_) => StatusCode::BAD_REQUEST,
            Self::NotFound(_) => StatusCode::NOT_FOUND,
            Self::Unsupported(_) => StatusCode::UNPROCESSABLE_ENTITY,
        }
    }

    fn message(&self) -> &str {
        match self {
            Self::Invalid(message) | Self::NotFound(message) | Self::Unsupported(message) => message,
        }
    }

    /// OpenAI's format.
    pub(super) fn openai(self) -> Response {
        let error = json!({
            "message": self.message(), "type": "invalid_request_error", "param": null, "code": "invalid_value",
        });
        json_response(self.status(), &json!({ "error": error }))
    }

    /// Format of FastAPI and Replicate.
    pub(super) fn detail(self) -> Response {
        json_response(self.status(), &json!({ "detail": self.message(), "status": self.status().as_u16() }))
    }

    /// Format of Hunyuan3D's server.
    pub(super) fn hunyuan3d(self) -> Response {
        json_response(StatusCode::NOT_FOUND, &json!({ "text": self.message(), "error_code": 1 }))
    }
}

impl From<ProviderError> for VendorError {
    fn from(error: ProviderError) -> Self {
        Self::Unsupported(error.to_string())
    }
}
