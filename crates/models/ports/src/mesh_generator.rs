//! Port 4, the mesh generator: a textured mesh from the completed image of an instance. The paper uses Hunyuan3D-3.0.

use std::sync::Arc;

use super::{Adapter, Answer, Call, Completion};
use geometry::{Camera, Outline, TexturedMesh};
use imaging::{Image, Mask};
use scene::{RecognizedObject, RecognizedTable, ReconstructionMethod};

/// Generates meshes.
pub trait MeshGenerator: Send + Sync {
    fn adapter(&self) -> Adapter;

    /// The instance as a mesh of unit size (its longest edge is 1) in any of the 24 axis-aligned
    /// orientations.
    fn reconstruct<'a>(&'a self, call: &'a Call, request: ReconstructionRequest) -> Answer<'a, RawMesh>;

    /// The table at its commonsense size.
    fn table<'a>(&'a self, call: &'a Call, request: TableRequest) -> Answer<'a, RawTable>;
}

/// The table to make.
#[derive(Clone)]
pub struct TableRequest {
    pub table: RecognizedTable,
    /// The photograph that it was recognized in; `None` for images of the embedded generator, and without an image.
    pub photograph: Option<TablePhotograph>,
}

/// A photograph of a table.
#[derive(Clone)]
pub struct TablePhotograph {
    pub image: Arc<Image>,
    /// The camera of the image; world frame = center of the top.
    pub camera: Camera,
    /// Pixels, as large as the image, that may show the bare top.
    pub bare_top: Mask,
}

/// A generated table: upright and metric, since tables are catalog models and not reconstructions.
#[derive(Clone, Debug, PartialEq)]
pub struct RawTable {
    /// World frame: top surface at z = 0, feet at -height.
    pub mesh: TexturedMesh,
    /// Outline of the top surface.
    pub outline_m: Outline,
    pub made_by: String,
    /// SPDX identifier.
    pub licence: String,
}

/// The instance to reconstruct.
#[derive(Clone)]
pub struct ReconstructionRequest {
    pub object: RecognizedObject,
    pub completion: Completion,
    /// The camera of the reference image.
    pub camera: Camera,
    /// Whether the reference image was rendered by the embedded generator, so that labels name catalog categories.
    pub rendered: bool,
    /// Seed of the properties that the image leaves open, and of the orientation.
    pub seed: u64,
}

/// A generated mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct RawMesh {
    pub mesh: TexturedMesh,
    pub method: ReconstructionMethod,
    /// `embedded/catalog`, with the model where there is one.
    pub made_by: String,
    /// SPDX identifier.
    pub licence: String,
    /// Notes for users of the scene ("back side mirrored").
    pub notes: Vec<String>,
}
