//! `POST /v1/images/generations` and `/v1/images/edits`: what was described is painted; a thing that shows in part is drawn
//! whole, and a table from above.

use std::sync::Arc;

use axum::extract::{FromRequest, Multipart, Request, State};
use axum::http::StatusCode;
use axum::response::Response;
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use bytes::Bytes;
use serde_json::{Value, json};

use super::DevProviders;
use super::refusal::{Refusal, answer};
use super::sight::Sight;
use imaging::codec::{decode_png, encode_png};
use imaging::{Image, Mask};
use ports::Completion;

/// Side of what is drawn, pixels.
const DRAWN_PX: u32 = 1024;

pub(super) async fn generate(State(providers): State<Arc<DevProviders>>, body: Bytes) -> Response {
    providers.pause().await;
    let painted = async {
        let request: Value =
            serde_json::from_slice(&body).map_err(|error| Refusal::Wrong(format!("no JSON: {error}")))?;
        let prompt = request["prompt"].as_str().filter(|prompt| !prompt.is_empty());
        let prompt = prompt.ok_or_else(|| Refusal::Wrong("prompt: from 1 to 32000 characters".into()))?;
        let known = providers.studio.painting(prompt).await?;
        providers.bill.add("images", "generations", &body);
        Ok(drawn(&known.sight.picture))
    };
    painted.await.unwrap_or_else(Refusal::openai)
}

pub(super) async fn edit(State(providers): State<Arc<DevProviders>>, request: Request) -> Response {
    providers.pause().await;
    let redrawn = async {
        let mut form = Multipart::from_request(request, &())
            .await
            .map_err(|error| Refusal::Wrong(format!("no form: {error}")))?;
        let mut files: Vec<Bytes> = Vec::new();
        let wrong = |error: axum::extract::multipart::MultipartError| Refusal::Wrong(error.to_string());
        while let Some(field) = form.next_field().await.map_err(wrong)? {
            if field.name() == Some("image[]") {
                files.push(field.bytes().await.map_err(wrong)?);
            }
        }
        let decoded = |file: &Bytes| {
            decode_png(file)
                .map_err(|error| Refusal::Wrong(format!("Invalid image file or mode for image: {error}")))
        };
        if let [table] = &files[..] {
            let picture = decoded(table)?;
            providers.bill.add("images", "edits", table);
            if providers.spoils_a_top_view() {
                return Ok(drawn(&picture));
            }
            return Ok(drawn(&providers.studio.top_view(picture).await?.picture));
        }
        let [_, cut_out] = &files[..] else {
            return Err(Refusal::Wrong(
                "a thing is redrawn from its surroundings and its visible pixels".into(),
            ));
        };
        let picture = whole(providers.as_ref(), &decoded(cut_out)?).await?;
        providers.bill.add("images", "edits", &files.concat());
        Ok(drawn(&picture))
    };
    redrawn.await.unwrap_or_else(Refusal::openai)
}

/// The thing of which those pixels are visible, alone and whole in the same frame.
pub(super) async fn whole(providers: &DevProviders, visible: &Image) -> Result<Image, Refusal> {
    let (known, index) = providers.studio.visible_thing(visible).await?;
    redrawn(&known.sight, index, visible).ok_or_else(|| Refusal::Unable("nothing shows of it".into()))
}

/// The thing alone and whole, in the frame of the picture that shows its visible pixels.
fn redrawn(sight: &Sight, index: usize, visible: &Image) -> Option<Image> {
    let solid = |x, y| visible.pixel(x, y)[3] >= 128;
    let in_frame = Mask::from_fn(visible.width_px(), visible.height_px(), solid).bbox_px()?.map(f64::from);
    let in_picture = sight.masks[index].visible.bbox_px()?.map(f64::from);
    // Pixels of the picture a pixel of the frame, by the longer side, which is known best.
    let longer = |[x0, y0, x1, y1]: [f64; 4]| (x1 - x0).max(y1 - y0);
    let scale = longer(in_picture) / longer(in_frame);
    let middle = |low: f64, high: f64| 0.5 * (low + high);
    let left = middle(in_picture[0], in_picture[2]) - scale * middle(in_frame[0], in_frame[2]);
    let top = middle(in_picture[1], in_picture[3]) - scale * middle(in_frame[1], in_frame[3]);
    let frame_px = f64::from(visible.width_px().max(visible.height_px()));
    let step = scale * frame_px / f64::from(DRAWN_PX);
    let mut drawing = Image::filled(DRAWN_PX, DRAWN_PX, [0; 4]);
    for v in 0..DRAWN_PX {
        for u in 0..DRAWN_PX {
            let (x, y) = (left + (f64::from(u) + 0.5) * step, top + (f64::from(v) + 0.5) * step);
            drawing.set_pixel(u, v, sampled(&sight.alone[index], x, y));
        }
    }
    Some(drawing)
}

/// A completion at a place of the picture it belongs to; transparent outside.
fn sampled(alone: &Completion, x: f64, y: f64) -> [u8; 4] {
    let [x0, y0, x1, y1] = alone.shown_px;
    let (u, v) = ((x - x0) / (x1 - x0), (y - y0) / (y1 - y0));
    if !(0.0..1.0).contains(&u) || !(0.0..1.0).contains(&v) {
        return [0; 4];
    }
    let picture = &alone.picture;
    let at = |share: f64, length: u32| ((share * f64::from(length)) as u32).min(length - 1);
    let pixel = picture.pixel(at(u, picture.width_px()), at(v, picture.height_px()));
    if pixel[3] >= 128 { pixel } else { [0; 4] }
}

fn drawn(picture: &Image) -> Response {
    let usage = json!({
        "total_tokens": 5000, "input_tokens": 1000, "output_tokens": 4000,
        "input_tokens_details": { "text_tokens": 500, "image_tokens": 500 },
    });
    let data = [json!({ "b64_json": STANDARD.encode(encode_png(picture)) })];
    answer(StatusCode::OK, &json!({ "created": 1_713_833_628, "data": data, "usage": usage }))
}
