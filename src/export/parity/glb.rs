//! Reads the GLB files: each mesh must come back equal, the scene's vertices at their poses.

use crate::export::gltf::read_mesh_glb;
use crate::export::{Body, ExportError};

use super::{Files, MeshParity, Tolerances, one_digit_up};

pub fn compare(bodies: &[Body], files: &Files<'_>) -> Result<MeshParity, ExportError> {
    let format = "GLB";
    let read = |path: &str| {
        let bytes = files.bytes(path).map_err(|reason| ExportError::Unreadable { format, reason })?;
        read_mesh_glb(bytes)
            .map_err(|error| ExportError::Unreadable { format, reason: format!("{path}: {error}") })
    };
    let differs = |difference: String| Err(ExportError::Parity { format, difference });
    for body in bodies {
        if read(&format!("glb/{}.glb", body.name))? != body.visual {
            return differs(format!("the mesh of {}", body.name));
        }
    }
    let scene = read("glb/scene.glb")?;
    let vertices: usize = bodies.iter().map(|body| body.visual.positions.len()).sum();
    let triangles: usize = bodies.iter().map(|body| body.visual.triangle_count()).sum();
    if scene.positions.len() != vertices || scene.triangle_count() != triangles {
        return differs(format!("{} vertices instead of {vertices}", scene.positions.len()));
    }
    let expected = bodies.iter().flat_map(|body| {
        body.visual.positions.iter().map(|position| body.world_from_object.transform_point(*position))
    });
    let vertex_m = expected.zip(&scene.positions).map(|(a, b)| (a - *b).length()).fold(0.0, f64::max);
    if vertex_m > Tolerances::LENGTH_M {
        return differs(format!("a vertex of the scene by {vertex_m} m"));
    }
    Ok(MeshParity { meshes: bodies.len(), vertex_m: one_digit_up(vertex_m) })
}
