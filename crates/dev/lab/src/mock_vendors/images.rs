//! `POST /v1/images/generations` and `/v1/images/edits`: renders descriptions, completes partly visible objects,
//! and renders top views.

use std::sync::Arc;

use axum::extract::{FromRequest, Multipart, Request, State};
use axum::http::StatusCode;
use axum::response::Response;
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use bytes::Bytes;
use serde_json::{Value, json};

use super::MockVendors;
use super::error_response::{VendorError, json_response};
use super::recognized_image::RecognizedImage;
use imaging::codec::{decode_png, encode_png};
use imaging::{Image, Mask};
use ports::Completion;

/// Side of the generated images, pixels.
const GENERATED_PX: u32 = 1024;

pub(super) async fn generate(State(providers): State<Arc<MockVendors>>, body: Bytes) -> Response {
    providers.pause().await;
    let response = async {
        let request: Value = serde_json::from_slice(&body)
            .map_err(|error| VendorError::Invalid(format!("no JSON: {error}")))?;
        let prompt = request["prompt"].as_str().filter(|prompt| !prompt.is_empty());
        let prompt =
            prompt.ok_or_else(|| VendorError::Invalid("prompt: from 1 to 32000 characters".into()))?;
        let known = providers.sessions.reference_for_prompt(prompt).await?;
        providers.bill.add("images", "generations", &body);
        Ok(image_response(&known.recognized.image))
    };
    response.await.unwrap_or_else(VendorError::openai)
}

pub(super) async fn edit(State(providers): State<Arc<MockVendors>>, request: Request) -> Response {
    providers.pause().await;
    let response = async {
        let mut form = Multipart::from_request(request, &())
            .await
            .map_err(|error| VendorError::Invalid(format!("no form: {error}")))?;
        let mut files: Vec<Bytes> = Vec::new();
        let invalid =
            |error: axum::extract::multipart::MultipartError| VendorError::Invalid(error.to_string());
        while let Some(field) = form.next_field().await.map_err(invalid)? {
            if field.name() == Some("image[]") {
                files.push(field.bytes().await.map_err(invalid)?);
            }
        }
        let decoded = |file: &Bytes| {
            decode_png(file).map_err(|error| {
                VendorError::Invalid(format!("Invalid image file or mode for image: {error}"))
            })
        };
        if let [table] = &files[..] {
            let image = decoded(table)?;
            providers.bill.add("images", "edits", table);
            if providers.takes_invalid_top_view() {
                return Ok(image_response(&image));
            }
            return Ok(image_response(&providers.sessions.top_view(image).await?.image));
        }
        let [_, cut_out] = &files[..] else {
            return Err(VendorError::Invalid(
                "an object is redrawn from its surroundings and its visible pixels".into(),
            ));
        };
        let image = complete_object(providers.as_ref(), &decoded(cut_out)?).await?;
        providers.bill.add("images", "edits", &files.concat());
        Ok(image_response(&image))
    };
    response.await.unwrap_or_else(VendorError::openai)
}

/// The object with those visible pixels, alone and complete in the same frame.
pub(super) async fn complete_object(providers: &MockVendors, visible: &Image) -> Result<Image, VendorError> {
    let (known, index) = providers.sessions.visible_object(visible).await?;
    complete_in_frame(&known.recognized, index, visible)
        .ok_or_else(|| VendorError::Unsupported("nothing shows of it".into()))
}

/// The object alone and complete, in the frame of the image that shows its visible pixels.
fn complete_in_frame(recognized: &RecognizedImage, index: usize, visible: &Image) -> Option<Image> {
    let solid = |x, y| visible.pixel(x, y)[3] >= 128;
    let in_frame = Mask::from_fn(visible.width_px(), visible.height_px(), solid).bbox_px()?.map(f64::from);
    let in_image = recognized.masks[index].visible.bbox_px()?.map(f64::from);
    // Image pixels per frame pixel, by the longer side, which is the most precise.
    let longer = |[x0, y0, x1, y1]: [f64; 4]| (x1 - x0).max(y1 - y0);
    let scale = longer(in_image) / longer(in_frame);
    let center = |low: f64, high: f64| 0.5 * (low + high);
    let left = center(in_image[0], in_image[2]) - scale * center(in_frame[0], in_frame[2]);
    let top = center(in_image[1], in_image[3]) - scale * center(in_frame[1], in_frame[3]);
    let frame_px = f64::from(visible.width_px().max(visible.height_px()));
    let step = scale * frame_px / f64::from(GENERATED_PX);
    let mut drawing = Image::filled(GENERATED_PX, GENERATED_PX, [0; 4]);
    for v in 0..GENERATED_PX {
        for u in 0..GENERATED_PX {
            let (x, y) = (left + (f64::from(u) + 0.5) * step, top + (f64::from(v) + 0.5) * step);
            drawing.set_pixel(u, v, sampled(&recognized.alone[index], x, y));
        }
    }
    Some(drawing)
}

/// A completion at a position of its source image; transparent outside.
fn sampled(alone: &Completion, x: f64, y: f64) -> [u8; 4] {
    let [x0, y0, x1, y1] = alone.crop_px;
    let (u, v) = ((x - x0) / (x1 - x0), (y - y0) / (y1 - y0));
    if !(0.0..1.0).contains(&u) || !(0.0..1.0).contains(&v) {
        return [0; 4];
    }
    let image = &alone.image;
    let at = |share: f64, length: u32| ((share * f64::from(length)) as u32).min(length - 1);
    let pixel = image.pixel(at(u, image.width_px()), at(v, image.height_px()));
    if pixel[3] >= 128 { pixel } else { [0; 4] }
}

fn image_response(image: &Image) -> Response {
    let usage = json!({
        "total_tokens": 5000, "input_tokens": 1000, "output_tokens": 4000,
        "input_tokens_details": { "text_tokens": 500, "image_tokens": 500 },
    });
    let data = [json!({ "b64_json": STANDARD.encode(encode_png(image)) })];
    json_response(StatusCode::OK, &json!({ "created": 1_713_833_628, "data": data, "usage": usage }))
}
