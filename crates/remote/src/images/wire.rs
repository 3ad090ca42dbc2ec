//! What is on the wire: requests and answers of `POST {base}/images/generations` and `POST {base}/images/edits`.
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
use super::super::outbound::Reply;
use super::super::settings::{ImagesSettings, InputFidelity, ReferenceSize};
use ports::ledger::MicroUsd;

/// Body of a request to paint something from words.
pub fn generation(settings: &ImagesSettings, prompt: &str) -> Value {
    json!({
        "model": settings.model, "prompt": prompt, "n": 1, "size": settings.reference_size,
        "quality": settings.quality, "background": "opaque", "output_format": "png",
    })
}

/// What is drawn on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Canvas {
    /// Square and transparent, for one thing.
    Thing,
    /// As reference pictures are, opaque, for a whole table.
    Table,
}

/// Form of a request to draw something from PNG files.
pub fn edit(settings: &ImagesSettings, canvas: Canvas, prompt: &str, pictures: &[Bytes]) -> Form {
    let (size, background) = match canvas {
        Canvas::Thing => (ReferenceSize::Square.word(), "transparent"),
        Canvas::Table => (settings.reference_size.word(), "opaque"),
    };
    let mut form = Form::default().text("model", &settings.model);
    for (number, png) in pictures.iter().enumerate() {
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

/// The most that a question can cost: no text has more tokens than bytes.
pub fn most_it_can_cost(settings: &ImagesSettings, prompt: &str, pictures: usize) -> MicroUsd {
    let picture_tokens = pictures as f64 * f64::from(settings.picture_tokens);
    cost(settings, prompt.len() as f64, picture_tokens, f64::from(settings.drawn_tokens))
}

fn cost(settings: &ImagesSettings, text: f64, pictures: f64, drawn: f64) -> MicroUsd {
    let ImagesSettings { text_usd_per_million, picture_usd_per_million, drawn_usd_per_million, .. } =
        settings;
    let price =
        text * text_usd_per_million + pictures * picture_usd_per_million + drawn * drawn_usd_per_million;
    MicroUsd::of_usd(price / 1e6)
}

#[derive(Deserialize)]
struct Drawn {
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

/// Reads a successful answer: the bytes of one picture. An address in its place is not followed.
pub fn read(settings: &ImagesSettings, reply: &Reply) -> Reading<Vec<u8>> {
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
    let drawn: Drawn = match serde_json::from_slice(&reply.body) {
        Ok(drawn) => drawn,
        Err(error) => return failed(format!("its answer is no list of pictures: {error}")),
    };
    let usage = drawn.usage.as_ref();
    let spent = usage.map(|usage| match &usage.input_tokens_details {
        Some(input) => {
            let (text, pictures) = (input.text_tokens as f64, input.image_tokens as f64);
            cost(settings, text, pictures, usage.output_tokens as f64)
        }
        // All of it as what costs more.
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
        result: file(drawn.data),
    }
}

fn file(data: Vec<Drawing>) -> Result<Vec<u8>, Failure> {
    let bad = |reason: String| Failure::new(FailureKind::BadAnswer, reason);
    let drawing = data.into_iter().next().ok_or_else(|| bad("its answer has no picture".into()))?;
    let text = drawing.b64_json.ok_or_else(|| bad("its answer has no picture in base64".into()))?;
    STANDARD.decode(text).map_err(|error| bad(format!("its picture is no base64: {error}")))
}

#[cfg(test)]
mod tests;
