//! The id of a scene before it is made: the digest of everything that decides its bytes.

use serde::Serialize;
use serde_json::json;

use super::Settings;
use super::error::StageError;
use certificate::{AdapterUsed, MadeWith};
use ports::{Adapter, Ports};
use scene::SceneRequest;
use store::Digest;

/// The scene's id, from everything that decides its bytes.
#[derive(Clone, Debug, Serialize)]
pub struct SceneIdentity {
    pub(super) id: String,
    pub(super) request: SceneRequest,
    pub(super) made_with: MadeWith,
}

impl SceneIdentity {
    /// Digest of request, adapters, settings and version.
    pub fn new(request: &SceneRequest, ports: &Ports, settings: &Settings) -> Result<Self, StageError> {
        let adapters = [
            ports.analyst.adapter(),
            ports.image_generator.adapter(),
            ports.segmenter.adapter(),
            ports.mesh_generator.adapter(),
            ports.feature_extractor.adapter(),
        ];
        let ports = ["SceneAnalyst", "Painter", "Segmenter", "MeshGenerator", "FeatureExtractor"];
        let mut settings = serde_json::to_value(settings).unwrap_or_default();
        if let (None, Some(sections)) = (&request.options.robot, settings.as_object_mut()) {
            // Without a robot they decide nothing.
            for section in ["grasps", "execution"] {
                sections.shift_remove(section);
            }
        }
        let decides = json!({
            "request": request, "adapters": adapters, "settings": settings,
            "version": env!("CARGO_PKG_VERSION"),
        });
        let digest = Digest::of(decides.to_string().as_bytes());
        let used = |(port, adapter): (&str, &Adapter)| AdapterUsed {
            port: port.to_owned(),
            name: adapter.name.clone(),
            model: adapter.model.clone(),
        };
        let made_with = MadeWith {
            version: env!("CARGO_PKG_VERSION").to_owned(),
            adapters: ports.into_iter().zip(&adapters).map(used).collect(),
            settings,
        };
        Ok(Self { id: digest.as_str()[..20].to_owned(), request: request.clone(), made_with })
    }
}
