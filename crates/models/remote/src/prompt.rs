//! Prompts: files of `config/prompts/`, each with its version on the first line.
//!
//! The version and the digest of every prompt are part of the identity of its adapter, and so of the keys of stages.

use serde_json::{Value, json};
use sha2::{Digest as _, Sha256};

/// A prompt.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Prompt {
    pub name: &'static str,
    /// Raised by hand when the text changes.
    pub version: u32,
    pub text: &'static str,
}

impl Prompt {
    /// Parses an embedded file; a test parses each of them.
    pub(super) fn new(name: &'static str, file: &'static str) -> Self {
        let (head, text) = file.split_once('\n').expect("a prompt has a first line: a test reads it");
        let version = head.strip_prefix("version: ").and_then(|version| version.trim().parse().ok());
        Self {
            name,
            version: version.expect("the first line is its version: a test reads it"),
            text: text.trim(),
        }
    }

    /// Name, version and digest.
    pub(super) fn identity(&self) -> Value {
        json!({ "name": self.name, "version": self.version, "sha256": self.digest() })
    }

    pub(super) fn digest(&self) -> String {
        let digest = Sha256::digest(self.text.as_bytes());
        runtime::digest::hex(&digest[..8])
    }
}
