//! A server that speaks OpenAI's chat completions, written from the published format: it shares no types with the
//! adapter, is strict about requests, follows a script of faults, and keeps a bill.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex};
use std::time::Duration;

use axum::Router;
use axum::body::Body;
use axum::extract::{Request, State};
use axum::http::StatusCode;
use axum::response::Response;
use axum::routing::post;
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use bytes::Bytes;
use futures::future::BoxFuture;
use futures::stream;
use serde_json::{Value, json};
use tokio::net::TcpListener;
use tokio_util::task::AbortOnDropHandle;

/// Fault that one request gets in place of a good answer.
#[derive(Clone, Debug)]
pub enum Fault {
    /// A good answer, late.
    Latency(Duration),
    /// No answer.
    Silence,
    /// 429 with `Retry-After`, seconds.
    Busy(u64),
    /// 429 without credit.
    NoCredit,
    Status(u16),
    /// Half of a good answer, then the connection breaks.
    ResetMidBody,
    /// The connection breaks before the answer.
    ResetBeforeHeader,
    /// A page for people, with status 200.
    Page,
    NoJson,
    /// A good answer in a fence.
    Fenced,
    /// A good answer after a sentence.
    Sentence,
    /// An answer that is JSON of another form.
    OtherForm,
    /// The answer with this value in place of the one at the pointer.
    Spoiled(&'static str, Value),
    Refusal,
    Truncated,
    Filtered,
    /// More bytes than anybody wants.
    Endless,
    /// Leads to another address.
    Redirect(&'static str),
}

/// One request that the server answered, and would ask money for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Billed {
    pub schema: String,
    pub idempotency_key: Option<String>,
    pub body: Bytes,
}

/// Source of answers: the schema's name and the request in, the answer out.
pub type Answers = Arc<dyn Fn(String, Value) -> BoxFuture<'static, Value> + Send + Sync>;

/// A running server.
pub struct ChatServer {
    pub base_url: String,
    state: Arc<Shared>,
    _task: AbortOnDropHandle<()>,
}

struct Shared {
    answers: Answers,
    faults: Mutex<VecDeque<Fault>>,
    bill: Mutex<Vec<Billed>>,
    requests: Mutex<Vec<Value>>,
}

/// Key that the server accepts; it also accepts callers without a key, as servers of one's own do.
pub const KEY: &str = "sk-test-0123456789";

impl ChatServer {
    pub async fn start(answers: Answers) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
        let base_url = format!("http://{}/v1", listener.local_addr().unwrap());
        let state = Arc::new(Shared {
            answers,
            faults: Mutex::default(),
            bill: Mutex::default(),
            requests: Mutex::default(),
        });
        let router = Router::new()
            .route("/v1/chat/completions", post(complete))
            .fallback(|| async { error(404, "invalid_request_error", "unknown_url", "Unknown request URL") })
            .with_state(state.clone());
        let task = tokio::spawn(async move { axum::serve(listener, router).await.unwrap() });
        Self { base_url, state, _task: AbortOnDropHandle::new(task) }
    }

    /// The next requests get these; those after them, good answers.
    pub fn script(&self, faults: impl IntoIterator<Item = Fault>) {
        self.state.faults.lock().unwrap().extend(faults);
    }

    /// Faults that no request has taken yet.
    pub fn left(&self) -> usize {
        self.state.faults.lock().unwrap().len()
    }

    pub fn bill(&self) -> Vec<Billed> {
        self.state.bill.lock().unwrap().clone()
    }

    /// Every accepted request, in order.
    pub fn requests(&self) -> Vec<Value> {
        self.state.requests.lock().unwrap().clone()
    }
}

