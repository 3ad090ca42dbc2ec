//! A server that speaks Replicate's predictions, written from the published format: it shares no types with the
//! adapter, is strict about requests, makes one mesh for everybody, follows scripts of faults, and keeps a bill.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex};

use axum::Router;
use axum::extract::{Path, Request, State};
use axum::http::StatusCode;
use axum::response::{IntoResponse, Response};
use axum::routing::{get, post};
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use bytes::Bytes;
use serde_json::{Value, json};
use tokio::net::TcpListener;
use tokio_util::task::AbortOnDropHandle;

use crate::remote::wire_faults::{Faults, WireFault};

/// Key that the server accepts.
pub const KEY: &str = "r8_test_0123456789";

/// Fault that one poll at a prediction gets in place of the truth.
#[derive(Clone, Debug)]
pub enum PollFault {
    Wire(WireFault),
    /// Failure with this error.
    Failed(&'static str),
    /// Done, with this output.
    Output(Value),
    /// A prediction that no longer exists.
    Unknown,
}

/// A running server.
pub struct PredictionsServer {
    pub base_url: String,
    pub submissions: Faults<WireFault>,
    pub polls: Faults<PollFault>,
    pub downloads: Faults<WireFault>,
    state: Arc<Shared>,
    _task: AbortOnDropHandle<()>,
}

struct Shared {
    base_url: String,
    file: Bytes,
    /// Polls that find a prediction working.
    polls_until_done: usize,
    submissions: Faults<WireFault>,
    polls: Faults<PollFault>,
    downloads: Faults<WireFault>,
    /// Polls so far, by id; `None` = cancelled.
    predictions: Mutex<BTreeMap<String, Option<usize>>>,
    inputs: Mutex<Vec<Value>>,
    downloaded: Mutex<Vec<Option<String>>>,
}

impl PredictionsServer {
    /// `file` comes of every prediction, at the poll after `polls_until_done`.
    pub async fn start(file: Bytes, polls_until_done: usize) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
        let address = listener.local_addr().unwrap();
        let base_url = format!("http://{address}/v1");
        let (submissions, polls, downloads) = (Faults::default(), Faults::default(), Faults::default());
        let state = Arc::new(Shared {
            base_url: base_url.clone(),
            file,
            polls_until_done,
            submissions: submissions.clone(),
            polls: polls.clone(),
            downloads: downloads.clone(),
            predictions: Mutex::default(),
            inputs: Mutex::default(),
            downloaded: Mutex::default(),
        });
        let router = Router::new()
            .route("/v1/predictions", post(submit))
            .route("/v1/predictions/{id}", get(poll))
            .route("/v1/predictions/{id}/cancel", post(cancel))
            .route("/files/{name}", get(download))
            .layer(axum::extract::DefaultBodyLimit::max(64 << 20))
            .with_state(state.clone());
        let task = tokio::spawn(async move { axum::serve(listener, router).await.unwrap() });
        Self { base_url, submissions, polls, downloads, state, _task: AbortOnDropHandle::new(task) }
    }

    /// Predictions that were begun, and that the vendor asks money for.
    pub fn billed(&self) -> usize {
        self.state.predictions.lock().unwrap().len()
    }

    pub fn cancelled(&self) -> usize {
        self.state.predictions.lock().unwrap().values().filter(|polls| polls.is_none()).count()
    }

    /// Every accepted input, in order.
    pub fn inputs(&self) -> Vec<Value> {
        self.state.inputs.lock().unwrap().clone()
    }

    /// The keys that came with downloads.
    pub fn downloaded(&self) -> Vec<Option<String>> {
        self.state.downloaded.lock().unwrap().clone()
    }
}

fn key_of(request: &Request) -> Option<String> {
    request.headers().get("authorization").map(|value| value.to_str().unwrap().to_owned())
}

fn stranger(request: &Request) -> Option<Response> {
    (key_of(request) != Some(format!("Bearer {KEY}")))
        .then(|| problem(401, "Unauthenticated", "You did not pass a valid authentication token"))
}

