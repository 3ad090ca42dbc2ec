//! Reads the GLB files. The mesh of each body must be equal to the scene's; the nodes of the scene file must have the
//! names and poses of the bodies, and its vertices the transformed positions.

use std::collections::BTreeMap;

use glam::{DQuat, DVec3};
use serde::Deserialize;

use crate::{Body, ExportError};
use geometry::Pose;
use mesh_io::gltf::{ROOT_ROTATION_XYZW, read_mesh_glb};
use scene::StandIn;

use super::{
    Difference, Files, MeshDeviation, ReadError, ReadResult, Tolerances, angle_between_rad,
    ceil_to_power_of_ten, larger,
};

pub fn compare(bodies: &[Body], files: &Files<'_>) -> Result<MeshDeviation, ExportError> {
    let format = "GLB";
    let unreadable = |reason| ExportError::unreadable(format, reason);
    let read = |path: &str| {
        let bytes = files.bytes(path).map_err(unreadable)?;
        read_mesh_glb(bytes).map_err(|error| unreadable(ReadError::from(error).within(path)))
    };
    let differs = |difference| Err(ExportError::mismatch(format, difference));
    for body in bodies {
        if read(&format!("glb/{}.glb", body.name))? != body.visual {
            return differs(Difference::Mesh(body.name.clone()));
        }
    }
    let scene = read("glb/scene.glb")?;
    let vertices: usize = bodies.iter().map(|body| body.visual.positions.len()).sum();
    let triangles: usize = bodies.iter().map(|body| body.visual.triangle_count()).sum();
    if scene.positions.len() != vertices || scene.triangle_count() != triangles {
        let found = scene.positions.len();
        return differs(Difference::Count { found, of: "vertices".to_owned(), wanted: vertices });
    }
    let expected = bodies.iter().flat_map(|body| {
        body.visual.positions.iter().map(|position| body.world_from_object.transform_point(*position))
    });
    let vertex_m = expected.zip(&scene.positions).map(|(a, b)| (a - *b).length()).fold(0.0, f64::max);
    let limits = Tolerances::BUNDLE;
    if vertex_m.is_nan() || vertex_m > limits.vertex_m {
        return differs(Difference::SceneVertex { off_m: vertex_m });
    }
    let nodes = nodes(files).map_err(unreadable)?;
    if nodes.len() != bodies.len() {
        let (found, wanted) = (nodes.len(), bodies.len());
        return differs(Difference::Count { found, of: "nodes".to_owned(), wanted });
    }
    let (mut translation_m, mut rotation_rad) = (0.0, 0.0);
    for body in bodies {
        let Some(node) = nodes.get(&body.name) else {
            return differs(Difference::NoNode(body.name.clone()));
        };
        let (found, pose) = (node.pose(), body.world_from_object);
        translation_m = larger(translation_m, (found.translation_m - pose.translation_m).length());
        rotation_rad = larger(rotation_rad, angle_between_rad(found.rotation, pose.rotation));
        let sound = translation_m <= limits.translation_m && rotation_rad <= limits.rotation_rad;
        if !sound {
            let body = body.name.clone();
            return differs(Difference::Pose { body, translation_m, rotation_rad });
        }
    }
    Ok(MeshDeviation {
        meshes: bodies.len(),
        translation_m: ceil_to_power_of_ten(translation_m),
        rotation_rad: ceil_to_power_of_ten(rotation_rad),
        vertex_m: ceil_to_power_of_ten(vertex_m),
    })
}

/// Marks of the bodies that the scene file has as stand-ins, by name.
pub fn stand_ins(files: &Files<'_>) -> ReadResult<BTreeMap<String, StandIn>> {
    let nodes = nodes(files)?.into_iter();
    Ok(nodes.filter_map(|(name, node)| Some((name, node.extras?.stand_in?))).collect())
}

/// The mark of a file's root, where it is a stand-in.
pub fn root_stand_in(files: &Files<'_>, path: &str) -> ReadResult<Option<StandIn>> {
    let document = document(files, path)?;
    Ok(document.root()?.extras.as_ref().and_then(|extras| extras.stand_in.clone()))
}

/// Labels of the bodies in the scene file, by name.
pub fn labels(files: &Files<'_>) -> ReadResult<BTreeMap<String, String>> {
    let nodes = nodes(files)?.into_iter();
    Ok(nodes.map(|(name, node)| (name, node.extras.map(|extras| extras.label).unwrap_or_default())).collect())
}

/// A node of the document; absent parts of its pose are the identity.
#[derive(Deserialize)]
struct Node {
    #[serde(default)]
    name: String,
    #[serde(default)]
    translation: [f64; 3],
    #[serde(default = "identity_rotation")]
    rotation: [f64; 4],
    scale: Option<[f64; 3]>,
    matrix: Option<Vec<f64>>,
    extras: Option<Extras>,
    #[serde(default)]
    children: Vec<usize>,
}

#[derive(Deserialize)]
struct Extras {
    label: String,
    #[serde(flatten, with = "scene::stand_in::fields")]
    stand_in: Option<StandIn>,
}

fn identity_rotation() -> [f64; 4] {
    [0.0, 0.0, 0.0, 1.0]
}

impl Node {
    fn pose(&self) -> Pose {
        Pose {
            translation_m: DVec3::from_array(self.translation),
            rotation: DQuat::from_array(self.rotation).normalize(),
        }
    }

    fn is_scaled(&self) -> bool {
        self.matrix.is_some() || self.scale.is_some_and(|scale| scale != [1.0; 3])
    }
}

#[derive(Deserialize)]
struct Document {
    nodes: Vec<Node>,
    scenes: Vec<Scene>,
}

#[derive(Deserialize)]
struct Scene {
    nodes: Vec<usize>,
}

impl Document {
    /// The single root.
    fn root(&self) -> ReadResult<&Node> {
        let roots = match self.scenes.as_slice() {
            [Scene { nodes }] => nodes.as_slice(),
            _ => &[],
        };
        let &[root] = roots else { return Err(ReadError::NotOneRoot) };
        self.nodes.get(root).ok_or_else(|| ReadError::missing("the root"))
    }
}

/// The JSON chunk of a file.
fn document(files: &Files<'_>, path: &str) -> ReadResult<Document> {
    let bytes = files.bytes(path)?;
    // Header of 12 bytes, then length and kind of the JSON chunk.
    let length =
        bytes.get(12..16).map(|length| u32::from_le_bytes([length[0], length[1], length[2], length[3]]));
    let json = length.and_then(|length| bytes.get(20..20 + length as usize));
    let json = json.ok_or_else(|| ReadError::Absent("JSON chunk".to_owned()))?;
    Ok(serde_json::from_slice(json)?)
}

/// The nodes of the scene file below its single root, which rotates z up to y up.
fn nodes(files: &Files<'_>) -> ReadResult<BTreeMap<String, Node>> {
    let document = document(files, "glb/scene.glb")?;
    let root_node = document.root()?;
    if document.nodes.iter().any(Node::is_scaled) {
        return Err(ReadError::wrong("a node", "is scaled"));
    }
    let expected = Pose { translation_m: DVec3::ZERO, rotation: DQuat::from_array(ROOT_ROTATION_XYZW) };
    if root_node.translation != [0.0; 3]
        || angle_between_rad(root_node.pose().rotation, expected.rotation) > 1e-9
    {
        return Err(ReadError::wrong("the root", "does not turn z up to y up"));
    }
    let children = root_node.children.clone();
    let below = document.nodes.into_iter().enumerate().filter(|(index, _)| children.contains(index));
    Ok(below.map(|(_, node)| (node.name.clone(), node)).collect())
}
