//! Port 4, the mesh generator: a textured mesh from the clean picture of an instance. The paper asks
//! Hunyuan3D-3.0.

use super::{Adapter, Answer, Call, Completion};
use geometry::{Camera, Outline, TexturedMesh};
use scene::{RecognizedObject, RecognizedTable, ReconstructionMethod};

/// Makes meshes.
pub trait MeshGenerator: Send + Sync {
    fn adapter(&self) -> Adapter;

    /// The instance as a mesh of unit size (its longest edge is 1) in any of the 24 axis-aligned
    /// orientations.
    fn reconstruct<'a>(&'a self, call: &'a Call, request: ReconstructionRequest) -> Answer<'a, RawMesh>;

    /// The table at its commonsense size.
    fn table<'a>(&'a self, call: &'a Call, table: RecognizedTable) -> Answer<'a, RawTable>;
}

/// A table as generated: upright and metric, since tables come as models and not from pictures alone.
#[derive(Clone, Debug, PartialEq)]
pub struct RawTable {
    /// World frame: top surface at z = 0, feet at -height.
    pub mesh: TexturedMesh,
    /// Edge of the top surface.
    pub outline_m: Outline,
    pub made_by: String,
    /// SPDX identifier.
    pub licence: String,
}

/// One instance to be made a mesh of.
#[derive(Clone)]
pub struct ReconstructionRequest {
    pub object: RecognizedObject,
    pub completion: Completion,
    /// Of the reference picture.
    pub camera: Camera,
    /// The reference picture was painted by a painter of ours, so that labels name catalog categories.
    pub painted: bool,
    /// Draws what the picture leaves open, and the orientation.
    pub seed: u64,
}

/// A mesh as generated.
#[derive(Clone, Debug, PartialEq)]
pub struct RawMesh {
    pub mesh: TexturedMesh,
    pub method: ReconstructionMethod,
    /// `embedded/catalog`, with the model where there is one.
    pub made_by: String,
    /// SPDX identifier.
    pub licence: String,
    /// What a reader of the scene should know ("back side mirrored").
    pub notes: Vec<String>,
}