async fn submit(State(state): State<Arc<Shared>>, request: Request) -> Response {
    if let Some(refused) = stranger(&request) {
        return refused;
    }
    let body = axum::body::to_bytes(request.into_body(), 64 << 20).await.unwrap();
    let Ok(asked) = serde_json::from_slice::<Value>(&body) else {
        return problem(400, "Bad Request", "the body is no JSON");
    };
    let fields: Vec<&String> = asked.as_object().map(|fields| fields.keys().collect()).unwrap_or_default();
    if fields != ["version", "input"] || asked["version"].as_str().is_none_or(str::is_empty) {
        return problem(422, "Invalid request", "version and input are required");
    }
    let image = asked["input"]["image"].as_str().and_then(|url| url.strip_prefix("data:image/png;base64,"));
    let png = image.and_then(|data| STANDARD.decode(data).ok()).unwrap_or_default();
    if !png.starts_with(b"\x89PNG") {
        return problem(422, "Input validation failed", "- input.image: Does not match format 'uri'");
    }
    state.inputs.lock().unwrap().push(asked["input"].clone());
    let fault = state.submissions.next();
    if let Some(fault) = fault.as_ref().filter(|fault| !fault.is_billed()) {
        return fault.clone().response("application/json", Bytes::new()).await;
    }
    let id = {
        let mut predictions = state.predictions.lock().unwrap();
        let id = format!("gm3qorzdhgbfurvjtvhg6dck{:02}", predictions.len());
        predictions.insert(id.clone(), Some(0));
        id
    };
    let body = Bytes::from(prediction(&state, &id, "starting", Value::Null, Value::Null).to_string());
    match fault {
        Some(fault) => fault.response("application/json", body).await,
        None => (StatusCode::CREATED, [("content-type", "application/json")], body).into_response(),
    }
}

async fn poll(State(state): State<Arc<Shared>>, Path(id): Path<String>, request: Request) -> Response {
    if let Some(refused) = stranger(&request) {
        return refused;
    }
    let polls = match state.predictions.lock().unwrap().get_mut(&id) {
        Some(Some(polls)) => {
            *polls += 1;
            Some(*polls)
        }
        Some(None) => None,
        None => return problem(404, "Not found", "The requested resource could not be found."),
    };
    let done = || {
        let host = state.base_url.trim_end_matches("/v1");
        json!({ "mesh": format!("{host}/files/{id}.glb") })
    };
    let truth = match polls {
        None => prediction(&state, &id, "canceled", Value::Null, Value::Null),
        Some(polls) if polls <= state.polls_until_done => {
            prediction(&state, &id, "processing", Value::Null, Value::Null)
        }
        Some(_) => prediction(&state, &id, "succeeded", done(), Value::Null),
    };
    let json = |value: Value| {
        Response::builder().header("content-type", "application/json").body(value.to_string().into()).unwrap()
    };
    match state.polls.next() {
        None => json(truth),
        Some(PollFault::Wire(fault)) => {
            fault.response("application/json", Bytes::from(truth.to_string())).await
        }
        Some(PollFault::Failed(why)) => json(prediction(&state, &id, "failed", Value::Null, json!(why))),
        Some(PollFault::Output(output)) => json(prediction(&state, &id, "succeeded", output, Value::Null)),
        Some(PollFault::Unknown) => problem(404, "Not found", "The requested resource could not be found."),
    }
}

async fn cancel(State(state): State<Arc<Shared>>, Path(id): Path<String>, request: Request) -> Response {
    if let Some(refused) = stranger(&request) {
        return refused;
    }
    match state.predictions.lock().unwrap().get_mut(&id) {
        Some(polls) => *polls = None,
        None => return problem(404, "Not found", "The requested resource could not be found."),
    }
    axum::Json(prediction(&state, &id, "canceled", Value::Null, Value::Null)).into_response()
}

async fn download(State(state): State<Arc<Shared>>, request: Request) -> Response {
    state.downloaded.lock().unwrap().push(key_of(&request));
    match state.downloads.next() {
        Some(fault) => fault.response("model/gltf-binary", state.file.clone()).await,
        None => ([("content-type", "model/gltf-binary")], state.file.clone()).into_response(),
    }
}

fn prediction(state: &Shared, id: &str, status: &str, output: Value, error: Value) -> Value {
    let url = format!("{}/predictions/{id}", state.base_url);
    json!({
        "id": id, "model": "tencent/hunyuan3d-2", "version": "5c7d5dc6", "input": {}, "logs": "", "output": output,
        "data_removed": false, "error": error, "status": status, "created_at": "2023-09-08T16:19:34.765994657Z",
        "urls": { "cancel": format!("{url}/cancel"), "get": url },
    })
}

fn problem(status: u16, title: &str, detail: &str) -> Response {
    let body = json!({ "title": title, "detail": detail, "status": status });
    Response::builder()
        .status(status)
        .header("content-type", "application/problem+json")
        .body(body.to_string().into())
        .unwrap()
}
