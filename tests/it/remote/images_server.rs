//! A server that speaks OpenAI's Images endpoints, written from the published format: it shares no types with the
//! adapter, is strict about requests, follows a script of faults, and keeps a bill.

use std::sync::{Arc, Mutex};

use axum::Router;
use axum::extract::{FromRequest, Multipart, Request, State};
use axum::response::Response;
use axum::routing::post;
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use bytes::Bytes;
use imaging::Image;
use imaging::codec::{decode_png, encode_png};
use serde_json::{Value, json};
use tokio::net::TcpListener;
use tokio_util::task::AbortOnDropHandle;

use crate::remote::wire_faults::{Faults, WireFault};

/// Key that the server accepts.
pub const KEY: &str = "sk-images-0123456789";

/// Fault that one request gets in place of a good answer.
#[derive(Clone, Debug)]
pub enum Fault {
    Wire(WireFault),
    /// A good answer with another file in place of its image.
    File(Bytes),
    /// An address in place of the image.
    Address(&'static str),
    /// The image on a white background.
    Opaque,
    /// An image of something else.
    AnotherObject,
    /// The filter says no.
    Blocked,
}

/// A request that was accepted.
#[derive(Clone, Debug, Default)]
pub struct ImageRequest {
    /// `generations` or `edits`.
    pub what: &'static str,
    /// Fields, without files.
    pub fields: Value,
    pub images: Vec<Image>,
}

/// Draws what is asked for.
pub type Artist = Arc<dyn Fn(&ImageRequest) -> Image + Send + Sync>;

/// A running server.
pub struct ImagesServer {
    pub base_url: String,
    pub faults: Faults<Fault>,
    state: Arc<Shared>,
    _task: AbortOnDropHandle<()>,
}

struct Shared {
    artist: Artist,
    faults: Faults<Fault>,
    asked: Mutex<Vec<ImageRequest>>,
    billed: Mutex<usize>,
}

impl ImagesServer {
    pub async fn start(artist: Artist) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
        let base_url = format!("http://{}/v1", listener.local_addr().unwrap());
        let faults = Faults::default();
        let state = Arc::new(Shared {
            artist,
            faults: faults.clone(),
            asked: Mutex::default(),
            billed: Mutex::default(),
        });
        let router = Router::new()
            .route("/v1/images/generations", post(generate))
            .route("/v1/images/edits", post(edit))
            .layer(axum::extract::DefaultBodyLimit::max(64 << 20))
            .with_state(state.clone());
        let task = tokio::spawn(async move { axum::serve(listener, router).await.unwrap() });
        Self { base_url, faults, state, _task: AbortOnDropHandle::new(task) }
    }

    /// Every accepted request, in order.
    pub fn asked(&self) -> Vec<ImageRequest> {
        self.state.asked.lock().unwrap().clone()
    }

    /// Requests that the server would ask money for.
    pub fn billed(&self) -> usize {
        *self.state.billed.lock().unwrap()
    }
}

async fn generate(State(state): State<Arc<Shared>>, request: Request) -> Response {
    if let Some(refused) = stranger(&request) {
        return refused;
    }
    let body = axum::body::to_bytes(request.into_body(), 1 << 20).await.unwrap();
    let Ok(fields) = serde_json::from_slice::<Value>(&body) else {
        return error("invalid_json", "We could not parse the JSON body of your request.");
    };
    let asked = ImageRequest { what: "generations", fields, images: Vec::new() };
    match check(&asked, &["model", "prompt", "n", "size", "quality", "background", "output_format"]) {
        Ok(()) => answered(&state, asked).await,
        Err(why) => error("invalid_value", &why),
    }
}

async fn edit(State(state): State<Arc<Shared>>, request: Request) -> Response {
    if let Some(refused) = stranger(&request) {
        return refused;
    }
    let mut form = match Multipart::from_request(request, &()).await {
        Ok(form) => form,
        Err(why) => return error("invalid_form", &why.to_string()),
    };
    let mut asked = ImageRequest { what: "edits", fields: json!({}), images: Vec::new() };
    while let Some(field) = form.next_field().await.unwrap() {
        let (name, kind) = (field.name().unwrap().to_owned(), field.content_type().map(str::to_owned));
        let bytes = field.bytes().await.unwrap();
        if name == "image[]" {
            match decode_png(&bytes) {
                Ok(image) if kind.as_deref() == Some("image/png") && bytes.len() < 50_000_000 => {
                    asked.images.push(image);
                }
                _ => return error("invalid_image_file", "Invalid image file or mode for image"),
            }
        } else {
            asked.fields[name] = json!(String::from_utf8(bytes.to_vec()).unwrap());
        }
    }
    let known =
        ["model", "prompt", "n", "size", "quality", "background", "output_format", "input_fidelity", "mask"];
    if asked.images.is_empty() || asked.images.len() > 16 {
        return error("invalid_value", "image: from 1 to 16 images");
    }
    match check(&asked, &known) {
        Ok(()) => answered(&state, asked).await,
        Err(why) => error("invalid_value", &why),
    }
}

