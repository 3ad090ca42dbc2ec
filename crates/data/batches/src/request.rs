//! One request of a batch: a name that the client chose, and the body of `POST /scenes`.

use std::collections::BTreeMap;
use std::fmt;

use serde::{Deserialize, Serialize};
use serde_json::json;
use sha2::{Digest, Sha256};

use scene::Violation;
use scene::request::{MAX_SEED, RequestOptions};

/// Largest number of requests of one batch.
pub const MAX_REQUESTS: u64 = 1_000_000;

/// Largest length of a `custom_id`, characters.
pub const MAX_CUSTOM_ID_CHARS: usize = 64;

/// Ends of names that the files of a batch have, so that no folder of a request is mistaken for one.
const RESERVED_ENDS: [&str; 3] = [".jsonl", ".zip", ".json"];

/// One request.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, expecting = "an object")]
pub struct BatchRequest {
    /// Name of the request, unique in its batch. The folder of its bundle has this name.
    pub custom_id: String,
    pub body: RequestBody,
}

/// The body of `POST /scenes`, with a path where the server takes the bytes of an image.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default, expecting = "an object")]
pub struct RequestBody {
    /// Description of the objects on the table; beside an image, of its content.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub text: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub image: Option<ImageFile>,
    /// Absent: [`RequestBody::seed`] derives one from the rest of the body.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub seed: Option<u64>,
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub labels: BTreeMap<String, String>,
    pub options: RequestOptions,
}

/// An image on the machine that runs the batch.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, expecting = "an object")]
pub struct ImageFile {
    /// Path of a PNG, JPEG or WebP file, absolute or from the folder of the batch file.
    pub path: String,
}

/// Digest of the scene that a request asks for: equal for requests that give the same scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct RequestDigest(pub u128);

impl fmt::Display for RequestDigest {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:032x}", self.0)
    }
}

impl BatchRequest {
    /// Digest of name and content together: the identity of the request across runs of a batch.
    pub fn digest(&self) -> RequestDigest {
        digest_of(&format!("{}\n{}", self.custom_id, self.body.digest()))
    }

    /// Every value that is out of its range, with a JSON pointer into the request. Texts, labels and settings are
    /// checked where scenes are submitted.
    pub fn violations(&self) -> Vec<Violation> {
        let mut violations = Vec::new();
        let mut wrong = |pointer: String, detail: String| violations.push(Violation { pointer, detail });
        if let Err(error) = check_custom_id(&self.custom_id) {
            wrong("/custom_id".into(), error.to_string());
        }
        let body = &self.body;
        if body.text.is_none() && body.image.is_none() {
            wrong("/body".into(), "must have `text`, `image`, or both; there is none".into());
        }
        if body.text.as_ref().is_some_and(|text| !text.contains(char::is_alphanumeric)) {
            wrong("/body/text".into(), "is empty; describe a table and what lies on it".into());
        }
        if body.seed.is_some_and(|seed| seed > MAX_SEED) {
            wrong("/body/seed".into(), format!("must be at most {MAX_SEED}"));
        }
        for Violation { pointer, detail } in body.options.violations() {
            wrong(format!("/body/options{pointer}"), detail);
        }
        violations
    }
}

impl RequestBody {
    /// Digest of text (white space normalized), image, seed and options. Labels do not change a scene.
    pub fn digest(&self) -> RequestDigest {
        let text = self.text.as_deref().map(normalized);
        let canonical =
            json!({ "text": text, "image": self.image, "seed": self.seed, "options": self.options });
        digest_of(&canonical.to_string())
    }

    /// The stated seed, or one that depends on the rest of the body alone, so that a batch gives the same scenes
    /// whenever it runs.
    pub fn seed(&self) -> u64 {
        self.seed.unwrap_or_else(|| self.digest().0 as u64 & MAX_SEED)
    }
}

/// The requirement that a name does not meet.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum CustomIdError {
    #[error("is empty; give every request a name")]
    Empty,
    #[error("has {length} characters; at most {MAX_CUSTOM_ID_CHARS} are allowed")]
    TooLong { length: usize },
    #[error(
        "must begin with a letter or digit and have only A-Z, a-z, 0-9, `_`, `-` and `.`: a folder gets this name"
    )]
    Characters,
    #[error("must not end with {}: files of the batch have such names", RESERVED_ENDS.join(", "))]
    ReservedEnd,
}

