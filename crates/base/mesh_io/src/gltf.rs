//! Binary glTF 2.0 (GLB): writers of one mesh and of a scene, and a reader.
//!
//! glTF is Y-up. Meshes are stored as authored (z up) under a root node that rotates them
//! ([`ROOT_ROTATION_XYZW`]): front (-y) becomes glTF's +Z. Texture images are stored with their rows
//! reversed instead of flipping v, because `1 - v` does not round-trip exactly.

mod document;
mod exact;
mod read;
mod write;

pub use exact::reads_back_equal;
pub use read::{GltfError, read_mesh_glb};
pub use write::{SceneNode, write_mesh_glb, write_mesh_glb_with_extras, write_scene_glb};

/// `gltf_from_world`: a quarter turn about -x takes z up to y up.
pub const ROOT_ROTATION_XYZW: [f64; 4] =
    [-std::f64::consts::FRAC_1_SQRT_2, 0.0, 0.0, std::f64::consts::FRAC_1_SQRT_2];
