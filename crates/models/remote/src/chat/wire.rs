//! Wire format: requests and responses of `POST {base}/chat/completions`.
//!
//! The literals of the tests are the published examples of OpenAI's API reference.

use bytes::Bytes;
use serde::Deserialize;
use serde_json::{Value, json};

use super::super::ChatSettings;
use super::super::endpoint::Reading;
use super::super::failure::{Billed, Failure, FailureKind, one_line};
use super::super::settings::{SchemaSupport, TokenLimitField};
use http_client::HttpResponse;
use ports::ledger::MicroUsd;

/// The author of a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    System,
    User,
    Assistant,
}

/// Part of a message.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Part {
    Text(String),
    /// An image as a PNG file.
    Image(Bytes),
}

/// One message of a conversation.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Message {
    pub role: Role,
    pub parts: Vec<Part>,
}

impl Message {
    pub fn text(role: Role, text: impl Into<String>) -> Self {
        Self { role, parts: vec![Part::Text(text.into())] }
    }
}

/// A request's body.
pub fn request(
    settings: &ChatSettings,
    messages: &[Message],
    schema_name: &str,
    schema: &Value,
    seed: u64,
) -> Value {
    let mut body = json!({
        "model": settings.model,
        "messages": messages.iter().map(|message| message_of(message, settings)).collect::<Vec<_>>(),
        "response_format": match settings.schema {
            SchemaSupport::Strict => json!({
                "type": "json_schema",
                "json_schema": { "name": schema_name, "strict": true, "schema": schema },
            }),
            SchemaSupport::JsonObject => json!({ "type": "json_object" }),
        },
    });
    let limit = match settings.token_limit_field {
        TokenLimitField::MaxCompletionTokens => "max_completion_tokens",
        TokenLimitField::MaxTokens => "max_tokens",
    };
    body[limit] = json!(settings.max_output_tokens);
    if settings.temperature >= 0.0 {
        body["temperature"] = json!(settings.temperature);
    }
    if settings.send_seed {
        body["seed"] = json!(seed);
    }
    body
}

fn message_of(message: &Message, settings: &ChatSettings) -> Value {
    use base64::Engine as _;
    let role = match message.role {
        Role::System => "system",
        Role::User => "user",
        Role::Assistant => "assistant",
    };
    // Older servers take parts from users alone.
    if let (Role::System | Role::Assistant, [Part::Text(text)]) = (message.role, message.parts.as_slice()) {
        return json!({ "role": role, "content": text });
    }
    let part = |part: &Part| match part {
        Part::Text(text) => json!({ "type": "text", "text": text }),
        Part::Image(png) => {
            let data = base64::engine::general_purpose::STANDARD.encode(png);
            let url = format!("data:image/png;base64,{data}");
            json!({ "type": "image_url", "image_url": { "url": url, "detail": settings.detail } })
        }
    };
    json!({ "role": role, "content": message.parts.iter().map(part).collect::<Vec<_>>() })
}

/// Maximum cost of a question: a text has at most as many tokens as bytes, and answers end at their limit.
pub fn max_cost(settings: &ChatSettings, messages: &[Message], schema: &Value) -> MicroUsd {
    let mut input = schema.to_string().len() as f64;
    for message in messages {
        // Separators of messages count a few tokens.
        input += 16.0;
        for part in &message.parts {
            input += match part {
                Part::Text(text) => text.len() as f64,
                Part::Image(_) => f64::from(settings.image_tokens),
            };
        }
    }
    cost(settings, input, f64::from(settings.max_output_tokens))
}

fn cost(settings: &ChatSettings, input_tokens: f64, output_tokens: f64) -> MicroUsd {
    let input = input_tokens * settings.input_usd_per_million;
    MicroUsd::of_usd((input + output_tokens * settings.output_usd_per_million) / 1e6)
}

#[derive(Deserialize)]
struct Completion {
    #[serde(default)]
    choices: Vec<Choice>,
    usage: Option<Usage>,
    /// Routers report a failing provider behind them with status 200.
    error: Option<Value>,
}

#[derive(Deserialize)]
struct Choice {
    message: Option<AnswerMessage>,
    finish_reason: Option<String>,
}

#[derive(Deserialize)]
struct AnswerMessage {
    content: Option<String>,
    refusal: Option<String>,
}

#[derive(Deserialize)]
struct Usage {
    #[serde(default)]
    prompt_tokens: u64,
    #[serde(default)]
    completion_tokens: u64,
}

/// Reads a successful response: the model's answer as text, or the failure.
pub fn read(settings: &ChatSettings, reply: &HttpResponse) -> Reading<String> {
    let failed = |kind, reason: String| Reading {
        cost: None,
        input_tokens: None,
        output_tokens: None,
        task: None,
        result: Err(Failure::new(kind, reason)),
    };
    if !reply.content_type.ends_with("json") {
        let kind = one_line(&reply.content_type);
        return failed(FailureKind::BadAnswer, format!("it answered with {kind:?} in place of JSON"));
    }
    let completion: Completion = match serde_json::from_slice(&reply.body) {
        Ok(completion) => completion,
        Err(error) => {
            return failed(FailureKind::BadAnswer, format!("its answer is no chat completion: {error}"));
        }
    };
    if let Some(error) = completion.error.filter(|error| !error.is_null()) {
        let body = Bytes::from(json!({ "error": error }).to_string());
        let status = error["code"].as_u64().filter(|code| (400..600).contains(code)).unwrap_or(500);
        let inner = HttpResponse { status: status as u16, body, ..reply.clone() };
        if let Some(failure) = Failure::of_status(&inner) {
            let cost = (failure.kind.billed() == Billed::No).then_some(MicroUsd::ZERO);
            return Reading {
                cost,
                input_tokens: None,
                output_tokens: None,
                task: None,
                result: Err(failure),
            };
        }
    }
    let (input_tokens, output_tokens) = match &completion.usage {
        Some(usage) => (Some(usage.prompt_tokens), Some(usage.completion_tokens)),
        None => (None, None),
    };
    let spent = completion
        .usage
        .as_ref()
        .map(|usage| cost(settings, usage.prompt_tokens as f64, usage.completion_tokens as f64));
    Reading { cost: spent, input_tokens, output_tokens, task: None, result: answer_text(completion.choices) }
}

fn answer_text(choices: Vec<Choice>) -> Result<String, Failure> {
    let bad = |reason: &str| Failure::new(FailureKind::BadAnswer, reason);
    let choice = choices.into_iter().next().ok_or_else(|| bad("its answer has no choice"))?;
    let message = choice.message.ok_or_else(|| bad("its answer has no message"))?;
    if let Some(refusal) = message.refusal.filter(|refusal| !refusal.trim().is_empty()) {
        return Err(Failure::new(FailureKind::Refused, format!("the model refuses: {}", one_line(&refusal))));
    }
    match choice.finish_reason.as_deref() {
        Some("length") => Err(Failure::new(
            FailureKind::Truncated,
            "the answer stops at its limit; raise providers.*.max_output_tokens or ask for fewer objects",
        )),
        Some("content_filter") => Err(Failure::new(
            FailureKind::Filtered,
            "the vendor's filter cut the answer off; ask for another scene",
        )),
        _ => message
            .content
            .filter(|content| !content.trim().is_empty())
            .ok_or_else(|| bad("its answer has no content")),
    }
}

#[cfg(test)]
mod tests;