/// The rules of the published reference, as far as this program's requests touch them.
fn check(asked: &ImageRequest, known: &[&str]) -> Result<(), String> {
    let fields = asked.fields.as_object().ok_or("no object")?;
    if let Some(name) = fields.keys().find(|name| !known.contains(&name.as_str())) {
        return Err(format!("Unknown parameter: '{name}'."));
    }
    let text = |name: &str| asked.fields[name].as_str().unwrap_or_default();
    if text("prompt").is_empty() || text("prompt").chars().count() > 32_000 {
        return Err("prompt: from 1 to 32000 characters".into());
    }
    let one_of = |name: &str, words: &[&str]| match text(name) {
        "" => Ok(()),
        word if words.contains(&word) => Ok(()),
        word => Err(format!("Invalid value: '{word}' for {name}")),
    };
    one_of("size", &["1024x1024", "1536x1024", "1024x1536", "auto"])?;
    one_of("quality", &["low", "medium", "high", "auto"])?;
    one_of("background", &["transparent", "opaque", "auto"])?;
    one_of("output_format", &["png", "jpeg", "webp"])?;
    one_of("input_fidelity", &["low", "high"])?;
    if text("background") == "transparent" && text("output_format") == "jpeg" {
        return Err("Transparent background is not supported for output_format 'jpeg'.".into());
    }
    if text("model").is_empty() { Err("you must provide a model parameter".into()) } else { Ok(()) }
}

async fn answered(state: &Shared, asked: ImageRequest) -> Response {
    let image = (state.artist)(&asked);
    state.asked.lock().unwrap().push(asked.clone());
    let fault = state.faults.next();
    let billed = match &fault {
        Some(Fault::Wire(fault)) => fault.is_billed(),
        Some(Fault::Blocked) => false,
        _ => true,
    };
    *state.billed.lock().unwrap() += usize::from(billed);
    let json = |body: String| {
        Response::builder().header("content-type", "application/json").body(body.into()).unwrap()
    };
    match fault {
        None => json(drawn(&encode_png(&image))),
        Some(Fault::Wire(fault)) => {
            fault.response("application/json", drawn(&encode_png(&image)).into()).await
        }
        Some(Fault::File(bytes)) => json(drawn(&bytes)),
        Some(Fault::Address(url)) => json(json!({ "created": 1, "data": [{ "url": url }] }).to_string()),
        Some(Fault::Opaque) => {
            let mut opaque = image;
            for pixel in opaque.as_rgba_mut().chunks_exact_mut(4) {
                pixel[3] = 255;
            }
            json(drawn(&encode_png(&opaque)))
        }
        Some(Fault::AnotherObject) => json(drawn(&encode_png(&stick()))),
        Some(Fault::Blocked) => blocked(),
    }
}

/// A thin upright stick.
fn stick() -> Image {
    let mut image = Image::filled(1024, 1024, [0; 4]);
    for y in 100..900 {
        for x in 505..520 {
            image.set_pixel(x, y, [120, 80, 40, 255]);
        }
    }
    image
}

fn drawn(file: &[u8]) -> String {
    json!({
        "created": 1713833628, "data": [{ "b64_json": STANDARD.encode(file) }],
        "usage": {
            "total_tokens": 1500, "input_tokens": 500, "output_tokens": 1000,
            "input_tokens_details": { "text_tokens": 100, "image_tokens": 400 },
        },
    })
    .to_string()
}

fn stranger(request: &Request) -> Option<Response> {
    let given = request.headers().get("authorization").and_then(|value| value.to_str().ok());
    (given != Some(&format!("Bearer {KEY}"))).then(|| {
        let mut response = error("invalid_api_key", "Incorrect API key provided.");
        *response.status_mut() = axum::http::StatusCode::UNAUTHORIZED;
        response
    })
}

fn blocked() -> Response {
    let message = "Your request was rejected by the safety system. safety_violations=[violence].";
    refusal("image_generation_user_error", "moderation_blocked", message)
}

fn error(code: &str, message: &str) -> Response {
    refusal("invalid_request_error", code, message)
}

fn refusal(kind: &str, code: &str, message: &str) -> Response {
    let body = json!({ "error": { "message": message, "type": kind, "param": null, "code": code } });
    Response::builder()
        .status(400)
        .header("content-type", "application/json")
        .body(body.to_string().into())
        .unwrap()
}
