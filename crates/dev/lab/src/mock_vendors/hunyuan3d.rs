//! `/send` and `/status/{uid}`, like Hunyuan3D's `api_server.py`: unknown jobs are `processing`.

use std::sync::Arc;

use axum::extract::{Path, State};
use axum::http::StatusCode;
use axum::response::Response;
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use bytes::Bytes;
use serde_json::{Value, json};

use super::MockVendors;
use super::error_response::{VendorError, json_response};
use super::predictions::mesh_file;
use super::vendor_jobs::VendorJob;

pub(super) async fn send(State(providers): State<Arc<MockVendors>>, body: Bytes) -> Response {
    let begun = async {
        let request: Value = serde_json::from_slice(&body).unwrap_or_default();
        let png = request["image"].as_str().and_then(|text| STANDARD.decode(text).ok());
        let png = png.ok_or_else(|| VendorError::Invalid("**NETWORK ERROR DUE TO HIGH TRAFFIC.**".into()))?;
        let file = mesh_file(&providers.sessions, &png).await?;
        providers.bill.add("hunyuan3d", "send", &body);
        Ok::<_, VendorError>(providers.jobs.begin(file, providers.latency))
    };
    match begun.await {
        Ok(number) => json_response(StatusCode::OK, &json!({ "uid": uid_of(number) })),
        Err(error) => error.hunyuan3d(),
    }
}

pub(super) async fn status(State(providers): State<Arc<MockVendors>>, Path(uid): Path<String>) -> Response {
    let number = uid.rsplit('-').next().and_then(|number| number.parse().ok());
    let message = match number.and_then(|number: u64| providers.jobs.status(number)) {
        Some(VendorJob::Done(file)) => {
            json!({ "status": "completed", "model_base64": STANDARD.encode(&file) })
        }
        _ => json!({ "status": "processing" }),
    };
    json_response(StatusCode::OK, &message)
}

fn uid_of(number: u64) -> String {
    format!("0f1d5a52-5f5c-4c1e-9d0e-{number:012}")
}