/// Checks a name: it becomes the name of a folder.
///
/// # Errors
///
/// The requirement that the name does not meet.
pub fn check_custom_id(custom_id: &str) -> Result<(), CustomIdError> {
    let length = custom_id.chars().count();
    let allowed = |c: char| c.is_ascii_alphanumeric() || matches!(c, '_' | '-' | '.');
    if custom_id.is_empty() {
        Err(CustomIdError::Empty)
    } else if length > MAX_CUSTOM_ID_CHARS {
        Err(CustomIdError::TooLong { length })
    } else if !custom_id.chars().all(allowed) || !custom_id.starts_with(|c: char| c.is_ascii_alphanumeric()) {
        Err(CustomIdError::Characters)
    } else if RESERVED_ENDS.iter().any(|end| custom_id.to_ascii_lowercase().ends_with(end)) {
        Err(CustomIdError::ReservedEnd)
    } else {
        Ok(())
    }
}

/// Words with one space between them.
fn normalized(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// The first 128 bits of the SHA-256 digest.
fn digest_of(text: &str) -> RequestDigest {
    let digest = Sha256::digest(text.as_bytes());
    let mut first = [0_u8; 16];
    first.copy_from_slice(&digest[..16]);
    RequestDigest(u128::from_be_bytes(first))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn body(json: serde_json::Value) -> RequestBody {
        serde_json::from_value(json).expect("a body")
    }

    #[test]
    fn custom_ids_are_names_of_folders() {
        for name in ["a", "mug-1", "t0_red_s7", "9", "v1.2", &"x".repeat(64)] {
            assert_eq!(check_custom_id(name), Ok(()), "{name}");
        }
        for (name, says) in [
            ("", "is empty"),
            (&"x".repeat(65) as &str, "65 characters"),
            ("a/b", "letter or digit"),
            ("..", "begin with"),
            (".hidden", "begin with"),
            ("-rf", "begin with"),
            ("tasse à café", "A-Z"),
            ("output.jsonl", ".jsonl"),
            ("a.ZIP", ".zip"),
        ] {
            let detail = check_custom_id(name).expect_err(name).to_string();
            assert!(detail.contains(says), "{name}: {detail}");
        }
    }

    #[test]
    fn digests_depend_on_text_seed_options_and_image_alone() {
        let plain = body(json!({ "text": "a mug", "seed": 7 }));
        for same in [
            json!({ "text": "  a\n mug ", "seed": 7 }),
            json!({ "seed": 7, "text": "a mug", "options": {} }),
            json!({ "text": "a mug", "seed": 7, "labels": { "split": "train" } }),
        ] {
            assert_eq!(body(same.clone()).digest(), plain.digest(), "{same}");
        }
        for other in [
            json!({ "text": "a mug" }),
            json!({ "text": "a mug", "seed": 8 }),
            json!({ "text": "A mug", "seed": 7 }),
            json!({ "text": "a mug", "seed": 7, "image": { "path": "a.png" } }),
            json!({ "text": "a mug", "seed": 7, "options": { "max_objects": 3 } }),
        ] {
            assert_ne!(body(other.clone()).digest(), plain.digest(), "{other}");
        }
    }

    #[test]
    fn a_request_without_a_seed_has_the_same_one_every_time() {
        let mug = body(json!({ "text": "a mug" }));
        assert_eq!(mug.seed(), body(json!({ "text": "a mug " })).seed());
        assert_ne!(mug.seed(), body(json!({ "text": "a cup" })).seed());
        assert!(mug.seed() <= MAX_SEED);
        assert_eq!(body(json!({ "text": "a mug", "seed": 7 })).seed(), 7);
    }

    #[test]
    fn violations_point_at_the_wrong_field() {
        let pointers = |json: serde_json::Value| -> Vec<String> {
            let request = BatchRequest { custom_id: "a".into(), body: body(json) };
            request.violations().into_iter().map(|violation| violation.pointer).collect()
        };
        assert!(pointers(json!({ "text": "a mug" })).is_empty());
        assert_eq!(pointers(json!({})), ["/body"]);
        assert_eq!(
            pointers(json!({ "text": " ", "seed": 1_u64 << 53, "options": { "max_objects": 99 } })),
            ["/body/text", "/body/seed", "/body/options/max_objects"]
        );
    }
}
