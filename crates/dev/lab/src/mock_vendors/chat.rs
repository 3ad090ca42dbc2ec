//! `POST /v1/chat/completions`: the questions about scenes, selected by the name of their strict schema. Any other
//! request is rejected.

mod questions;
mod rotations;
mod ratings;

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
use imaging::codec::decode_png;

/// A parsed question.
pub(super) struct Question {
    /// Name of the answer schema.
    pub schema: String,
    /// Data of the question.
    pub data: Value,
    pub images: Vec<Image>,
    pub seed: Option<u64>,
}

pub(super) async fn complete(State(providers): State<Arc<MockVendors>>, body: Bytes) -> Response {
    providers.pause().await;
    match completed(&providers, &body).await {
        Ok(completion) => json_response(StatusCode::OK, &completion),
        Err(error) => error.openai(),
    }
}

async fn completed(providers: &MockVendors, body: &Bytes) -> Result<Value, VendorError> {
    let request: Value = serde_json::from_slice(body).map_err(|error| {
        VendorError::Invalid(format!("We could not parse the JSON body of your request: {error}"))
    })?;
    let question = parse_question(&request)?;
    let content = questions::answered(&providers.sessions, &question).await?.to_string();
    providers.bill.add("chat", &question.schema, body);
    let (input_tokens, output_tokens) = (body.len() / 64, content.len() / 4);
    Ok(json!({
        "id": "chatcmpl-dev", "object": "chat.completion", "created": 1_741_569_952, "model": request["model"],
        "choices": [{
            "index": 0, "message": { "role": "assistant", "content": content, "refusal": null }, "logprobs": null,
            "finish_reason": "stop",
        }],
        "usage": {
            "prompt_tokens": input_tokens, "completion_tokens": output_tokens,
            "total_tokens": input_tokens + output_tokens,
        },
    }))
}

fn parse_question(request: &Value) -> Result<Question, VendorError> {
    let invalid = |text: &str| VendorError::Invalid(text.to_owned());
    if request["model"].as_str().is_none_or(str::is_empty) {
        return Err(invalid("you must provide a model parameter"));
    }
    let form = &request["response_format"];
    let schema = form["json_schema"]["name"].as_str().filter(|_| form["type"] == "json_schema");
    let schema =
        schema.ok_or_else(|| invalid("this model answers with strict JSON schemas alone"))?.to_owned();
    let messages = request["messages"].as_array().ok_or_else(|| invalid("messages must be a list"))?;
    let user_message = messages.iter().find(|message| message["role"] == "user");
    let user_message = user_message.ok_or_else(|| invalid("no message of a user"))?;
    let parts: Vec<Value> = match &user_message["content"] {
        Value::String(text) => vec![json!({ "type": "text", "text": text })],
        Value::Array(parts) => parts.clone(),
        _ => return Err(invalid("content must be a text or a list of parts")),
    };
    let (mut data, mut images) = (Value::Null, Vec::new());
    for part in &parts {
        match part["type"].as_str() {
            Some("text") if data.is_null() => {
                let text = part["text"].as_str().unwrap_or_default();
                data = serde_json::from_str(text).map_err(|_| invalid("the question is no JSON object"))?;
            }
            Some("image_url") => images.push(image(&part["image_url"])?),
            _ => return Err(invalid("Invalid content type: text or image_url is expected")),
        }
    }
    Ok(Question { schema, data, images, seed: request["seed"].as_u64() })
}

/// Strict servers accept only the object form.
fn image(part: &Value) -> Result<Image, VendorError> {
    let url =
        part["url"].as_str().ok_or_else(|| VendorError::Invalid("image_url must be an object".into()))?;
    let png = url.strip_prefix("data:image/png;base64,").and_then(|data| STANDARD.decode(data).ok());
    let png = png.ok_or_else(|| VendorError::Invalid("only data URLs of PNG files are read".into()))?;
    decode_png(&png).map_err(|error| VendorError::Invalid(format!("the image cannot be decoded: {error}")))
}
