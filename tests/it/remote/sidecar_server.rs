//! A server that speaks the protocol of `docs/segmentation-sidecar.yaml`: it shares no types with the adapter, is
//! strict about requests, finds the objects that the test declares, and follows a script of faults.

use std::sync::{Arc, Mutex};

use axum::Router;
use axum::extract::{Multipart, State};
use axum::response::Response;
use axum::routing::post;
use bytes::Bytes;
use imaging::codec::decode_png;
use imaging::mask::compressed;
use imaging::{Image, Mask};
use serde_json::{Value, json};
use tokio::net::TcpListener;
use tokio_util::task::AbortOnDropHandle;

use crate::remote::wire_faults::{Faults, WireFault};

/// Fault that one request gets in place of a good answer.
#[derive(Clone, Debug)]
pub enum Fault {
    Wire(WireFault),
    /// The answer with this value in place of the one at the pointer.
    Spoiled(&'static str, Value),
    /// Labels come back as word pieces.
    Pieces,
    /// Nothing is found.
    Blind,
}

/// Something on the image, as the server finds it.
#[derive(Clone, Debug)]
pub struct OnImage {
    pub label: &'static str,
    pub score: f64,
    pub mask: Mask,
}

/// A running server.
pub struct SidecarServer {
    pub base_url: String,
    pub faults: Faults<Fault>,
    state: Arc<Shared>,
    _task: AbortOnDropHandle<()>,
}

struct Shared {
    objects: Vec<OnImage>,
    faults: Faults<Fault>,
    asked: Mutex<Vec<(Value, Image)>>,
}

impl SidecarServer {
    pub async fn start(objects: Vec<OnImage>) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
        let base_url = format!("http://{}", listener.local_addr().unwrap());
        let faults = Faults::default();
        let state = Arc::new(Shared { objects, faults: faults.clone(), asked: Mutex::default() });
        let router = Router::new().route("/v1/segment", post(segment)).with_state(state.clone());
        let task = tokio::spawn(async move { axum::serve(listener, router).await.unwrap() });
        Self { base_url, faults, state, _task: AbortOnDropHandle::new(task) }
    }

    /// Every accepted request, in order: what was asked about which image.
    pub fn asked(&self) -> Vec<(Value, Image)> {
        self.state.asked.lock().unwrap().clone()
    }
}

async fn segment(State(state): State<Arc<Shared>>, mut form: Multipart) -> Response {
    let (mut image, mut request) = (None, None);
    while let Some(field) = form.next_field().await.unwrap() {
        let name = field.name().unwrap().to_owned();
        let bytes: Bytes = field.bytes().await.unwrap();
        match name.as_str() {
            "image" => image = decode_png(&bytes).ok(),
            "request" => request = serde_json::from_slice::<Value>(&bytes).ok(),
            other => return error(&format!("unknown field {other}")),
        }
    }
    let (Some(image), Some(request)) = (image, request) else {
        return error("image and request are required");
    };
    let Some(labels) = request["labels"].as_array().filter(|labels| !labels.is_empty()) else {
        return error("labels are required");
    };
    let plain = |label: &Value| {
        let label = label.as_str().unwrap_or_default();
        !label.is_empty() && label.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == ' ')
    };
    let threshold = request["box_threshold"].as_f64().filter(|score| (0.0..=1.0).contains(score));
    let (true, Some(threshold), Some(_)) =
        (labels.iter().all(plain), threshold, request["text_threshold"].as_f64())
    else {
        return error("labels are plain words, thresholds numbers");
    };
    state.asked.lock().unwrap().push((request.clone(), image.clone()));
    let size = [image.height_px(), image.width_px()];
    let fault = state.faults.next();
    let found = state.objects.iter().filter(|object| {
        object.score >= threshold
            && labels.contains(&json!(object.label))
            && !matches!(fault, Some(Fault::Blind))
    });
    let annotations: Vec<Value> = found
        .map(|object| {
            let name = match &fault {
                Some(Fault::Pieces) => format!("##{}", &object.label[1..]),
                _ => object.label.to_owned(),
            };
            json!({
                "class_name": name, "score": object.score, "bbox": object.mask.bbox_px().unwrap(),
                "segmentation": { "size": size, "counts": compressed(&object.mask) },
            })
        })
        .collect();
    let mut answer = json!({ "img_width": size[1], "img_height": size[0], "annotations": annotations });
    if let Some(Fault::Spoiled(pointer, value)) = &fault {
        *answer.pointer_mut(pointer).expect(pointer) = value.clone();
    }
    let body = Bytes::from(answer.to_string());
    match fault {
        Some(Fault::Wire(fault)) => fault.response("application/json", body).await,
        _ => Response::builder().header("content-type", "application/json").body(body.into()).unwrap(),
    }
}

fn error(detail: &str) -> Response {
    Response::builder()
        .status(422)
        .header("content-type", "application/json")
        .body(json!({ "detail": detail }).to_string().into())
        .unwrap()
}
