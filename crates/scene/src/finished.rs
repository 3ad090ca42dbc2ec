//! The finished scene: the one value every format is written from.

use serde::{Deserialize, Serialize};

use super::{Certificate, Instance, SceneRequest, Table};
use crate::certificate::Metrics;
use geometry::Camera;

/// `scene.json`. Meshes and hulls travel beside it (see `export::Assets`).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Scene {
    /// `tabletopgen-scene/1`.
    pub format: String,
    /// Digest of request, seed, resolved settings and version.
    pub id: String,
    pub seed: u64,
    pub request: SceneRequest,
    pub frame: Frame,
    /// Camera of the reference picture.
    pub camera: Camera,
    pub table: Table,
    /// The table is not among them.
    pub instances: Vec<Instance>,
    pub metrics: Metrics,
}

/// The conventions of every file of a bundle.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Frame {
    pub up: String,
    pub handedness: String,
    pub origin: String,
    pub units: String,
}

impl Frame {
    /// Right-handed, z up, meters, origin at the center of the table top.
    pub fn world() -> Self {
        Self {
            up: "+z".into(),
            handedness: "right".into(),
            origin: "center of the table top's bounding box, z = 0 at the surface".into(),
            units: "meters, kilograms, seconds, radians".into(),
        }
    }
}

impl Scene {
    pub const FORMAT: &str = "tabletopgen-scene/1";
}

/// A scene with its certificate: what `bundle` packs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CertifiedScene {
    pub scene: Scene,
    pub certificate: Certificate,
}
