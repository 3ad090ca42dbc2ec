//! Resources of stages besides their inputs: the ports, the device, and the artifacts that this job has decoded.

use std::collections::HashMap;
use std::sync::{Arc, Mutex};

use geometry::TexturedMesh;
use geometry::solid_query::MeshSolid;
use gpu::Compute;
use imaging::Image;
use ports::{ImageAnnotations, Ports};
use store::Digest;

/// Shared by all stages of one job.
pub struct StageResources {
    /// The adapters of the configuration, from `app::pipeline::build_pipeline`: those of `embedded::ports`, and remote
    /// ones of `app::remote`.
    pub ports: Ports,
    /// Compute device. Its kind changes results: stages that use it have its name in their inputs.
    pub compute: Arc<Compute>,
    pub(super) decoded: DecodeCache,
}

impl StageResources {
    pub fn new(ports: Ports, compute: Arc<Compute>) -> Self {
        Self { ports, compute, decoded: DecodeCache::default() }
    }

    /// Name of the GPU, if there is one that is to be used. The first time drivers are loaded.
    pub async fn gpu_name(&self) -> Option<String> {
        let compute = self.compute.clone();
        let looking = tokio::task::spawn_blocking(move || compute.gpu().map(|gpu| gpu.name().to_owned()));
        looking.await.ok().flatten()
    }
}

/// Artifacts by the digest of their bytes, so that stages decode what others have made or decoded at most once. Bytes
/// named by content always decode to the same value, so this changes no result.
#[derive(Default)]
pub(super) struct DecodeCache {
    pub meshes: Cache<TexturedMesh>,
    /// Of the meshes with these digests.
    pub solids: Cache<MeshSolid>,
    pub images: Cache<Image>,
    /// Annotations of the image generator by image.
    pub known: Cache<ImageAnnotations>,
}

/// Values of one kind.
pub(super) struct Cache<T>(Mutex<HashMap<Digest, Arc<T>>>);

impl<T> Default for Cache<T> {
    fn default() -> Self {
        Self(Mutex::default())
    }
}

impl<T> Cache<T> {
    pub(super) fn find(&self, digest: &Digest) -> Option<Arc<T>> {
        self.0.lock().ok()?.get(digest).cloned()
    }

    pub(super) fn keep(&self, digest: &Digest, value: &Arc<T>) {
        if let Ok(mut values) = self.0.lock() {
            values.insert(digest.clone(), value.clone());
        }
    }
}
