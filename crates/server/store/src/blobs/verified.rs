//! Memory of the blobs that were read in full and matched their digests.
//!
//! An entry holds for one version of the object (its entity tag, time and size) and for a limited time, after which a
//! disk may have lost bits without notice. The memory is bounded; it starts over when it is full.

use std::collections::HashMap;
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use object_store::ObjectMeta;

use super::Digest;

/// Time for which a verification counts.
const LIFETIME: Duration = Duration::from_secs(3600);
/// Largest number of entries; one takes about 250 bytes.
const MAX_ENTRIES: usize = 100_000;

/// Digests of verified blobs.
#[derive(Default)]
pub(super) struct VerifiedBlobs(Mutex<HashMap<Digest, Entry>>);

struct Entry {
    version: Version,
    at: Instant,
}

#[derive(PartialEq, Eq)]
struct Version {
    e_tag: Option<String>,
    modified_ms: i64,
    size: u64,
}

impl Version {
    fn of(meta: &ObjectMeta) -> Self {
        Self {
            e_tag: meta.e_tag.clone(),
            modified_ms: meta.last_modified.timestamp_millis(),
            size: meta.size,
        }
    }
}

impl VerifiedBlobs {
    pub(super) fn remember(&self, digest: &Digest, meta: &ObjectMeta) {
        let mut entries = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if entries.len() >= MAX_ENTRIES {
            entries.clear();
        }
        entries.insert(digest.clone(), Entry { version: Version::of(meta), at: Instant::now() });
    }

    pub(super) fn contains(&self, digest: &Digest, meta: &ObjectMeta) -> bool {
        let entries = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        entries
            .get(digest)
            .is_some_and(|entry| entry.version == Version::of(meta) && entry.at.elapsed() < LIFETIME)
    }

    pub(super) fn forget(&self, digest: &Digest) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).remove(digest);
    }
}
