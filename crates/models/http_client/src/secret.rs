//! API keys that never appear in logs, errors, settings, ledgers or checkpoints.

use std::fmt;

use bytes::Bytes;
use sha2::{Digest as _, Sha256};

/// An API key whose `Debug` output is constant.
#[derive(Clone, PartialEq, Eq)]
pub struct Secret(String);

impl Secret {
    /// The key without surrounding white space (a file's last line break); `None` where nothing remains.
    pub fn new(text: &str) -> Option<Self> {
        let text = text.trim();
        (!text.is_empty()).then(|| Self(text.to_owned()))
    }

    /// The text of an identifier that is stored like a key but is sent openly, as with every signature.
    pub fn into_id(self) -> String {
        self.0
    }

    /// The key itself. Only authentication headers and signatures may use it.
    pub fn expose(&self) -> &str {
        &self.0
    }

    /// SHA-256 of the key, by which calls with the same key share their limits.
    pub fn fingerprint(&self) -> [u8; 32] {
        Sha256::digest(self.0.as_bytes()).into()
    }

    /// The body of a response with every occurrence of the key replaced.
    pub fn redact(&self, body: Bytes) -> Bytes {
        let key = self.0.as_bytes();
        let mut kept: Vec<u8> = Vec::new();
        let mut rest = &body[..];
        while let Some(at) = rest.windows(key.len()).position(|window| window == key) {
            kept.extend_from_slice(&rest[..at]);
            kept.extend_from_slice(b"[redacted]");
            rest = &rest[at + key.len()..];
        }
        if kept.is_empty() {
            return body;
        }
        kept.extend_from_slice(rest);
        kept.into()
    }
}

impl fmt::Debug for Secret {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Secret")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn secret_is_redacted_from_debug_output_and_responses() {
        let key = Secret::new(" sk-123\n").expect("is a key");
        assert_eq!(format!("{key:?}"), "Secret");
        assert_eq!(key.expose(), "sk-123");
        let message = |text: &'static str| key.redact(Bytes::from_static(text.as_bytes()));
        assert_eq!(message("No such key: sk-123, sk-123."), "No such key: [redacted], [redacted].");
        assert_eq!(message("sk-123"), "[redacted]");
        assert_eq!(message("sk-12"), "sk-12");
        assert_eq!(message(""), "");
        assert_eq!(Secret::new(" \n"), None);
    }
}
