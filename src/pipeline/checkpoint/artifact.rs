//! Bytes that a stage stores for later stages or for inspection.

use std::sync::{Arc, Mutex};

use serde::{Deserialize, Serialize};

use store::Digest;
use store::artifacts::FileRow;

/// Names immutable bytes; part of outputs and inputs in their place.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ArtifactRef {
    /// `<stage>/<name>` or `<stage>/<instance>/<name>`.
    pub name: String,
    pub digest: Digest,
    pub media_type: String,
    /// Bytes.
    pub size: u64,
}

/// Artifacts that a running stage has stored so far.
#[derive(Clone, Debug, Default)]
pub(super) struct Artifacts(Arc<Mutex<Vec<FileRow>>>);

impl Artifacts {
    /// Remembers an artifact; the same name again replaces it.
    pub(super) fn add(&self, artifact: &ArtifactRef) {
        let mut list = self.0.lock().expect("no code panics while it holds this lock");
        list.retain(|kept| kept.name != artifact.name);
        list.push(FileRow {
            name: artifact.name.clone(),
            digest: artifact.digest.clone(),
            media_type: artifact.media_type.clone(),
            size: artifact.size,
        });
    }

    /// By name, so that the order in which threads finished does not show.
    pub(super) fn sorted(&self) -> Vec<FileRow> {
        let mut list = self.0.lock().expect("no code panics while it holds this lock").clone();
        list.sort_by(|a, b| a.name.cmp(&b.name));
        list
    }
}

/// `[a-z0-9_.-]+` parts joined by `/`, none of them starting with a dot.
pub(super) fn is_valid_name(name: &str) -> bool {
    name.len() <= 200
        && name.split('/').all(|part| {
            !part.is_empty()
                && !part.starts_with('.')
                && part
                    .bytes()
                    .all(|b| b.is_ascii_lowercase() || b.is_ascii_digit() || matches!(b, b'_' | b'.' | b'-'))
        })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_stay_inside_their_folder() {
        assert!(is_valid_name("known.json") && is_valid_name("masks/mug_1.png"));
        for bad in ["", "../up", "a//b", "/root", "a b", ".hidden", "Mug.png"] {
            assert!(!is_valid_name(bad), "{bad:?}");
        }
    }
}
