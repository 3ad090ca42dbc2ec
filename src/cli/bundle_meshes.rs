//! The meshes of a bundle's scene.

use super::Failure;
use super::bundle_input::BundleInput;
use geometry::{Pose, TexturedMesh};
use mesh_io::gltf::read_mesh_glb;
use scene::Scene;

/// The meshes of a scene with their poses in the world, the table's first.
///
/// # Errors
///
/// A [`Failure`] of kind usage where a mesh is missing, was changed or cannot be read.
pub fn bundle_meshes(bundle: &BundleInput, scene: &Scene) -> Result<Vec<(TexturedMesh, Pose)>, Failure> {
    let objects = scene.instances.iter().map(|object| (object.mesh.as_str(), object.world_from_object));
    std::iter::once((scene.table.mesh.as_str(), Pose::IDENTITY))
        .chain(objects)
        .map(|(mesh, pose)| {
            let read = read_mesh_glb(&bundle.file(mesh)?);
            let unreadable =
                |error| Failure::usage(format!("cannot read the mesh {mesh} of the bundle: {error}"));
            Ok((read.map_err(unreadable)?, pose))
        })
        .collect()
}
