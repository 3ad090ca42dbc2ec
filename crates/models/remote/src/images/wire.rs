//! Wire format: requests and responses of `POST {base}/images/generations` and `POST {base}/images/edits`.
//!
//! The literals of the tests are the published examples of OpenAI's API reference.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use bytes::Bytes;
use serde::Deserialize;
use serde_json::{Value, json};

use super::super::endpoint::Reading;
use super::super::failure::{Failure, FailureKind, one_line};
use super::super::multipart::Form;
use super::super::settings::{ImagesSettings, InputFidelity, ReferenceSize};
use http_client::HttpResponse;
use ports::ledger::MicroUsd;

/// Body of a text-to-image request.
pub fn generation(settings: &ImagesSettings, prompt: &str) -> Value {
    json!({
        "model": settings.model, "prompt": prompt, "n": 1, "size": settings.reference_size,
        "quality": settings.quality, "background": "opaque", "output_format": "png",
    })
}

/// The canvas of an edit request.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Canvas {
    /// Square and transparent, for one object.
    Object,
    /// Opaque and of the size of reference images, for a whole table.
    Table,
}

/// Form of an image-to-image request with PNG files.
pub fn edit(settings: &ImagesSettings, canvas: Canvas, prompt: &str, images: &[Bytes]) -> Form {
    let (size, background) = match canvas {
        Canvas::Object => (ReferenceSize::Square.word(), "transparent"),
        Canvas::Table => (settings.reference_size.word(), "opaque"),
    };
    let mut form = Form::default().text("model", &settings.model);
    for (number, png) in images.iter().enumerate() {
        form = form.file("image[]", &format!("{number}.png"), "image/png", png.clone());
    }
    form = form
        .text("prompt", prompt)
        .text("n", "1")
        .text("size", size)
        .text("quality", settings.quality.word())
        .text("background", background)
        .text("output_format", "png");
    match settings.input_fidelity {
        InputFidelity::Unsaid => form,
        InputFidelity::Low => form.text("input_fidelity", "low"),
        InputFidelity::High => form.text("input_fidelity", "high"),
    }
}

/// Maximum cost of a question: a text has at most as many tokens as bytes.
pub fn max_cost(settings: &ImagesSettings, prompt: &str, images: usize) -> MicroUsd {
    let image_tokens = images as f64 * f64::from(settings.image_tokens);
    cost(settings, prompt.len() as f64, image_tokens, f64::from(settings.drawn_tokens))
}

fn cost(settings: &ImagesSettings, text: f64, images: f64, drawn: f64) -> MicroUsd {
    let ImagesSettings { text_usd_per_million, image_usd_per_million, drawn_usd_per_million, .. } = settings;
    let price = text * text_usd_per_million + images * image_usd_per_million + drawn * drawn_usd_per_million;
    MicroUsd::of_usd(price / 1e6)
}

#[derive(Deserialize)]
struct ImageList {
    #[serde(default)]
    data: Vec<Drawing>,
    usage: Option<Usage>,
}

#[derive(Deserialize)]
struct Drawing {
    b64_json: Option<String>,
}

#[derive(Deserialize)]
struct Usage {
    #[serde(default)]
    input_tokens: u64,
    #[serde(default)]
    output_tokens: u64,
    input_tokens_details: Option<InputDetails>,
}

#[derive(Deserialize)]
struct InputDetails {
    #[serde(default)]
    text_tokens: u64,
    #[serde(default)]
    image_tokens: u64,
}

/// Reads a successful response: the file of one image. A URL in its place is not followed.
pub fn read(settings: &ImagesSettings, reply: &HttpResponse) -> Reading<Vec<u8>> {
    let failed = |reason: String| Reading {
        cost: None,
        input_tokens: None,
        output_tokens: None,
        task: None,
        result: Err(Failure::new(FailureKind::BadAnswer, reason)),
    };
    if !reply.content_type.ends_with("json") {
        return failed(format!("it answered with {:?} in place of JSON", one_line(&reply.content_type)));
    }
    let list: ImageList = match serde_json::from_slice(&reply.body) {
        Ok(list) => list,
        Err(error) => return failed(format!("its answer is no list of images: {error}")),
    };
    let usage = list.usage.as_ref();
    let spent = usage.map(|usage| match &usage.input_tokens_details {
        Some(input) => {
            let (text, images) = (input.text_tokens as f64, input.image_tokens as f64);
            cost(settings, text, images, usage.output_tokens as f64)
        }
        // All input is billed at the higher price.
        None => {
            let input = usage.input_tokens as f64;
            cost(settings, input, 0.0, usage.output_tokens as f64).max(cost(
                settings,
                0.0,
                input,
                usage.output_tokens as f64,
            ))
        }
    });
    Reading {
        cost: spent,
        input_tokens: usage.map(|usage| usage.input_tokens),
        output_tokens: usage.map(|usage| usage.output_tokens),
        task: None,
        result: file(list.data),
    }
}

fn file(data: Vec<Drawing>) -> Result<Vec<u8>, Failure> {
    let bad = |reason: String| Failure::new(FailureKind::BadAnswer, reason);
    let drawing = data.into_iter().next().ok_or_else(|| bad("its answer has no image".into()))?;
    let text = drawing.b64_json.ok_or_else(|| bad("its answer has no image in base64".into()))?;
    STANDARD.decode(text).map_err(|error| bad(format!("its image is no base64: {error}")))
}

#[cfg(test)]
mod tests;
