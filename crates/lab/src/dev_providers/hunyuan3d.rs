//! `/send` and `/status/{uid}`, as Hunyuan3D's `api_server.py` answers them: whatever it does not know is `processing`.

use std::sync::Arc;

use axum::extract::{Path, State};
use axum::http::StatusCode;
use axum::response::Response;
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use bytes::Bytes;
use serde_json::{Value, json};

use super::DevProviders;
use super::predictions::mesh_file;
use super::refusal::{Refusal, answer};
use super::vendor_jobs::VendorJob;

pub(super) async fn send(State(providers): State<Arc<DevProviders>>, body: Bytes) -> Response {
    let begun = async {
        let request: Value = serde_json::from_slice(&body).unwrap_or_default();
        let png = request["image"].as_str().and_then(|text| STANDARD.decode(text).ok());
        let png = png.ok_or_else(|| Refusal::Wrong("**NETWORK ERROR DUE TO HIGH TRAFFIC.**".into()))?;
        let file = mesh_file(&providers.studio, &png).await?;
        providers.bill.add("hunyuan3d", "send", &body);
        Ok::<_, Refusal>(providers.jobs.begin(file, providers.latency))
    };
    match begun.await {
        Ok(number) => answer(StatusCode::OK, &json!({ "uid": uid_of(number) })),
        Err(refusal) => refusal.hunyuan3d(),
    }
}

pub(super) async fn status(State(providers): State<Arc<DevProviders>>, Path(uid): Path<String>) -> Response {
    let number = uid.rsplit('-').next().and_then(|number| number.parse().ok());
    let told = match number.and_then(|number: u64| providers.jobs.look(number)) {
        Some(VendorJob::Done(file)) => {
            json!({ "status": "completed", "model_base64": STANDARD.encode(&file) })
        }
        _ => json!({ "status": "processing" }),
    };
    answer(StatusCode::OK, &told)
}

fn uid_of(number: u64) -> String {
    format!("0f1d5a52-5f5c-4c1e-9d0e-{number:012}")
}
