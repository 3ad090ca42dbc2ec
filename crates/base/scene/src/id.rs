//! Identifiers of tenants, scenes, jobs, batches, datasets, keys and webhooks, each a type of its own, so that they
//! cannot be swapped.

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

/// Maximum length of an id, bytes.
const MAX_LENGTH: usize = 64;

/// The text is not a valid id.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{text:?} is not the id of a {kind}: 1 to 64 characters of A-Z, a-z, 0-9, _ and -")]
pub struct InvalidId {
    kind: &'static str,
    text: String,
}

/// Declares an id: a string of 1 to 64 characters of `A-Z`, `a-z`, `0-9`, `_` and `-`, serialized as plain text.
macro_rules! id {
    ($(#[$doc:meta])* $name:ident, $kind:literal) => {
        $(#[$doc])*
        #[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
        #[serde(try_from = "String", into = "String")]
        pub struct $name(String);

        impl $name {
            pub fn as_str(&self) -> &str {
                &self.0
            }
        }

        impl FromStr for $name {
            type Err = InvalidId;
            fn from_str(text: &str) -> Result<Self, InvalidId> {
                Self::try_from(text.to_owned())
            }
        }

        impl TryFrom<String> for $name {
            type Error = InvalidId;
            fn try_from(text: String) -> Result<Self, InvalidId> {
                if is_valid(&text) { Ok(Self(text)) } else { Err(InvalidId { kind: $kind, text }) }
            }
        }

        impl From<$name> for String {
            fn from(id: $name) -> Self {
                id.0
            }
        }

        impl fmt::Display for $name {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str(&self.0)
            }
        }
    };
}

id!(
    /// Id of a tenant, the owner of scenes and jobs.
    TenantId,
    "tenant"
);
id!(
    /// Id of a stored scene.
    SceneId,
    "scene"
);
id!(
    /// Id of a job.
    JobId,
    "job"
);
id!(
    /// Id of a batch, many requests for scenes that were submitted together.
    BatchId,
    "batch"
);
id!(
    /// Id of a dataset, one frozen version of a set of scenes.
    DatasetId,
    "dataset"
);
id!(
    /// Id of a recording, demonstrations in a scene that become a dataset.
    RecordingId,
    "recording"
);
id!(
    /// Id of an API key, which is no secret.
    KeyId,
    "key"
);
id!(
    /// Id of a webhook, an address that events are sent to.
    WebhookId,
    "webhook"
);
id!(
    /// Id of a delivery, one message for one webhook.
    DeliveryId,
    "delivery"
);

fn is_valid(text: &str) -> bool {
    let allowed = |byte: u8| byte.is_ascii_alphanumeric() || byte == b'_' || byte == b'-';
    (1..=MAX_LENGTH).contains(&text.len()) && text.bytes().all(allowed)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ids_parse_and_serialize_as_plain_text() {
        let text = "0192f3a4-5b6c-7d8e-9fa0-b1c2d3e4f5a6";
        let id: SceneId = text.parse().expect("a UUID");
        assert_eq!((id.as_str(), id.to_string().as_str()), (text, text));
        assert_eq!(serde_json::to_value(&id).expect("serializes"), text);
        assert_eq!(serde_json::from_value::<SceneId>(text.into()).expect("deserializes"), id);
    }

    #[test]
    fn ids_reject_empty_long_and_unsafe_text() {
        for text in ["", "a/b", "a b", "..", "é", &"x".repeat(65)] {
            let error = text.parse::<JobId>().expect_err(text);
            assert!(error.to_string().contains("id of a job"), "{error}");
            assert!(serde_json::from_value::<TenantId>(text.into()).is_err(), "{text:?}");
        }
    }
}
