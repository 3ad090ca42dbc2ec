//! Messages against the published examples of OpenAI's API reference ("Create chat completion", "Images and vision",
//! "Structured Outputs", "Error codes").

use super::*;

/// The settings of `config/default.toml`.
pub(in super::super) fn settings() -> ChatSettings {
    let sources = crate::chat::tests::defaults();
    serde_json::from_value(sources["providers"]["chat"].clone()).expect("are the settings")
}

fn reply(body: &str) -> HttpResponse {
    HttpResponse {
        status: 200,
        content_type: "application/json".into(),
        retry_after: None,
        body: Bytes::copy_from_slice(body.as_bytes()),
    }
}

#[test]
fn read_parses_the_published_response() {
    let reading = read(
        &settings(),
        &reply(
            r#"{
              "id": "chatcmpl-B9MBs8CjcvOU2jLn4n570S5qMJKcT",
              "object": "chat.completion",
              "created": 1741569952,
              "model": "gpt-4.1-2025-04-14",
              "choices": [
                {
                  "index": 0,
                  "message": {
                    "role": "assistant",
                    "content": "Hello! How can I assist you today?",
                    "refusal": null,
                    "annotations": []
                  },
                  "logprobs": null,
                  "finish_reason": "stop"
                }
              ],
              "usage": {
                "prompt_tokens": 19,
                "completion_tokens": 10,
                "total_tokens": 29,
                "prompt_tokens_details": { "cached_tokens": 0, "audio_tokens": 0 },
                "completion_tokens_details": {
                  "reasoning_tokens": 0, "audio_tokens": 0, "accepted_prediction_tokens": 0,
                  "rejected_prediction_tokens": 0
                }
              },
              "service_tier": "default"
            }"#,
        ),
    );
    assert_eq!(reading.result.as_deref(), Ok("Hello! How can I assist you today?"));
    assert_eq!((reading.input_tokens, reading.output_tokens), (Some(19), Some(10)));
    // 19 tokens at 2 dollars a million and 10 at 8.
    assert_eq!(reading.cost, Some(MicroUsd(118)));
}

#[test]
fn read_classifies_and_bills_a_refusal() {
    let reading = read(
        &settings(),
        &reply(
            r#"{
              "id": "chatcmpl-9nYAG9LPNonX8DAyrkwYfemr3C8HC",
              "object": "chat.completion",
              "created": 1721596428,
              "model": "gpt-4o-2024-08-06",
              "choices": [
                {
                  "index": 0,
                  "message": {
                    "role": "assistant",
                    "refusal": "I'm sorry, I cannot assist with that request."
                  },
                  "logprobs": null,
                  "finish_reason": "stop"
                }
              ],
              "usage": { "prompt_tokens": 81, "completion_tokens": 11, "total_tokens": 92 },
              "system_fingerprint": "fp_3407719c7f"
            }"#,
        ),
    );
    let failure = reading.result.expect_err("is refused");
    assert_eq!(failure.kind, FailureKind::Refused);
    assert!(failure.reason.contains("I cannot assist"));
    assert_eq!(reading.cost, Some(MicroUsd(250)));
}

