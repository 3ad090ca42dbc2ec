//! Replicate's predictions under `/v1/predictions`: reconstructs an object image as a GLB file.

use std::sync::Arc;

use axum::extract::{Path, State};
use axum::http::{HeaderMap, StatusCode};
use axum::response::{IntoResponse, Response};
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use bytes::Bytes;
use serde_json::{Value, json};

use super::MockVendors;
use super::error_response::{VendorError, json_response};
use super::image_sessions::ImageSessions;
use super::vendor_jobs::VendorJob;
use imaging::codec::decode_png;
use mesh_io::gltf::write_mesh_glb;

/// Prefix of the number in an id.
const PREFIX: &str = "prediction";

/// The GLB file of the object in a PNG file.
pub(super) async fn mesh_file(sessions: &ImageSessions, png: &[u8]) -> Result<Bytes, VendorError> {
    let image = decode_png(png)
        .map_err(|error| VendorError::Invalid(format!("the image cannot be decoded: {error}")))?;
    let (known, index) = sessions.whole_object(&image).await?;
    let mesh = sessions.mesh(&known.recognized, index).await?;
    Ok(write_mesh_glb(&mesh.snap_to_f32()).into())
}

pub(super) async fn submit(
    State(providers): State<Arc<MockVendors>>,
    headers: HeaderMap,
    body: Bytes,
) -> Response {
    let submitted = async {
        let request: Value = serde_json::from_slice(&body)
            .map_err(|error| VendorError::Invalid(format!("no JSON: {error}")))?;
        if request["version"].as_str().is_none_or(str::is_empty) {
            return Err(VendorError::Invalid("version and input are required".into()));
        }
        let image =
            request["input"]["image"].as_str().and_then(|url| url.strip_prefix("data:image/png;base64,"));
        let png = image.and_then(|data| STANDARD.decode(data).ok());
        let png =
            png.ok_or_else(|| VendorError::Invalid("- input.image: Does not match format 'uri'".into()))?;
        let file = mesh_file(&providers.sessions, &png).await?;
        providers.bill.add("predictions", "predictions", &body);
        Ok(providers.jobs.begin(file, providers.latency))
    };
    match submitted.await {
        Ok(number) => {
            json_response(StatusCode::CREATED, &prediction(number, "starting", Value::Null, &headers))
        }
        Err(error) => error.detail(),
    }
}

pub(super) async fn status(
    State(providers): State<Arc<MockVendors>>,
    Path(id): Path<String>,
    headers: HeaderMap,
) -> Response {
    let Some((number, job)) = job(&providers, &id) else { return unknown() };
    let message = match job {
        VendorJob::Working => prediction(number, "processing", Value::Null, &headers),
        VendorJob::Cancelled => prediction(number, "canceled", Value::Null, &headers),
        VendorJob::Done(_) => {
            let file = file_url(&headers, number);
            prediction(number, "succeeded", json!({ "mesh": file }), &headers)
        }
    };
    json_response(StatusCode::OK, &message)
}

pub(super) async fn cancel(
    State(providers): State<Arc<MockVendors>>,
    Path(id): Path<String>,
    headers: HeaderMap,
) -> Response {
    match number_of(&id).filter(|number| providers.jobs.cancel(*number)) {
        Some(number) => json_response(StatusCode::OK, &prediction(number, "canceled", Value::Null, &headers)),
        None => unknown(),
    }
}

pub(super) async fn download(
    State(providers): State<Arc<MockVendors>>,
    Path(name): Path<String>,
) -> Response {
    match job(&providers, name.trim_end_matches(".glb")) {
        Some((_, VendorJob::Done(file))) => ([("content-type", "model/gltf-binary")], file).into_response(),
        _ => unknown(),
    }
}

fn job(providers: &MockVendors, id: &str) -> Option<(u64, VendorJob)> {
    let number = number_of(id)?;
    Some((number, providers.jobs.status(number)?))
}

fn id_of(number: u64) -> String {
    format!("{PREFIX}{number:08}")
}

fn number_of(id: &str) -> Option<u64> {
    id.strip_prefix(PREFIX)?.parse().ok()
}

fn unknown() -> Response {
    VendorError::NotFound("The requested resource could not be found.".into()).detail()
}

/// URL of a job's file.
pub(super) fn file_url(headers: &HeaderMap, number: u64) -> String {
    format!("{}/files/{}.glb", host(headers), id_of(number))
}

/// Base URL of this server as seen by the client.
fn host(headers: &HeaderMap) -> String {
    let host = headers.get("host").and_then(|host| host.to_str().ok()).unwrap_or("localhost");
    format!("http://{host}")
}

fn prediction(number: u64, status: &str, output: Value, headers: &HeaderMap) -> Value {
    let id = id_of(number);
    let url = format!("{}/v1/predictions/{id}", host(headers));
    json!({
        "id": id, "model": "dev/catalog", "version": "dev", "input": {}, "logs": "", "output": output,
        "data_removed": false, "error": null, "status": status, "created_at": "2023-09-08T16:19:34.765994657Z",
        "urls": { "cancel": format!("{url}/cancel"), "get": url },
    })
}
