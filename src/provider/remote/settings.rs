//! Section `[providers]`: who answers which port, and on what terms the network is used.

use serde::{Deserialize, Serialize};

use crate::provider::ledger::OnUnknown;

/// Section `[providers]`.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct ProviderSettings {
    /// Who answers the analyst's port: the first, and where that cannot, the next.
    pub analyst: Vec<AnalystProvider>,
    /// Plain HTTP may be used. Keys and pictures are then readable on the way.
    pub allow_http: bool,
    /// Hosts, or `host:port`, that may be private addresses; separated by spaces.
    pub private_hosts: String,
    /// What to do about a call whose answer was lost.
    pub on_unknown: OnUnknown,
    /// Longest time to open a connection, seconds (1..=600).
    pub connect_timeout_secs: u64,
    pub chat: ChatSettings,
    pub second_chat: ChatSettings,
}

/// Who can answer the analyst's port.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum AnalystProvider {
    /// Grammar, catalog and geometry.
    Embedded,
    /// The endpoint of `[providers.chat]`.
    Chat,
    /// The endpoint of `[providers.second_chat]`.
    SecondChat,
}

/// An OpenAI-compatible chat endpoint: sections `[providers.chat]` and `[providers.second_chat]`.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
pub struct ChatSettings {
    /// What `/chat/completions` is appended to.
    pub base_url: String,
    /// The model's name at that endpoint.
    pub model: String,
    /// Environment variable with the key, or, with `_FILE` appended, with the path of a file that holds it. Neither: no
    /// key is sent.
    pub key_variable: String,
    /// What the server can promise about the form of answers.
    pub schema: SchemaSupport,
    /// Name of the field that limits the answer's length.
    pub token_limit_field: TokenLimitField,
    /// Longest answer, tokens (256..=200000). Less truncates tables with many things; more is reserved of the budget.
    pub max_output_tokens: u32,
    /// How freely the model chooses its words (-1..=2); below 0 nothing is sent, and the model's own applies.
    pub temperature: f64,
    /// Whether the request's seed is sent.
    pub send_seed: bool,
    /// How closely the model is asked to look at pictures.
    pub detail: PictureDetail,
    /// Longer side of the picture that is sent, pixels (256..=2048). More shows smaller things and costs more.
    pub picture_px: u32,
    /// The most tokens that a picture of that size counts as (1..=100000); what is reserved of the budget.
    pub picture_tokens: u32,
    /// Header that carries an idempotency key, where the server knows one; empty = none is sent.
    pub idempotency_header: String,
    /// Price of a million input tokens, US dollars.
    pub input_usd_per_million: f64,
    /// Price of a million output tokens, US dollars.
    pub output_usd_per_million: f64,
    #[serde(flatten)]
    pub limits: LimitSettings,
}

/// Terms of one endpoint.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
pub struct LimitSettings {
    /// Longest time of one try, seconds (1..=3600).
    pub attempt_timeout_secs: u64,
    /// Longest time of all tries of one call with the pauses between them, seconds (1..=86400).
    pub total_timeout_secs: u64,
    /// Tries of one call (1..=10).
    pub max_tries: u32,
    /// The first pause is half of this on average, milliseconds; it doubles with every try.
    pub pause_base_ms: u64,
    /// Longest pause, milliseconds; where a server asks for more, the job goes back to its queue.
    pub pause_cap_ms: u64,
    /// Largest answer, bytes.
    pub max_answer_bytes: usize,
    /// Calls with the same key at the same time (1..=1024).
    pub concurrency: usize,
    /// Calls with the same key begun in a minute (1..=1000000), evenly spaced.
    pub calls_per_minute: u32,
    /// Failures in a row after which the endpoint is left alone (1..=1000).
    pub breaker_failures: u32,
    /// For how long it is left alone before one call tries again, seconds (1..=86400).
    pub breaker_rest_secs: u64,
}

/// What a server can promise about the form of answers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SchemaSupport {
    /// Answers follow a JSON schema (`json_schema`, strict).
    Strict,
    /// Answers are JSON (`json_object`); the schema stands in the prompt.
    JsonObject,
}

/// Name of the field that limits an answer's length.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum TokenLimitField {
    MaxCompletionTokens,
    MaxTokens,
}

/// How closely a model is asked to look at pictures.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum PictureDetail {
    Auto,
    Low,
    High,
}
