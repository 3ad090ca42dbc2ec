//! What stages are handed besides their inputs: the ports, and what this job has decoded already.

use std::collections::HashMap;
use std::sync::{Arc, Mutex};

use crate::geometry::{Image, TexturedMesh};
use crate::provider::Ports;
use crate::store::Digest;

/// Shared by all stages of one job.
pub struct Services {
    pub ports: Ports,
    pub(super) decoded: Decoded,
}

impl Services {
    pub fn new(ports: Ports) -> Self {
        Self { ports, decoded: Decoded::default() }
    }
}

/// Meshes and pictures by the digest of their bytes, so that six stages decode a mesh once. Bytes named
/// by content always decode to the same value, so this changes no result.
#[derive(Default)]
pub(super) struct Decoded {
    meshes: Mutex<HashMap<String, Arc<TexturedMesh>>>,
    pictures: Mutex<HashMap<String, Arc<Image>>>,
}

impl Decoded {
    pub(super) fn mesh(&self, digest: &Digest) -> Option<Arc<TexturedMesh>> {
        self.meshes.lock().ok()?.get(digest.as_str()).cloned()
    }

    pub(super) fn keep_mesh(&self, digest: &Digest, mesh: &Arc<TexturedMesh>) {
        if let Ok(mut meshes) = self.meshes.lock() {
            meshes.insert(digest.as_str().to_owned(), mesh.clone());
        }
    }

    pub(super) fn picture(&self, digest: &Digest) -> Option<Arc<Image>> {
        self.pictures.lock().ok()?.get(digest.as_str()).cloned()
    }

    pub(super) fn keep_picture(&self, digest: &Digest, picture: &Arc<Image>) {
        if let Ok(mut pictures) = self.pictures.lock() {
            pictures.insert(digest.as_str().to_owned(), picture.clone());
        }
    }
}