#[test]
fn read_classifies_other_endings() {
    let kind = |body: &str| read(&settings(), &reply(body)).result.map_err(|failure| failure.kind);
    let end = |reason: &str| {
        kind(&format!(r#"{{"choices": [{{"message": {{"content": "{{"}}, "finish_reason": "{reason}"}}]}}"#))
    };
    assert_eq!(end("length"), Err(FailureKind::Truncated));
    assert_eq!(end("content_filter"), Err(FailureKind::Filtered));
    assert_eq!(end("stop"), Ok("{".into()));
    for nothing in [
        "{}",
        r#"{"choices": []}"#,
        r#"{"choices": [{"finish_reason": "stop"}]}"#,
        r#"{"choices": [{"message": {"content": null}, "finish_reason": "stop"}]}"#,
        r#"{"choices": [{"message": {"content": " "}, "finish_reason": "stop"}]}"#,
        "[]",
        "<html>",
        "",
    ] {
        assert_eq!(kind(nothing), Err(FailureKind::BadAnswer), "{nothing}");
    }
    // A router says with status 200 that the model behind it failed (OpenRouter, "Errors").
    let routed = |code: u16| {
        kind(&format!(r#"{{"error": {{"code": {code}, "message": "Provider returned error"}}}}"#))
    };
    assert_eq!(routed(502), Err(FailureKind::ConnectionLost));
    assert_eq!(routed(500), Err(FailureKind::ServerError));
    assert_eq!(routed(429), Err(FailureKind::Busy));
    let page = HttpResponse { content_type: "text/html".into(), ..reply("{}") };
    assert_eq!(read(&settings(), &page).result.map_err(|f| f.kind), Err(FailureKind::BadAnswer));
}

#[test]
fn request_with_an_image_has_the_published_form() {
    let messages = [Message {
        role: Role::User,
        parts: vec![Part::Text("What is in this image?".into()), Part::Image(Bytes::from_static(b"\x89PNG"))],
    }];
    let body = request(&settings(), &messages, "n", &json!({ "type": "object" }), 1);
    // Of "Images and vision", with our detail.
    let published: Value = serde_json::from_str(
        r#"[{
          "role": "user",
          "content": [
            { "type": "text", "text": "What is in this image?" },
            { "type": "image_url", "image_url": { "url": "data:image/png;base64,iVBORw==", "detail": "high" } }
          ]
        }]"#,
    )
    .expect("is JSON");
    assert_eq!(body["messages"], published);
}

#[test]
fn request_with_a_schema_has_the_published_form() {
    // Of "Structured Outputs": the form of `response_format`, with the schema of the mathematics tutor.
    let published: Value = serde_json::from_str(
        r#"{
          "type": "json_schema",
          "json_schema": {
            "name": "math_response",
            "strict": true,
            "schema": {
              "type": "object",
              "properties": {
                "steps": {
                  "type": "array",
                  "items": {
                    "type": "object",
                    "properties": { "explanation": { "type": "string" }, "output": { "type": "string" } },
                    "required": ["explanation", "output"],
                    "additionalProperties": false
                  }
                },
                "final_answer": { "type": "string" }
              },
              "required": ["steps", "final_answer"],
              "additionalProperties": false
            }
          }
        }"#,
    )
    .expect("is JSON");
    let schema = &published["json_schema"]["schema"];
    let messages = [Message::text(Role::System, "You are a helpful math tutor.")];
    let body = request(&settings(), &messages, "math_response", schema, 7);
    assert_eq!(body["response_format"], published);
    assert_eq!(body["messages"], json!([{ "role": "system", "content": "You are a helpful math tutor." }]));
    assert_eq!(body["max_completion_tokens"], 8000);
    assert!(body.get("temperature").is_none() && body.get("seed").is_none());
}

#[test]
fn request_follows_the_settings_of_the_server() {
    let settings = ChatSettings {
        schema: SchemaSupport::JsonObject,
        token_limit_field: TokenLimitField::MaxTokens,
        temperature: 0.5,
        send_seed: true,
        ..settings()
    };
    let body = request(&settings, &[], "n", &json!({}), 7);
    assert_eq!(body["response_format"], json!({ "type": "json_object" }));
    assert_eq!(
        (&body["max_tokens"], &body["temperature"], &body["seed"]),
        (&json!(8000), &json!(0.5), &json!(7))
    );
}

#[test]
fn max_cost_bounds_the_billed_cost() {
    let settings = settings();
    let messages = [
        Message::text(Role::System, "word ".repeat(1000)),
        Message { role: Role::User, parts: vec![Part::Image(Bytes::new())] },
    ];
    let reserved = max_cost(&settings, &messages, &json!({}));
    // 1,000 tokens of text, an image at its limit, the longest answer.
    let billed = cost(&settings, 1000.0 + 3000.0, 8000.0);
    assert!(reserved >= billed && reserved <= MicroUsd(2 * billed.0), "{reserved} {billed}");
}
