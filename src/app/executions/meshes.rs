//! The meshes of a bundle.

use crate::problem::{Problem, ProblemType};
use export::archive::wanted_files;
use geometry::TexturedMesh;
use mesh_io::gltf::read_mesh_glb;

/// The meshes of these bodies of a bundle's archive, in their order; `table` is that of the table.
///
/// # Errors
///
/// A [`Problem`] for a bundle without one of them.
pub fn scene_meshes(archive: &[u8], names: &[&str]) -> Result<Vec<TexturedMesh>, Problem> {
    let broken = |why: String| {
        let detail = format!("reading the meshes of the bundle: {why}");
        Problem::new(ProblemType::Conflict, "bundle_unreadable", detail)
    };
    let is_wanted = |path: &str| path.starts_with("glb/") && path != "glb/scene.glb";
    let mut files = wanted_files(archive, is_wanted).map_err(|error| broken(error.to_string()))?;
    let meshes = names.iter().map(|name| {
        let bytes = files.remove(&format!("glb/{name}.glb"));
        let bytes = bytes.ok_or_else(|| broken(format!("it has no mesh of {name}")))?;
        read_mesh_glb(&bytes).map_err(|error| broken(error.to_string()))
    });
    meshes.collect()
}
