//! A server that speaks Ark's image generation for Seedream 4.0 and later, written from the published format:
//! it shares no types with the adapter, is strict about requests, follows a script of faults, and keeps a
//! bill.

use std::sync::{Arc, Mutex};

use axum::Router;
use axum::extract::{Request, State};
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
pub const KEY: &str = "ark-0123456789";

/// Fault that one request gets in place of a good answer.
#[derive(Clone, Debug)]
pub enum Fault {
    Wire(WireFault),
    /// The image's own error, with status 200, and nothing to pay for it.
    NoImage(&'static str),
    /// An address in place of the image, as where `b64_json` is not asked for.
    Address(&'static str),
    /// Another file in place of the image.
    File(Bytes),
}

/// A running server.
pub struct ArkServer {
    pub base_url: String,
    pub faults: Faults<Fault>,
    state: Arc<Shared>,
    _task: AbortOnDropHandle<()>,
}

#[derive(Default)]
struct Shared {
    faults: Faults<Fault>,
    asked: Mutex<Vec<(Value, Vec<Image>)>>,
    billed: Mutex<usize>,
}

impl ArkServer {
    pub async fn start() -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
        let base_url = format!("http://{}/api/v3", listener.local_addr().unwrap());
        let faults = Faults::default();
        let state = Arc::new(Shared { faults: faults.clone(), ..Shared::default() });
        let router = Router::new()
            .route("/api/v3/images/generations", post(generate))
            .layer(axum::extract::DefaultBodyLimit::max(64 << 20))
            .with_state(state.clone());
        let task = tokio::spawn(async move { axum::serve(listener, router).await.unwrap() });
        Self { base_url, faults, state, _task: AbortOnDropHandle::new(task) }
    }

    /// Every accepted request with its images, in order.
    pub fn asked(&self) -> Vec<(Value, Vec<Image>)> {
        self.state.asked.lock().unwrap().clone()
    }

    /// Images that the server would ask money for.
    pub fn billed(&self) -> usize {
        *self.state.billed.lock().unwrap()
    }
}

async fn generate(State(state): State<Arc<Shared>>, request: Request) -> Response {
    let given = request.headers().get("authorization").and_then(|value| value.to_str().ok());
    if given != Some(&format!("Bearer {KEY}")) {
        return error(401, "AuthenticationError", "the API key in the request is missing or invalid");
    }
    let body = axum::body::to_bytes(request.into_body(), 64 << 20).await.unwrap();
    let Ok(asked) = serde_json::from_slice::<Value>(&body) else {
        return error(400, "InvalidParameter", "the request is no JSON");
    };
    let images = match check(&asked) {
        Ok(images) => images,
        Err(why) => return error(400, "InvalidParameter", &why),
    };
    // Watermarks are the default.
    let stamped = asked["watermark"] != false;
    state.asked.lock().unwrap().push((asked, images.clone()));
    let fault = state.faults.next();
    let billed = match &fault {
        Some(Fault::Wire(fault)) => fault.is_billed(),
        Some(Fault::NoImage(_)) => false,
        _ => true,
    };
    *state.billed.lock().unwrap() += usize::from(billed);
    let answer = |data: Value, images: u32| {
        let answer = json!({
            "model": "doubao-seedream-4-0-250828", "created": 1757323224, "data": [data],
            "usage": { "generated_images": images, "output_tokens": 3888 * images, "total_tokens": 3888 * images },
        });
        answer.to_string()
    };
    let mut image = match &images[..] {
        [_, object] => whole_disk(object),
        _ => Image::filled(1152, 864, [120, 100, 80, 255]),
    };
    if stamped {
        (1000..1152).for_each(|x| (820..864).for_each(|y| image.set_pixel(x, y, [255; 4])));
    }
    let drawn = |file: &[u8]| json!({ "b64_json": STANDARD.encode(file), "size": "1152x864" });
    let body = match &fault {
        None | Some(Fault::Wire(_)) => answer(drawn(&encode_png(&image)), 1),
        Some(Fault::NoImage(code)) => {
            answer(json!({ "error": { "code": code, "message": "The request failed." } }), 0)
        }
        Some(Fault::Address(url)) => answer(json!({ "url": url, "size": "1152x864" }), 1),
        Some(Fault::File(file)) => answer(drawn(file), 1),
    };
    match fault {
        Some(Fault::Wire(fault)) => fault.response("application/json", body.into()).await,
        _ => Response::builder().header("content-type", "application/json").body(body.into()).unwrap(),
    }
}

/// A disk of what was shown of it, elsewhere in the frame and larger than it was, before the color that was around it.
fn whole_disk(shown: &Image) -> Image {
    let around = shown.pixel(0, 0);
    let pixels = (0..shown.height_px()).flat_map(|y| (0..shown.width_px()).map(move |x| (x, y)));
    let color = pixels.map(|(x, y)| shown.pixel(x, y)).find(|color| *color != around).unwrap_or(around);
    let mut drawing = Image::filled(1024, 1024, around);
    for y in 0..1024_u32 {
        for x in 0..1024_u32 {
            if (f64::from(x) - 560.0).hypot(f64::from(y) - 470.0) < 330.0 {
                drawing.set_pixel(x, y, color);
            }
        }
    }
    drawing
}

/// The rules of the published reference, as far as this program's requests touch them; the images that were
/// sent.
fn check(asked: &Value) -> Result<Vec<Image>, String> {
    let known = [
        "model",
        "prompt",
        "image",
        "size",
        "sequential_image_generation",
        "response_format",
        "watermark",
        "stream",
    ];
    for name in asked.as_object().ok_or("no object")?.keys() {
        if !known.contains(&name.as_str()) {
            return Err(format!("unknown parameter {name}"));
        }
    }
    let text = |name: &str| asked[name].as_str().unwrap_or_default();
    if text("model").is_empty() || text("prompt").is_empty() {
        return Err("model and prompt are required".into());
    }
    let sides: Vec<u32> = text("size").split('x').filter_map(|side| side.parse().ok()).collect();
    let fine = match sides[..] {
        [width, height] => {
            let shape = f64::from(width) / f64::from(height);
            let pixels = u64::from(width) * u64::from(height);
            (1.0 / 16.0..=16.0).contains(&shape) && (921_600..=16_777_216).contains(&pixels)
        }
        _ => ["1K", "2K", "4K"].contains(&text("size")),
    };
    if !fine {
        return Err(format!("size {}", asked["size"]));
    }
    if text("response_format") != "b64_json" || asked["stream"] == true {
        return Err("this server sends images in one answer".into());
    }
    let images = match &asked["image"] {
        Value::Null => Vec::new(),
        Value::String(url) => vec![url.clone()],
        Value::Array(urls) => urls.iter().filter_map(|url| url.as_str().map(str::to_owned)).collect(),
        _ => return Err("image must be a text or a list".into()),
    };
    if images.len() > 14 {
        return Err("at most 14 images".into());
    }
    let decoded = images.iter().map(|url| {
        let data =
            url.strip_prefix("data:image/png;base64,").ok_or("only data URLs of PNG files are read here")?;
        let file = STANDARD.decode(data).map_err(|error| error.to_string())?;
        decode_png(&file).map_err(|error| error.to_string())
    });
    decoded.collect()
}

fn error(status: u16, code: &str, message: &str) -> Response {
    let body = json!({ "error": { "code": code, "message": message, "param": "", "type": "BadRequest" } });
    Response::builder()
        .status(status)
        .header("content-type", "application/json")
        .body(body.to_string().into())
        .unwrap()
}
