//! `POST /api/v3/images/generations`, as Ark answers it for Seedream: what was described is painted, a table that is
//! shown is drawn from above, and a thing that shows in part before one color is drawn whole before it. Without `watermark: false` a picture would carry one, which nobody here wants to measure on.

use std::sync::Arc;

use axum::extract::State;
use axum::http::StatusCode;
use axum::response::Response;
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use bytes::Bytes;
use serde_json::{Value, json};

use super::DevProviders;
use super::refusal::{Refusal, answer};
use imaging::Image;
use imaging::codec::{decode_png, encode_png};
use vision::cut_out::{cut_out, laid_on};

pub(super) async fn generate(State(providers): State<Arc<DevProviders>>, body: Bytes) -> Response {
    providers.pause().await;
    match generated(&providers, &body).await {
        Ok(picture) => answer(StatusCode::OK, &painted(&picture)),
        Err(refusal) => refusal.openai(),
    }
}

async fn generated(providers: &DevProviders, body: &Bytes) -> Result<Image, Refusal> {
    let request: Value =
        serde_json::from_slice(body).map_err(|error| Refusal::Wrong(format!("no JSON: {error}")))?;
    let wanted = [("watermark", json!(false)), ("response_format", json!("b64_json"))];
    if wanted.iter().any(|(name, value)| request[name] != *value) {
        return Err(Refusal::Wrong(
            "a picture without a watermark, in the answer, is all there is here".into(),
        ));
    }
    let prompt = request["prompt"].as_str().filter(|prompt| !prompt.is_empty());
    let prompt = prompt.ok_or_else(|| Refusal::Wrong("prompt is missing".into()))?;
    let picture = match request["image"].as_array().map(Vec::as_slice) {
        None => providers.studio.painting(prompt).await?.sight.picture.clone(),
        Some([url]) => providers.studio.top_view(shown(url)?).await?.picture.clone(),
        Some([_, thing]) => redrawn(providers, &shown(thing)?).await?,
        Some(_) => {
            let told = "a table is drawn from above, a thing from its surroundings and its visible pixels";
            return Err(Refusal::Unable(told.into()));
        }
    };
    providers.bill.add("ark", "generations", body);
    Ok(picture)
}

/// The thing whole, before the color that is around its visible pixels.
async fn redrawn(providers: &DevProviders, shown: &Image) -> Result<Image, Refusal> {
    let wrong = || Refusal::Wrong("what is around the visible pixels is not one color".into());
    let visible = cut_out(shown).ok_or_else(wrong)?;
    let [r, g, b, _] = shown.pixel(0, 0);
    Ok(laid_on(&super::images::whole(providers, &visible).await?, [r, g, b]))
}

fn shown(url: &Value) -> Result<Image, Refusal> {
    let data = url.as_str().and_then(|url| url.strip_prefix("data:image/png;base64,"));
    let png = data.and_then(|data| STANDARD.decode(data).ok());
    let png = png.ok_or_else(|| Refusal::Wrong("image must be data URLs of PNG files".into()))?;
    decode_png(&png).map_err(|error| Refusal::Wrong(format!("the picture cannot be decoded: {error}")))
}

fn painted(picture: &Image) -> Value {
    let size = format!("{}x{}", picture.width_px(), picture.height_px());
    json!({
        "model": "doubao-seedream-4-0-250828", "created": 1_757_323_224,
        "data": [{ "b64_json": STANDARD.encode(encode_png(picture)), "size": size }],
        "usage": { "generated_images": 1, "output_tokens": 3888, "total_tokens": 3888 },
    })
}
