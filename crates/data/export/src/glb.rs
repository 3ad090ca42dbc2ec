//! `glb/`: one file per body in its own frame, and one for the whole scene.
//!
//! Nodes of the scene have the label among their extras, those of stand-ins also the mark (`stand_in`). The root of a
//! stand-in's own file has the same extras.

use rayon::prelude::*;
use serde_json::{Value, json};

use super::body::STAND_IN;
use super::{Body, BundleFile};
use mesh_io::gltf::{SceneNode, write_mesh_glb_with_extras, write_scene_glb};

/// `glb/<name>.glb` for every body and `glb/scene.glb`.
pub fn write(bodies: &[Body]) -> Vec<BundleFile> {
    let nodes: Vec<SceneNode<'_>> = bodies
        .iter()
        .map(|body| SceneNode {
            name: &body.name,
            extras: extras(body),
            mesh: &body.visual,
            parent: None,
            parent_from_node: body.world_from_object,
        })
        .collect();
    let media_type = "model/gltf-binary";
    let scene = BundleFile::new("glb/scene.glb", write_scene_glb(&nodes), "glb_scene", media_type);
    let mut files: Vec<BundleFile> = bodies
        .par_iter()
        .map(|body| {
            let path = format!("glb/{}.glb", body.name);
            let mesh =
                write_mesh_glb_with_extras(&body.visual, body.stand_in.is_some().then(|| extras(body)));
            BundleFile::new(path, mesh, "glb_mesh", media_type)
        })
        .collect();
    files.push(scene);
    files
}

fn extras(body: &Body) -> Value {
    let mut extras = json!({ "label": body.label });
    for (mark, value) in body.marks() {
        extras[mark] = if mark == STAND_IN { true.into() } else { value.into() };
    }
    extras
}
