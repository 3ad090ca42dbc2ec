//! The billable requests in order.

use std::sync::{Mutex, PoisonError};

use serde::Serialize;
use sha2::{Digest as _, Sha256};

/// A line of the bill.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Billed {
    /// `chat`, `images`, `segment`, `predictions`, `hunyuan3d`.
    pub protocol: &'static str,
    /// Operation name of the protocol.
    pub operation: String,
    /// Digest of the request body: equal requests have equal digests.
    pub request_sha256: String,
}

/// All lines so far.
#[derive(Debug, Default)]
pub struct Bill(Mutex<Vec<Billed>>);

impl Bill {
    pub fn add(&self, protocol: &'static str, operation: &str, body: &[u8]) {
        let request_sha256 = runtime::digest::hex(&Sha256::digest(body));
        let line = Billed { protocol, operation: operation.to_owned(), request_sha256 };
        self.0.lock().unwrap_or_else(PoisonError::into_inner).push(line);
    }

    pub fn lines(&self) -> Vec<Billed> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }
}
