//! A server that speaks Tencent Cloud's Hunyuan3D Pro, written from its API reference: it checks signatures by a
//! reckoning of its own, tells errors inside answers with status 200, makes one file for everybody, follows scripts of
//! faults.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex};
use std::time::{Duration, SystemTime};

use axum::Router;
use axum::extract::{Request, State};
use axum::response::{IntoResponse, Response};
use axum::routing::{get, post};
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use bytes::Bytes;
use serde_json::{Value, json};
use sha2::{Digest, Sha256};
use tokio::net::TcpListener;
use tokio_util::task::AbortOnDropHandle;

use crate::remote::wire_faults::{Faults, WireFault};

/// Id of the client that may ask.
pub const SECRET_ID: &str = "AKIDtest0123456789";
pub const SECRET_KEY: &str = "tc-secret-0123456789";

/// Polls that find a job running.
const POLLS: usize = 2;

/// Fault that one request gets in place of a good answer.
#[derive(Clone, Debug)]
pub enum Fault {
    Wire(WireFault),
    /// An error with this code, status 200.
    Error(&'static str),
    /// The job failed.
    Failed,
}

/// A running server.
pub struct TencentServer {
    pub base_url: String,
    pub submissions: Faults<Fault>,
    pub polls: Faults<Fault>,
    state: Arc<Shared>,
    _task: AbortOnDropHandle<()>,
}

struct Shared {
    host: String,
    kind: &'static str,
    file: Bytes,
    submissions: Faults<Fault>,
    polls: Faults<Fault>,
    /// Polls so far, by id.
    jobs: Mutex<BTreeMap<String, usize>>,
    asked: Mutex<Vec<Value>>,
    /// Headers of downloads that prove who asks.
    proofs: Mutex<Vec<String>>,
}

impl TencentServer {
    /// `file` of this `kind` comes of every job.
    pub async fn start(kind: &'static str, file: Bytes) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
        let host = listener.local_addr().unwrap().to_string();
        let base_url = format!("http://{host}");
        let (submissions, polls) = (Faults::default(), Faults::default());
        let state = Arc::new(Shared {
            host,
            kind,
            file,
            submissions: submissions.clone(),
            polls: polls.clone(),
            jobs: Mutex::default(),
            asked: Mutex::default(),
            proofs: Mutex::default(),
        });
        let router = Router::new()
            .route("/", post(act))
            .route("/file", get(download))
            .layer(axum::extract::DefaultBodyLimit::max(64 << 20))
            .with_state(state.clone());
        let task = tokio::spawn(async move { axum::serve(listener, router).await.unwrap() });
        Self { base_url, submissions, polls, state, _task: AbortOnDropHandle::new(task) }
    }

    /// Jobs that were begun.
    pub fn begun(&self) -> usize {
        self.state.jobs.lock().unwrap().len()
    }

    /// Every accepted submission, in order.
    pub fn asked(&self) -> Vec<Value> {
        self.state.asked.lock().unwrap().clone()
    }

    /// Proofs of identity that downloads carried.
    pub fn proofs(&self) -> Vec<String> {
        self.state.proofs.lock().unwrap().clone()
    }
}

async fn act(State(state): State<Arc<Shared>>, request: Request) -> Response {
    let (parts, body) = request.into_parts();
    let body = axum::body::to_bytes(body, 64 << 20).await.unwrap();
    let header = |name: &str| parts.headers.get(name).map_or("", |value| value.to_str().unwrap()).to_owned();
    if header("x-tc-version") != "2025-05-13" || header("x-tc-region") != "ap-guangzhou" {
        return error("UnsupportedRegion");
    }
    let timestamp: u64 = header("x-tc-timestamp").parse().unwrap_or_default();
    let now = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).unwrap();
    if now.abs_diff(Duration::from_secs(timestamp)) > Duration::from_secs(300) {
        return error("AuthFailure.SignatureExpire");
    }
    let headers =
        [&header("content-type"), &state.host, &header("x-tc-action")].map(|value| value.to_lowercase());
    if header("authorization") != signature(&header("authorization"), &headers, timestamp, &body) {
        return error("AuthFailure.SignatureFailure");
    }
    let asked: Value = serde_json::from_slice(&body).unwrap_or_default();
    match header("x-tc-action").as_str() {
        "SubmitHunyuanTo3DProJob" => submit(&state, asked).await,
        "QueryHunyuanTo3DProJob" => poll(&state, &asked).await,
        _ => error("InvalidAction"),
    }
}