async fn complete(State(state): State<Arc<Shared>>, request: Request) -> Response {
    let (parts, body) = request.into_parts();
    let header =
        |name: &str| parts.headers.get(name).and_then(|value| value.to_str().ok()).map(str::to_owned);
    if let Some(given) = header("authorization").filter(|given| *given != format!("Bearer {KEY}")) {
        let message = format!("Incorrect API key provided: {}.", given.trim_start_matches("Bearer "));
        return error(401, "invalid_request_error", "invalid_api_key", &message);
    }
    let body = axum::body::to_bytes(body, 64 << 20).await.unwrap();
    let asked: Value = match serde_json::from_slice(&body) {
        Ok(asked) if header("content-type").as_deref() == Some("application/json") => asked,
        _ => return error(400, "invalid_request_error", "invalid_json", "We could not parse the JSON body."),
    };
    if let Err(why) = check(&asked) {
        return error(400, "invalid_request_error", "invalid_value", &why);
    }
    state.requests.lock().unwrap().push(asked.clone());
    let schema = asked["response_format"]["json_schema"]["name"].as_str().unwrap_or("json_object").to_owned();
    let answer = (state.answers)(schema.clone(), asked).await;
    let fault = state.faults.lock().unwrap().pop_front();
    let answered = || {
        let billed =
            Billed { schema: schema.clone(), idempotency_key: header("idempotency-key"), body: body.clone() };
        state.bill.lock().unwrap().push(billed);
    };
    match fault {
        None => {
            answered();
            completion(&answer.to_string())
        }
        Some(Fault::Latency(pause)) => {
            tokio::time::sleep(pause).await;
            answered();
            completion(&answer.to_string())
        }
        Some(Fault::Silence) => {
            answered();
            std::future::pending().await
        }
        Some(Fault::Busy(seconds)) => {
            let mut response =
                error(429, "requests", "rate_limit_exceeded", "Rate limit reached for requests");
            response.headers_mut().insert("retry-after", seconds.into());
            response
        }
        Some(Fault::NoCredit) => error(
            429,
            "insufficient_quota",
            "insufficient_quota",
            "You exceeded your current quota, please check your plan and billing details.",
        ),
        Some(Fault::Status(status)) => {
            error(status, "server_error", "", "The server had an error while processing your request.")
        }
        Some(Fault::ResetMidBody) => {
            answered();
            let whole = completion_text(&answer.to_string());
            let half = Bytes::from(whole[..whole.len() / 2].to_owned());
            let broken = Err(std::io::Error::other("reset"));
            json_response(Body::from_stream(stream::iter([Ok(half), broken])))
        }
        Some(Fault::ResetBeforeHeader) => {
            answered();
            panic!("the connection of this request breaks");
        }
        Some(Fault::Page) => {
            answered();
            let page = "<!doctype html><title>Just a moment...</title>";
            Response::builder().header("content-type", "text/html; charset=utf-8").body(page.into()).unwrap()
        }
        Some(Fault::NoJson) => {
            answered();
            json_response("upstream connect error".into())
        }
        Some(Fault::Fenced) => {
            answered();
            completion(&format!("```json\n{answer:#}\n```"))
        }
        Some(Fault::Sentence) => {
            answered();
            completion(&format!("Sure! Here is the plan you asked for:\n\n{answer}\n\nEnjoy your meal!"))
        }
        Some(Fault::OtherForm) => {
            answered();
            completion(r#"{"result": "ok"}"#)
        }
        Some(Fault::Spoiled(pointer, value)) => {
            answered();
            let mut answer = answer;
            *answer.pointer_mut(pointer).expect(pointer) = value;
            completion(&answer.to_string())
        }
        Some(Fault::Refusal) => {
            answered();
            choice(
                json!({ "role": "assistant", "refusal": "I'm sorry, I cannot assist with that request." }),
                "stop",
            )
        }
        Some(Fault::Truncated) => {
            answered();
            let text = answer.to_string();
            choice(
                json!({ "role": "assistant", "content": text[..text.len() / 2], "refusal": null }),
                "length",
            )
        }
        Some(Fault::Filtered) => {
            answered();
            choice(json!({ "role": "assistant", "content": "", "refusal": null }), "content_filter")
        }
        Some(Fault::Endless) => {
            answered();
            let chunk = Bytes::from(vec![b' '; 64 << 10]);
            json_response(Body::from_stream(stream::repeat_with(move || {
                Ok::<_, std::io::Error>(chunk.clone())
            })))
        }
        Some(Fault::Redirect(target)) => {
            Response::builder().status(307).header("location", target).body(Body::empty()).unwrap()
        }
    }
}

/// The rules of the published reference, as far as this program's requests touch them.
fn check(asked: &Value) -> Result<(), String> {
    let known = [
        "model",
        "messages",
        "response_format",
        "max_completion_tokens",
        "max_tokens",
        "temperature",
        "seed",
    ];
    for name in asked.as_object().ok_or("the body is no object")?.keys() {
        if !known.contains(&name.as_str()) {
            return Err(format!("Unrecognized request argument supplied: {name}"));
        }
    }
    asked["model"].as_str().filter(|model| !model.is_empty()).ok_or("you must provide a model parameter")?;
    let messages = asked["messages"].as_array().filter(|list| !list.is_empty()).ok_or("messages is empty")?;
    for message in messages {
        let role = message["role"].as_str().unwrap_or_default();
        if !["system", "user", "assistant"].contains(&role) {
            return Err(format!("role {role:?}"));
        }
        match &message["content"] {
            Value::String(_) => {}
            Value::Array(parts) if role == "user" => parts.iter().try_for_each(check_part)?,
            other => return Err(format!("content {other}")),
        }
    }
    match asked["response_format"]["type"].as_str() {
        Some("json_schema") => {
            let named = &asked["response_format"]["json_schema"];
            let name = named["name"].as_str().unwrap_or_default();
            let fine = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
            if name.is_empty() || name.len() > 64 || !name.chars().all(fine) || named["strict"] != true {
                return Err("Missing or invalid response_format.json_schema".into());
            }
            check_schema(&named["schema"])
        }
        Some("json_object") => {
            // Documented: without the word, the API refuses.
            let says = asked["messages"].to_string().to_lowercase().contains("json");
            if says { Ok(()) } else { Err("'messages' must contain the word 'json'".into()) }
        }
        other => Err(format!("response_format {other:?}")),
    }
}

fn check_part(part: &Value) -> Result<(), String> {
    match part["type"].as_str() {
        Some("text") => part["text"].as_str().map(|_| ()).ok_or_else(|| "a text part without text".into()),
        Some("image_url") => {
            let url = part["image_url"]["url"].as_str().ok_or("image_url must be an object with a url")?;
            let detail = part["image_url"]["detail"].as_str().unwrap_or("auto");
            let data = url.strip_prefix("data:image/png;base64,").ok_or("unsupported image")?;
            let bytes = STANDARD.decode(data).map_err(|error| error.to_string())?;
            let fine = bytes.starts_with(b"\x89PNG\r\n") && ["auto", "low", "high"].contains(&detail);
            if fine { Ok(()) } else { Err("unsupported image".into()) }
        }
        other => Err(format!("part {other:?}")),
    }
}

/// Strict mode: all properties required, none besides.
fn check_schema(schema: &Value) -> Result<(), String> {
    if let Some(properties) = schema["properties"].as_object() {
        let names: Vec<&String> = properties.keys().collect();
        if schema["additionalProperties"] != false || json!(names) != schema["required"] {
            return Err("Invalid schema: 'required' is required to be supplied, with every key".into());
        }
        properties.values().try_for_each(check_schema)?;
    }
    if schema["items"].is_object() { check_schema(&schema["items"]) } else { Ok(()) }
}

fn completion(content: &str) -> Response {
    json_response(completion_text(content).into())
}

fn completion_text(content: &str) -> String {
    choice_text(
        json!({ "role": "assistant", "content": content, "refusal": null, "annotations": [] }),
        "stop",
    )
}

fn choice(message: Value, finish_reason: &str) -> Response {
    json_response(choice_text(message, finish_reason).into())
}

fn choice_text(message: Value, finish_reason: &str) -> String {
    json!({
        "id": "chatcmpl-B9MBs8CjcvOU2jLn4n570S5qMJKcT", "object": "chat.completion", "created": 1741569952,
        "model": "gpt-4.1-2025-04-14",
        "choices": [{ "index": 0, "message": message, "logprobs": null, "finish_reason": finish_reason }],
        "usage": { "prompt_tokens": 1000, "completion_tokens": 500, "total_tokens": 1500 },
        "service_tier": "default",
    })
    .to_string()
}

fn json_response(body: Body) -> Response {
    Response::builder().header("content-type", "application/json").body(body).unwrap()
}

fn error(status: u16, kind: &str, code: &str, message: &str) -> Response {
    let body = json!({ "error": { "message": message, "type": kind, "param": null, "code": code } });
    let mut response = json_response(body.to_string().into());
    *response.status_mut() = StatusCode::from_u16(status).unwrap();
    response
}
