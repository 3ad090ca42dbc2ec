//! `POST /api/v3/images/generations`, as Ark serves Seedream: renders descriptions, renders the top view of a table
//! image, and completes a partly visible object on a uniform background. The request must set `watermark: false`,
//! because a watermark would disturb measurements.

use std::sync::Arc;

use axum::extract::State;
use axum::http::StatusCode;
use axum::response::Response;
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use bytes::Bytes;
use serde_json::{Value, json};

use super::MockVendors;
use super::error_response::{VendorError, json_response};
use imaging::Image;
use imaging::codec::{decode_png, encode_png};
use vision::chroma_key::{composite_over, remove_background};

pub(super) async fn generate(State(providers): State<Arc<MockVendors>>, body: Bytes) -> Response {
    providers.pause().await;
    match generated(&providers, &body).await {
        Ok(image) => json_response(StatusCode::OK, &response(&image)),
        Err(error) => error.openai(),
    }
}

async fn generated(providers: &MockVendors, body: &Bytes) -> Result<Image, VendorError> {
    let request: Value =
        serde_json::from_slice(body).map_err(|error| VendorError::Invalid(format!("no JSON: {error}")))?;
    let wanted = [("watermark", json!(false)), ("response_format", json!("b64_json"))];
    if wanted.iter().any(|(name, value)| request[name] != *value) {
        return Err(VendorError::Invalid(
            "an image without a watermark, in the answer, is all there is here".into(),
        ));
    }
    let prompt = request["prompt"].as_str().filter(|prompt| !prompt.is_empty());
    let prompt = prompt.ok_or_else(|| VendorError::Invalid("prompt is missing".into()))?;
    let image = match request["image"].as_array().map(Vec::as_slice) {
        None => providers.sessions.reference_for_prompt(prompt).await?.recognized.image.clone(),
        Some([url]) => providers.sessions.top_view(shown(url)?).await?.image.clone(),
        Some([_, object]) => complete_object(providers, &shown(object)?).await?,
        Some(_) => {
            let message =
                "a table is drawn from above, an object from its surroundings and its visible pixels";
            return Err(VendorError::Unsupported(message.into()));
        }
    };
    providers.bill.add("ark", "generations", body);
    Ok(image)
}

/// The complete object on the background color of its visible pixels.
async fn complete_object(providers: &MockVendors, shown: &Image) -> Result<Image, VendorError> {
    let invalid = || VendorError::Invalid("what is around the visible pixels is not one color".into());
    let visible = remove_background(shown).ok_or_else(invalid)?;
    let [r, g, b, _] = shown.pixel(0, 0);
    Ok(composite_over(&super::images::complete_object(providers, &visible).await?, [r, g, b]))
}

fn shown(url: &Value) -> Result<Image, VendorError> {
    let data = url.as_str().and_then(|url| url.strip_prefix("data:image/png;base64,"));
    let png = data.and_then(|data| STANDARD.decode(data).ok());
    let png = png.ok_or_else(|| VendorError::Invalid("image must be data URLs of PNG files".into()))?;
    decode_png(&png).map_err(|error| VendorError::Invalid(format!("the image cannot be decoded: {error}")))
}

fn response(image: &Image) -> Value {
    let size = format!("{}x{}", image.width_px(), image.height_px());
    json!({
        "model": "doubao-seedream-4-0-250828", "created": 1_757_323_224,
        "data": [{ "b64_json": STANDARD.encode(encode_png(image)), "size": size }],
        "usage": { "generated_images": 1, "output_tokens": 3888, "total_tokens": 3888 },
    })
}
