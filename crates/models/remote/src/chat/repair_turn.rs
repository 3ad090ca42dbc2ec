//! One question with its parsed answer, and one repair turn: violations are reported to the model, and its second
//! answer is final.

use bytes::Bytes;
use serde::de::DeserializeOwned;
use serde_json::Value;

use super::super::endpoint::Question;
use super::super::failure::{Failure, FailureKind};
use super::super::prompt::Prompt;
use super::super::settings::SchemaSupport;
use super::wire::{self, Message, Part, Role};
use super::{ChatAnalyst, NAME};
use ports::{Call, Port, ProviderError};

/// One question.
pub struct Topic {
    pub prompt: &'static Prompt,
    pub schema: Value,
    pub seed: u64,
    /// The data of the question.
    pub data: Value,
    /// PNG files.
    pub images: Vec<Bytes>,
}

impl ChatAnalyst {
    /// The answer that `accept` accepts, at the latest after one repair turn.
    pub(super) async fn ask<T, U>(
        &self,
        call: &Call,
        topic: Topic,
        accept: impl Fn(T) -> Result<U, Vec<String>>,
    ) -> Result<U, ProviderError>
    where
        T: DeserializeOwned,
    {
        let mut messages = opening(&topic, self.settings.schema);
        let answer = self.say(call, &topic, &messages).await?;
        let complaints = match read(&answer).and_then(&accept) {
            Ok(value) => return Ok(value),
            Err(complaints) => complaints,
        };
        tracing::debug!(operation = topic.prompt.name, ?complaints, "an answer was not accepted");
        // Bounds the cost of an overlong answer, which the model reads again.
        messages.push(Message::text(Role::Assistant, answer.chars().take(60_000).collect::<String>()));
        messages.push(Message::text(Role::User, correction(&complaints)));
        let answer = self.say(call, &topic, &messages).await?;
        read(&answer).and_then(&accept).map_err(|complaints| {
            let reason = format!(
                "its answer to `{}` does not hold, also after a correction: {}",
                topic.prompt.name,
                complaints.join("; ")
            );
            Failure::new(FailureKind::BadAnswer, reason).into_error(Port::Analyst, NAME)
        })
    }

    async fn say(&self, call: &Call, topic: &Topic, messages: &[Message]) -> Result<String, ProviderError> {
        let name = topic.prompt.name;
        let body = wire::request(&self.settings, messages, name, &topic.schema, topic.seed);
        let question = Question {
            operation: name,
            path: "/chat/completions",
            headers: Vec::new(),
            content_type: "application/json".into(),
            body: body.to_string().into(),
            reserved: wire::max_cost(&self.settings, messages, &topic.schema),
        };
        self.endpoint.ask(call, &question, |reply| wire::read(&self.settings, reply)).await
    }
}

fn opening(topic: &Topic, schema: SchemaSupport) -> Vec<Message> {
    let mut system = topic.prompt.text.to_owned();
    if schema == SchemaSupport::JsonObject {
        system.push_str("\n\nThe form of the answer, as a JSON schema:\n");
        system.push_str(&topic.schema.to_string());
    }
    let mut parts = vec![Part::Text(topic.data.to_string())];
    parts.extend(topic.images.iter().cloned().map(Part::Image));
    vec![Message::text(Role::System, system), Message { role: Role::User, parts }]
}

fn correction(complaints: &[String]) -> String {
    let list: String = complaints.iter().map(|complaint| format!("- {complaint}\n")).collect();
    format!(
        "Your answer cannot be used:\n{list}Answer again with the whole corrected JSON object and nothing else."
    )
}

/// The violations in a response; empty where it is accepted.
pub(super) fn complaints_of<T: DeserializeOwned, U>(
    response: &str,
    accept: impl Fn(T) -> Result<U, Vec<String>>,
) -> Vec<String> {
    read(response).and_then(accept).err().unwrap_or_default()
}

/// Parses an answer, or reports the violation.
fn read<T: DeserializeOwned>(answer: &str) -> Result<T, Vec<String>> {
    let value = json_object(answer).ok_or_else(|| vec!["it holds no JSON object".to_owned()])?;
    serde_path_to_error::deserialize(value).map_err(|error| {
        let (path, inner) = (error.path().to_string(), error.inner().to_string());
        vec![format!("{path}: {}", inner.chars().take(200).collect::<String>())]
    })
}

/// The first JSON object of a text. Without schemas, models wrap it in a fence or a sentence.
fn json_object(text: &str) -> Option<Value> {
    let starts = text.match_indices('{').map(|(at, _)| at).take(16);
    let mut objects = starts.filter_map(|at| {
        let mut stream = serde_json::Deserializer::from_str(&text[at..]).into_iter::<Value>();
        stream.next()?.ok().filter(Value::is_object)
    });
    objects.next()
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn json_object_is_found_in_fences_and_sentences() {
        let wanted = json!({ "a": { "b": "}" } });
        for text in [
            r#"{"a": {"b": "}"}}"#,
            "```json\n{\"a\": {\"b\": \"}\"}}\n```",
            "Here is the table you asked for: {\"a\": {\"b\": \"}\"}} I hope it helps!",
            "Braces {like these} first. {\"a\": {\"b\": \"}\"}}",
        ] {
            assert_eq!(json_object(text), Some(wanted.clone()), "{text}");
        }
        for text in ["", "no", "[1, 2]", "{\"a\": ", "{{{{{{{{{{{{{{{{{{{{{{{{{{{{{{"] {
            assert_eq!(json_object(text), None, "{text}");
        }
    }

    #[test]
    fn parse_errors_name_the_path() {
        #[derive(serde::Deserialize, Debug)]
        struct Answer {
            #[allow(dead_code, reason = "only its type matters")]
            sizes: Vec<f64>,
        }
        let complaints = read::<Answer>(r#"{"sizes": [1, "two"]}"#).expect_err("is no number");
        assert!(complaints[0].starts_with("sizes[1]: invalid type: string"), "{complaints:?}");
    }
}
