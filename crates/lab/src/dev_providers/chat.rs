//! `POST /v1/chat/completions`: the questions of scenes, as strict schemas name them. Whoever asks anything else is told
//! that this is no chat model.

mod questions;
mod turning;
mod opinions;

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
use imaging::codec::decode_png;

/// A question as it was asked.
pub(super) struct Asked {
    /// Name of the schema that the answer has to have.
    pub schema: String,
    /// The data of the question.
    pub data: Value,
    pub pictures: Vec<Image>,
    pub seed: Option<u64>,
}

pub(super) async fn complete(State(providers): State<Arc<DevProviders>>, body: Bytes) -> Response {
    providers.pause().await;
    match completed(&providers, &body).await {
        Ok(completion) => answer(StatusCode::OK, &completion),
        Err(refusal) => refusal.openai(),
    }
}

async fn completed(providers: &DevProviders, body: &Bytes) -> Result<Value, Refusal> {
    let request: Value = serde_json::from_slice(body).map_err(|error| {
        Refusal::Wrong(format!("We could not parse the JSON body of your request: {error}"))
    })?;
    let asked = asked(&request)?;
    let said = questions::answered(&providers.studio, &asked).await?.to_string();
    providers.bill.add("chat", &asked.schema, body);
    let (input_tokens, output_tokens) = (body.len() / 64, said.len() / 4);
    Ok(json!({
        "id": "chatcmpl-dev", "object": "chat.completion", "created": 1_741_569_952, "model": request["model"],
        "choices": [{
            "index": 0, "message": { "role": "assistant", "content": said, "refusal": null }, "logprobs": null,
            "finish_reason": "stop",
        }],
        "usage": {
            "prompt_tokens": input_tokens, "completion_tokens": output_tokens,
            "total_tokens": input_tokens + output_tokens,
        },
    }))
}

fn asked(request: &Value) -> Result<Asked, Refusal> {
    let wrong = |told: &str| Refusal::Wrong(told.to_owned());
    if request["model"].as_str().is_none_or(str::is_empty) {
        return Err(wrong("you must provide a model parameter"));
    }
    let form = &request["response_format"];
    let schema = form["json_schema"]["name"].as_str().filter(|_| form["type"] == "json_schema");
    let schema = schema.ok_or_else(|| wrong("this model answers with strict JSON schemas alone"))?.to_owned();
    let messages = request["messages"].as_array().ok_or_else(|| wrong("messages must be a list"))?;
    let question = messages.iter().find(|message| message["role"] == "user");
    let question = question.ok_or_else(|| wrong("no message of a user"))?;
    let parts: Vec<Value> = match &question["content"] {
        Value::String(text) => vec![json!({ "type": "text", "text": text })],
        Value::Array(parts) => parts.clone(),
        _ => return Err(wrong("content must be a text or a list of parts")),
    };
    let (mut data, mut pictures) = (Value::Null, Vec::new());
    for part in &parts {
        match part["type"].as_str() {
            Some("text") if data.is_null() => {
                let text = part["text"].as_str().unwrap_or_default();
                data = serde_json::from_str(text).map_err(|_| wrong("the question is no JSON object"))?;
            }
            Some("image_url") => pictures.push(picture(&part["image_url"])?),
            _ => return Err(wrong("Invalid content type: text or image_url is expected")),
        }
    }
    Ok(Asked { schema, data, pictures, seed: request["seed"].as_u64() })
}

/// The object form is the only one that strict servers take.
fn picture(part: &Value) -> Result<Image, Refusal> {
    let url = part["url"].as_str().ok_or_else(|| Refusal::Wrong("image_url must be an object".into()))?;
    let png = url.strip_prefix("data:image/png;base64,").and_then(|data| STANDARD.decode(data).ok());
    let png = png.ok_or_else(|| Refusal::Wrong("only data URLs of PNG files are looked at".into()))?;
    decode_png(&png).map_err(|error| Refusal::Wrong(format!("the picture cannot be decoded: {error}")))
}
