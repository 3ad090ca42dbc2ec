//! Geometry and images that the writers take beside the scene, and the files they return.

use std::collections::BTreeMap;

use serde::Serialize;

use geometry::parallel_grasp::ParallelGrasp;
use geometry::{ConvexHull, TexturedMesh};

use super::ExportError;

/// Geometry of one body, in the object's frame, meters.
#[derive(Clone, Debug, PartialEq)]
pub struct BodyAsset {
    pub name: String,
    pub label: String,
    pub category: String,
    pub visual: TexturedMesh,
    pub hulls: Vec<ConvexHull>,
    /// Wikidata item of the object or of its class: `Q` and digits.
    pub wikidata_item: String,
    /// Main material: a name of `config/materials.toml`.
    pub substance: String,
    /// A grasp of a parallel gripper, if one is known.
    pub grasp: Option<ParallelGrasp>,
    /// Resistance to rolling: torque over normal force, meters.
    pub rolling_friction_m: f64,
    /// Resistance to spinning about the contact normal: torque over normal force, meters.
    pub torsional_friction_m: f64,
}

/// Geometry of all bodies of a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Assets {
    /// In the world frame: top surface at z = 0, feet at -height.
    pub table: BodyAsset,
    /// In the order of `scene.instances`.
    pub instances: Vec<BodyAsset>,
}

/// PNG images of the scene. An empty entry is left out of the bundle.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Images {
    /// Perspective view of the scene.
    pub hero_png: Vec<u8>,
    /// Top view.
    pub top_png: Vec<u8>,
    /// Side views, by name (`front`, `right`, `back`, `left`).
    pub sides_png: Vec<(String, Vec<u8>)>,
    /// The reference image.
    pub reference_png: Vec<u8>,
    /// Side by side: the reference image, the scene from the same camera, and their overlap.
    pub beside_png: Vec<u8>,
    /// 256 x 256 pixels, by body name.
    pub thumbnails: BTreeMap<String, Vec<u8>>,
}

impl Images {
    /// The files under `preview/`.
    pub fn files(&self) -> Vec<BundleFile> {
        let named = [
            ("hero", &self.hero_png),
            ("top", &self.top_png),
            ("reference", &self.reference_png),
            ("reference_beside_scene", &self.beside_png),
        ];
        let sides = self.sides_png.iter().map(|(name, png)| (name.as_str(), png));
        named
            .into_iter()
            .map(|(name, png)| (name.to_owned(), png))
            .chain(sides.map(|(name, png)| (format!("side_{name}"), png)))
            .filter(|(_, png)| !png.is_empty())
            .map(|(name, png)| BundleFile::png(format!("preview/{name}.png"), png.clone(), "preview"))
            .collect()
    }
}

/// One file of a bundle.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BundleFile {
    /// Relative, with forward slashes.
    pub path: String,
    pub bytes: Vec<u8>,
    /// Role in the bundle (`usd_stage`, `urdf_hull`), as in `manifest.json`.
    pub role: String,
    pub media_type: String,
}

impl BundleFile {
    pub fn new(path: impl Into<String>, bytes: Vec<u8>, role: &str, media_type: &str) -> Self {
        Self { path: path.into(), bytes, role: role.to_owned(), media_type: media_type.to_owned() }
    }

    pub fn text(path: impl Into<String>, text: String, role: &str, media_type: &str) -> Self {
        Self::new(path, text.into_bytes(), role, media_type)
    }

    pub fn png(path: impl Into<String>, bytes: Vec<u8>, role: &str) -> Self {
        Self::new(path, bytes, role, "image/png")
    }

    /// Indented JSON with a final newline.
    pub fn json(path: &str, value: &impl Serialize, role: &str) -> Result<Self, ExportError> {
        let mut bytes = serde_json::to_vec_pretty(value)?;
        bytes.push(b'\n');
        Ok(Self::new(path, bytes, role, "application/json"))
    }
}
