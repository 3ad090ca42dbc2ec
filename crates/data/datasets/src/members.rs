//! The files of one scene in a shard: WebDataset groups files whose names are equal up to the first dot.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::bundle::{Bundle, sha256};
use crate::error::DatasetError;

/// Extension of the bundle archive, which every scene has.
pub const ARCHIVE: &str = "zip";

/// Extensions of single files of the bundle, and their paths in it. A bundle without an image has no such member.
pub const COPIES: [(&str, &str); 3] =
    [("hero.png", "preview/hero.png"), ("json", "scene.json"), ("top.png", "preview/top.png")];

/// Members of a scene, by extension.
pub type Members = BTreeMap<String, MemberEntry>;

/// Size and digest of a member.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct MemberEntry {
    pub size: u64,
    pub sha256: String,
}

impl MemberEntry {
    pub fn of(bytes: &[u8]) -> Self {
        Self { size: bytes.len() as u64, sha256: sha256(bytes) }
    }
}

/// The members of a scene with their content, by extension: all that is held in memory at once.
///
/// # Errors
///
/// [`DatasetError`] if a file of the bundle is damaged.
pub fn read(bundle: &mut Bundle) -> Result<BTreeMap<String, Vec<u8>>, DatasetError> {
    let mut members = BTreeMap::from([(ARCHIVE.to_owned(), bundle.archive()?)]);
    for (extension, path) in COPIES {
        if bundle.entries().contains_key(path) {
            members.insert(extension.to_owned(), bundle.read(path)?);
        }
    }
    Ok(members)
}
