//! Tencent Cloud's actions `SubmitHunyuanTo3DProJob` and `QueryHunyuanTo3DProJob`, by a POST to the root. Errors
//! have status 200.

use std::sync::Arc;

use axum::extract::State;
use axum::http::{HeaderMap, StatusCode};
use axum::response::Response;
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use bytes::Bytes;
use serde_json::{Value, json};

use super::MockVendors;
use super::error_response::json_response;
use super::predictions::{file_url, mesh_file};
use super::vendor_jobs::VendorJob;

/// Required headers.
const HEADERS: [&str; 3] = ["x-tc-version", "x-tc-timestamp", "authorization"];

pub(super) async fn act(
    State(providers): State<Arc<MockVendors>>,
    headers: HeaderMap,
    body: Bytes,
) -> Response {
    let header = |name: &str| headers.get(name).and_then(|value| value.to_str().ok()).unwrap_or_default();
    let request: Value = serde_json::from_slice(&body).unwrap_or_default();
    let text = if HEADERS.iter().any(|name| header(name).is_empty()) {
        Err(("MissingParameter", "The request lacks a common parameter.".to_owned()))
    } else if !header("authorization").starts_with("TC3-HMAC-SHA256 Credential=") {
        Err(("AuthFailure.SignatureFailure", "The provided credentials could not be validated.".to_owned()))
    } else {
        match header("x-tc-action") {
            "SubmitHunyuanTo3DProJob" => submit(&providers, &request, &body).await,
            "QueryHunyuanTo3DProJob" => query(&providers, &request, &headers),
            _ => Err(("InvalidAction", "The action is not valid.".to_owned())),
        }
    };
    let mut response =
        text.unwrap_or_else(|(code, message)| json!({ "Error": { "Code": code, "Message": message } }));
    response["RequestId"] = json!("8d4c5a8a-fe58-4be2-bd1d-9a1a9d3e8e63");
    json_response(StatusCode::OK, &json!({ "Response": response }))
}

type Message = Result<Value, (&'static str, String)>;

async fn submit(providers: &MockVendors, request: &Value, body: &Bytes) -> Message {
    if !["3.0", "3.1"].contains(&request["Model"].as_str().unwrap_or("3.0")) {
        return Err(("InvalidParameterValue", "Model is 3.0 or 3.1.".to_owned()));
    }
    let image = request["ImageBase64"].as_str().and_then(|text| STANDARD.decode(text).ok());
    let png =
        image.ok_or(("MissingParameter", "One of ImageBase64, ImageUrl and Prompt is wanted.".to_owned()))?;
    let file = mesh_file(&providers.sessions, &png).await;
    let file = file.map_err(|error| ("FailedOperation", format!("{error:?}")))?;
    providers.bill.add("tencent", "SubmitHunyuanTo3DProJob", body);
    Ok(json!({ "JobId": providers.jobs.begin(file, providers.latency).to_string() }))
}

fn query(providers: &MockVendors, request: &Value, headers: &HeaderMap) -> Message {
    let number = request["JobId"].as_str().and_then(|id| id.parse().ok());
    let job = number.and_then(|number: u64| Some((number, providers.jobs.status(number)?)));
    let (status, files) = match job {
        None => return Err(("ResourceNotFound", "There is no such job.".to_owned())),
        Some((_, VendorJob::Working)) => ("RUN", json!([])),
        Some((_, VendorJob::Cancelled)) => ("FAIL", json!([])),
        Some((number, VendorJob::Done(_))) => {
            ("DONE", json!([{ "Type": "GLB", "Url": file_url(headers, number), "PreviewImageUrl": "" }]))
        }
    };
    Ok(json!({ "Status": status, "ErrorCode": "", "ErrorMessage": "", "ResultFile3Ds": files }))
}
