//! Secrets of clients: keys of the API, cookies of sessions, and what webhooks are signed with.
//!
//! A secret has 256 random bits of the system. Of a key and a cookie the store keeps the SHA-256 alone and finds them
//! by that, so that a stolen database opens nothing, and the time of a look-up says nothing about the secret that was
//! sought. A slow hash, as for passwords, would not help: 256 random bits cannot be guessed, however fast guesses are
//! tested. The secret of a webhook signs messages, so that it is kept as it is; it opens nothing here.

use std::fmt;

use base64::Engine as _;
use base64::engine::general_purpose::{STANDARD, URL_SAFE_NO_PAD};

use super::{Digest, StoreError};

/// Begin of every key, by which scanners of leaked secrets know it.
pub const KEY_PREFIX: &str = "tt_";
/// Begin of every secret of a webhook, by Standard Webhooks.
pub const WEBHOOK_PREFIX: &str = "whsec_";
/// Random bytes of a secret.
const RANDOM_BYTES: usize = 32;

/// A secret. It is shown by [`Secret::expose`] alone: it has no `Display`, and its `Debug` hides it.
#[derive(Clone, PartialEq, Eq)]
pub struct Secret(String);

impl Secret {
    /// A new key: `tt_` and 43 characters of base64url.
    ///
    /// # Errors
    ///
    /// [`StoreError::NoRandomBytes`] if the system has none.
    pub fn new_key() -> Result<Self, StoreError> {
        Ok(Self(format!("{KEY_PREFIX}{}", random_text()?)))
    }

    /// A new cookie of a session: 43 characters of base64url.
    ///
    /// # Errors
    ///
    /// [`StoreError::NoRandomBytes`] if the system has none.
    pub fn new_session() -> Result<Self, StoreError> {
        Ok(Self(random_text()?))
    }

    /// A new secret of a webhook: `whsec_` and the base64 of its key.
    ///
    /// # Errors
    ///
    /// [`StoreError::NoRandomBytes`] if the system has none.
    pub fn new_webhook() -> Result<Self, StoreError> {
        Ok(Self(format!("{WEBHOOK_PREFIX}{}", STANDARD.encode(random_bytes()?))))
    }

    /// A text that a client gives as a secret.
    pub fn given(text: &str) -> Self {
        Self(text.to_owned())
    }

    /// The digest that the store has of it.
    pub fn digest(&self) -> Digest {
        Digest::of(self.0.as_bytes())
    }

    /// The text of the secret, to be given to its owner once.
    pub fn expose(&self) -> &str {
        &self.0
    }
}

impl fmt::Debug for Secret {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Secret(hidden)")
    }
}

fn random_text() -> Result<String, StoreError> {
    Ok(URL_SAFE_NO_PAD.encode(random_bytes()?))
}

fn random_bytes() -> Result<[u8; RANDOM_BYTES], StoreError> {
    let mut bytes = [0; RANDOM_BYTES];
    getrandom::fill(&mut bytes).map_err(StoreError::NoRandomBytes)?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn secrets_differ_and_are_not_shown() {
        let (first, second) = (Secret::new_key().expect("random"), Secret::new_key().expect("random"));
        assert_ne!(first, second);
        for secret in [&first, &second] {
            assert_eq!(secret.expose().len(), KEY_PREFIX.len() + 43);
            assert!(secret.expose().starts_with(KEY_PREFIX));
            assert!(!format!("{secret:?} {secret:#?}").contains(&secret.expose()[3..]));
            assert_eq!(secret.digest(), Secret::given(secret.expose()).digest());
        }
        assert_eq!(Secret::new_session().expect("random").expose().len(), 43);
    }
}
