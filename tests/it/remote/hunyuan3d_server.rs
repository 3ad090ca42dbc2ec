//! A server that speaks as Hunyuan3D's `api_server.py` does, written from its source: one mesh for everybody, its habit
//! of saying `processing` about everything it does not know, scripts of faults.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex};

use axum::Router;
use axum::extract::{Path, State};
use axum::response::Response;
use axum::routing::{get, post};
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use bytes::Bytes;
use serde_json::{Value, json};
use tokio::net::TcpListener;
use tokio_util::task::AbortOnDropHandle;

use crate::remote::wire_faults::{Faults, WireFault};

/// Fault that one poll at a job gets in place of the truth.
#[derive(Clone, Debug)]
pub enum PollFault {
    Wire(WireFault),
    /// Half of the file: it is being written.
    HalfWritten,
    /// As 2.1 says that a job failed.
    Error(&'static str),
    /// As 2.1 says that the mesh is being rendered.
    Texturing,
}

/// A running server.
pub struct Hunyuan3dServer {
    pub base_url: String,
    pub submissions: Faults<WireFault>,
    pub polls: Faults<PollFault>,
    state: Arc<Shared>,
    _task: AbortOnDropHandle<()>,
}

struct Shared {
    file: Bytes,
    /// Jobs fail without a message.
    fails: bool,
    submissions: Faults<WireFault>,
    polls: Faults<PollFault>,
    /// Polls so far, by id.
    jobs: Mutex<BTreeMap<String, usize>>,
    max_at_once: Mutex<usize>,
    asked: Mutex<Vec<Value>>,
}

impl Hunyuan3dServer {
    pub async fn start(file: Bytes, fails: bool) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
        let base_url = format!("http://{}", listener.local_addr().unwrap());
        let (submissions, polls) = (Faults::default(), Faults::default());
        let state = Arc::new(Shared {
            file,
            fails,
            submissions: submissions.clone(),
            polls: polls.clone(),
            jobs: Mutex::default(),
            max_at_once: Mutex::default(),
            asked: Mutex::default(),
        });
        let router = Router::new()
            .route("/send", post(send))
            .route("/status/{uid}", get(status))
            .layer(axum::extract::DefaultBodyLimit::max(64 << 20))
            .with_state(state.clone());
        let task = tokio::spawn(async move { axum::serve(listener, router).await.unwrap() });
        Self { base_url, submissions, polls, state, _task: AbortOnDropHandle::new(task) }
    }

    /// Jobs that were begun.
    pub fn begun(&self) -> usize {
        self.state.jobs.lock().unwrap().len()
    }

    /// Most jobs that were not done at the same time.
    pub fn max_at_once(&self) -> usize {
        *self.state.max_at_once.lock().unwrap()
    }

    pub fn asked(&self) -> Vec<Value> {
        self.state.asked.lock().unwrap().clone()
    }
}

/// Polls after which a job is done.
const POLLS: usize = 2;

async fn send(State(state): State<Arc<Shared>>, body: Bytes) -> Response {
    let asked: Value = serde_json::from_slice(&body).unwrap_or_default();
    let image = asked["image"].as_str().and_then(|text| STANDARD.decode(text).ok()).unwrap_or_default();
    let known = [
        "image",
        "seed",
        "octree_resolution",
        "num_inference_steps",
        "guidance_scale",
        "texture",
        "face_count",
        "type",
    ];
    let fields = asked.as_object().into_iter().flat_map(|fields| fields.keys());
    if !image.starts_with(b"\x89PNG") || !fields.into_iter().all(|name| known.contains(&name.as_str())) {
        let message = json!({ "text": "**NETWORK ERROR DUE TO HIGH TRAFFIC.**", "error_code": 1 });
        return answer(404, &message);
    }
    state.asked.lock().unwrap().push(asked);
    let fault = state.submissions.next();
    if let Some(fault) = fault.as_ref().filter(|fault| !fault.is_billed()) {
        return fault.clone().response("application/json", Bytes::new()).await;
    }
    let uid = {
        let mut jobs = state.jobs.lock().unwrap();
        let uid = format!("0f1d5a52-5f5c-4c1e-9d0e-{:012}", jobs.len());
        jobs.insert(uid.clone(), 0);
        let open = jobs.values().filter(|polls| **polls <= POLLS).count();
        let mut highest = state.max_at_once.lock().unwrap();
        *highest = open.max(*highest);
        uid
    };
    let message = json!({ "uid": uid });
    match fault {
        Some(fault) => fault.response("application/json", Bytes::from(message.to_string())).await,
        None => answer(200, &message),
    }
}

async fn status(State(state): State<Arc<Shared>>, Path(uid): Path<String>) -> Response {
    let done = state.jobs.lock().unwrap().get_mut(&uid).is_some_and(|polls| {
        *polls += 1;
        *polls > POLLS && !state.fails
    });
    let completed = |file: &[u8]| json!({ "status": "completed", "model_base64": STANDARD.encode(file) });
    let truth = if done { completed(&state.file) } else { json!({ "status": "processing" }) };
    match state.polls.next() {
        None => answer(200, &truth),
        Some(PollFault::Wire(fault)) => {
            fault.response("application/json", Bytes::from(truth.to_string())).await
        }
        Some(PollFault::HalfWritten) => answer(200, &completed(&state.file[..state.file.len() / 2])),
        Some(PollFault::Error(why)) => answer(200, &json!({ "status": "error", "message": why })),
        Some(PollFault::Texturing) => answer(200, &json!({ "status": "texturing" })),
    }
}

fn answer(status: u16, message: &Value) -> Response {
    Response::builder()
        .status(status)
        .header("content-type", "application/json")
        .body(message.to_string().into())
        .unwrap()
}
