//! Events, and the messages that tell of them.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::StoreError;

/// Kind of an event. A scene, a job, a recording or a dataset that is worked on again ends again.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[schemars(rename = "WebhookEvent")]
pub enum EventType {
    #[serde(rename = "scene.succeeded")]
    SceneSucceeded,
    /// The scene is built, and its certificate says quarantine.
    #[serde(rename = "scene.quarantined")]
    SceneQuarantined,
    #[serde(rename = "scene.failed")]
    SceneFailed,
    #[serde(rename = "scene.cancelled")]
    SceneCancelled,
    /// An execution or the verification of a dataset has ended, as the events after it.
    #[serde(rename = "job.succeeded")]
    JobSucceeded,
    #[serde(rename = "job.failed")]
    JobFailed,
    #[serde(rename = "job.cancelled")]
    JobCancelled,
    #[serde(rename = "batch.ended")]
    BatchEnded,
    #[serde(rename = "recording.ended")]
    RecordingEnded,
    /// A dataset is frozen, or its freeze has failed or was cancelled.
    #[serde(rename = "dataset.ended")]
    DatasetEnded,
    /// Asked for, and sent to one webhook.
    #[serde(rename = "webhook.test")]
    WebhookTest,
}

impl EventType {
    pub const ALL: [Self; 11] = [
        Self::SceneSucceeded,
        Self::SceneQuarantined,
        Self::SceneFailed,
        Self::SceneCancelled,
        Self::JobSucceeded,
        Self::JobFailed,
        Self::JobCancelled,
        Self::BatchEnded,
        Self::RecordingEnded,
        Self::DatasetEnded,
        Self::WebhookTest,
    ];

    pub fn as_str(self) -> &'static str {
        match self {
            Self::SceneSucceeded => "scene.succeeded",
            Self::SceneQuarantined => "scene.quarantined",
            Self::SceneFailed => "scene.failed",
            Self::SceneCancelled => "scene.cancelled",
            Self::JobSucceeded => "job.succeeded",
            Self::JobFailed => "job.failed",
            Self::JobCancelled => "job.cancelled",
            Self::BatchEnded => "batch.ended",
            Self::RecordingEnded => "recording.ended",
            Self::DatasetEnded => "dataset.ended",
            Self::WebhookTest => "webhook.test",
        }
    }

    /// Inverse of [`Self::as_str`].
    pub fn parse(text: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|event| event.as_str() == text)
    }
}

/// Events as a column has them.
pub(super) fn words(events: &[EventType]) -> String {
    let words: Vec<&str> = events.iter().map(|event| event.as_str()).collect();
    words.join(" ")
}

/// Inverse of [`words`].
pub(super) fn of_words(text: &str) -> Result<Vec<EventType>, StoreError> {
    let unknown = |word| StoreError::Corrupt { table: "webhooks", reason: format!("event {word}") };
    text.split_whitespace().map(|word| EventType::parse(word).ok_or_else(|| unknown(word))).collect()
}

/// The message of an event: the body that is signed and sent.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(rename = "WebhookMessage")]
pub struct Message {
    #[serde(rename = "type")]
    pub event: EventType,
    /// Time of the event.
    #[schemars(extend("format" = "date-time"))]
    pub timestamp: String,
    pub data: MessageData,
}

/// The subject of an event, after it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(rename = "WebhookMessageData")]
pub struct MessageData {
    /// Id of the scene, the job, the batch, the recording, the dataset or the webhook.
    #[schemars(extend("format" = "uuid"))]
    pub id: String,
    /// Word of the event behind its dot; of a batch, a recording or a dataset its state.
    pub state: String,
    /// Code of the failure; null without one.
    pub failure_code: Option<String>,
    /// The job that ended, where it is one that made a scene or a dataset.
    #[schemars(extend("format" = "uuid"))]
    pub job_id: Option<String>,
    /// Path of the subject on the server.
    #[schemars(extend("format" = "uri-reference"))]
    pub path: String,
}

impl Message {
    /// The text of a message of a time in milliseconds since 1970.
    pub(super) fn text(event: EventType, at_ms: i64, data: MessageData) -> String {
        let time = jiff::Timestamp::from_millisecond(at_ms).unwrap_or_default();
        let timestamp = time.strftime("%Y-%m-%dT%H:%M:%S%.3fZ").to_string();
        serde_json::to_string(&Self { event, timestamp, data }).unwrap_or_default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn events_have_one_word_in_columns_and_messages() {
        for event in EventType::ALL {
            assert_eq!(serde_json::to_value(event).expect("serializes"), event.as_str());
            assert_eq!(EventType::parse(event.as_str()), Some(event));
        }
        let some = vec![EventType::BatchEnded, EventType::SceneFailed];
        assert_eq!(of_words(&words(&some)).expect("reads"), some);
        assert_eq!(of_words("").expect("reads"), []);
        assert!(of_words("scene.lost").is_err());
    }

    #[test]
    fn a_message_names_event_time_and_subject() {
        let data = MessageData {
            id: "a".into(),
            state: "failed".into(),
            failure_code: Some("no_room".into()),
            job_id: None,
            path: "/scenes/a".into(),
        };
        assert_eq!(
            Message::text(EventType::SceneFailed, 1_763_722_805_042, data),
            r#"{"type":"scene.failed","timestamp":"2025-11-21T11:00:05.042Z","data":{"id":"a","state":"failed","failure_code":"no_room","job_id":null,"path":"/scenes/a"}}"#
        );
    }
}