/// Right value of `Authorization`; the day is the one that it names.
fn signature(given: &str, [content_type, host, action]: &[String; 3], timestamp: u64, body: &[u8]) -> String {
    let hex = |bytes: &[u8]| bytes.iter().map(|byte| format!("{byte:02x}")).collect::<String>();
    let day = given.split('/').nth(1).unwrap_or_default();
    let service = host.split([':', '.']).next().unwrap();
    let names = "content-type;host;x-tc-action";
    let canonical = format!(
        "POST\n/\n\ncontent-type:{content_type}\nhost:{host}\nx-tc-action:{action}\n\n{names}\n{}",
        hex(&Sha256::digest(body))
    );
    let scope = format!("{day}/{service}/tc3_request");
    let text = format!("TC3-HMAC-SHA256\n{timestamp}\n{scope}\n{}", hex(&Sha256::digest(canonical)));
    let mut key = format!("TC3{SECRET_KEY}").into_bytes();
    for part in [day, service, "tc3_request"] {
        key = keyed(&key, part.as_bytes());
    }
    format!(
        "TC3-HMAC-SHA256 Credential={SECRET_ID}/{scope}, SignedHeaders={names}, Signature={}",
        hex(&keyed(&key, text.as_bytes()))
    )
}

/// HMAC-SHA256 with a key shorter than a block.
fn keyed(key: &[u8], text: &[u8]) -> Vec<u8> {
    let pad = |with: u8| (0..64).map(|at| key.get(at).copied().unwrap_or(0) ^ with).collect::<Vec<u8>>();
    let inner = Sha256::digest([&pad(0x36)[..], text].concat());
    Sha256::digest([&pad(0x5c)[..], &inner[..]].concat()).to_vec()
}

async fn submit(state: &Shared, asked: Value) -> Response {
    let image = asked["ImageBase64"].as_str().and_then(|text| STANDARD.decode(text).ok()).unwrap_or_default();
    let faces = asked["FaceCount"].as_u64().unwrap_or_default();
    if !image.starts_with(b"\x89PNG") || !(40_000..=1_500_000).contains(&faces) {
        return error("InvalidParameterValue");
    }
    state.asked.lock().unwrap().push(asked);
    let fault = state.submissions.next();
    match &fault {
        Some(Fault::Error(code)) => return error(code),
        Some(Fault::Wire(wire)) if !wire.is_billed() => {
            return wire.clone().response("application/json", Bytes::new()).await;
        }
        _ => {}
    }
    let id = {
        let mut jobs = state.jobs.lock().unwrap();
        let id = format!("13753677555196968{:02}", jobs.len());
        jobs.insert(id.clone(), 0);
        id
    };
    let message = json!({ "Response": { "JobId": id, "RequestId": "173f8c3f-d326-4e0e-b9d0-7a5c4ed0fcb0" } });
    answered(fault, &message).await
}

async fn poll(state: &Shared, asked: &Value) -> Response {
    let polls = {
        let mut jobs = state.jobs.lock().unwrap();
        let Some(polls) = asked["JobId"].as_str().and_then(|id| jobs.get_mut(id)) else {
            return error("ResourceNotFound");
        };
        *polls += 1;
        *polls
    };
    let fault = state.polls.next();
    let url = format!("http://{}/file?q-sign-algorithm=sha1&q-signature=f00", state.host);
    let files = json!([{ "Type": state.kind, "Url": url, "PreviewImageUrl": "https://a.example/b.png" }]);
    let (status, files) = match (&fault, polls > POLLS) {
        (Some(Fault::Failed), _) => ("FAIL", json!([])),
        (_, true) => ("DONE", files),
        (_, false) => (if polls == 1 { "WAIT" } else { "RUN" }, json!([])),
    };
    if let Some(Fault::Error(code)) = fault {
        return error(code);
    }
    let message = json!({
        "Response": {
            "Status": status, "ErrorCode": if status == "FAIL" { "FailedOperation.ModelError" } else { "" },
            "ErrorMessage": "", "ResultFile3Ds": files, "RequestId": "8d4c5a8a-fe58-4be2-bd1d-9a1a9d3e8e63",
        },
    });
    answered(fault, &message).await
}

async fn answered(fault: Option<Fault>, message: &Value) -> Response {
    match fault {
        Some(Fault::Wire(wire)) => wire.response("application/json", message.to_string().into()).await,
        _ => axum::Json(message).into_response(),
    }
}

async fn download(State(state): State<Arc<Shared>>, request: Request) -> Response {
    let proofs = ["authorization", "x-tc-timestamp", "x-tc-action"];
    let given = proofs.iter().filter_map(|name| request.headers().get(*name));
    state.proofs.lock().unwrap().extend(given.map(|value| value.to_str().unwrap().to_owned()));
    state.file.clone().into_response()
}

fn error(code: &str) -> Response {
    let error = json!({ "Code": code, "Message": "The request was not served." });
    let message =
        json!({ "Response": { "Error": error, "RequestId": "ed93f3cb-f35e-473f-b9f3-0d451b8b79c6" } });
    axum::Json(message).into_response()
}
