//! A key of a vendor. It is shown nowhere: not in logs, errors, settings, ledgers or checkpoints.

use std::fmt;

use bytes::Bytes;
use sha2::{Digest as _, Sha256};

/// A key; what it prints as tells nothing.
#[derive(Clone, PartialEq, Eq)]
pub struct Secret(String);

impl Secret {
    /// White space around it (a file's last line break) does not belong to it; `None` where nothing else is there.
    pub fn new(text: &str) -> Option<Self> {
        let text = text.trim();
        (!text.is_empty()).then(|| Self(text.to_owned()))
    }

    /// What is no key but the name of one: it is sent with every signature.
    pub fn into_id(self) -> String {
        self.0
    }

    /// For the header that carries it, and nothing else.
    pub(super) fn expose(&self) -> &str {
        &self.0
    }

    /// Tells keys apart inside the process, so that calls with the same key share their limits.
    pub(super) fn fingerprint(&self) -> [u8; 32] {
        Sha256::digest(self.0.as_bytes()).into()
    }

    /// An answer without the key, should a vendor have sent it back.
    pub(super) fn redact(&self, answer: Bytes) -> Bytes {
        let key = self.0.as_bytes();
        let mut kept: Vec<u8> = Vec::new();
        let mut rest = &answer[..];
        while let Some(at) = rest.windows(key.len()).position(|window| window == key) {
            kept.extend_from_slice(&rest[..at]);
            kept.extend_from_slice(b"[redacted]");
            rest = &rest[at + key.len()..];
        }
        if kept.is_empty() {
            return answer;
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
    fn a_key_is_never_printed() {
        let key = Secret::new(" sk-123\n").expect("is a key");
        assert_eq!(format!("{key:?}"), "Secret");
        assert_eq!(key.expose(), "sk-123");
        let told = |text: &'static str| key.redact(Bytes::from_static(text.as_bytes()));
        assert_eq!(told("No such key: sk-123, sk-123."), "No such key: [redacted], [redacted].");
        assert_eq!(told("sk-123"), "[redacted]");
        assert_eq!(told("sk-12"), "sk-12");
        assert_eq!(told(""), "");
        assert_eq!(Secret::new(" \n"), None);
    }
}
