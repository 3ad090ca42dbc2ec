//! `glb/`: one file per body in its own frame, and one for the whole scene.

use rayon::prelude::*;

use super::{Body, BundleFile};
use mesh_io::gltf::{SceneNode, write_mesh_glb, write_scene_glb};

/// `glb/<name>.glb` for every body and `glb/scene.glb`.
pub fn write(bodies: &[Body]) -> Vec<BundleFile> {
    let nodes: Vec<SceneNode<'_>> = bodies
        .iter()
        .map(|body| SceneNode {
            name: &body.name,
            label: &body.label,
            mesh: &body.visual,
            world_from_object: body.world_from_object,
        })
        .collect();
    let media_type = "model/gltf-binary";
    let scene = BundleFile::new("glb/scene.glb", write_scene_glb(&nodes), "glb_scene", media_type);
    let mut files: Vec<BundleFile> = bodies
        .par_iter()
        .map(|body| {
            let path = format!("glb/{}.glb", body.name);
            BundleFile::new(path, write_mesh_glb(&body.visual), "glb_mesh", media_type)
        })
        .collect();
    files.push(scene);
    files
}
