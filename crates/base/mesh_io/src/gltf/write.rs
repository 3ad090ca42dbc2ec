//! Writes GLB: header, JSON chunk, one binary chunk.
//!
//! Every face group becomes a primitive; the primitives of a mesh share its vertex arrays. Equal
//! textures and equal meshes are stored once. Groups without triangles are left out.

use geometry::{Material, Pose, TexturedMesh};
use imaging::{GreenAxis, Texture};

use super::ROOT_ROTATION_XYZW;
use super::document as doc;

/// A GLB file with one mesh in its own frame, under the root rotation. [`super::read_mesh_glb`] returns an
/// equal mesh if it has a triangle, no empty group, and positions that are exact in single precision.
pub fn write_mesh_glb(mesh: &TexturedMesh) -> Vec<u8> {
    write_mesh_glb_with_extras(mesh, None)
}

/// As [`write_mesh_glb`], with extras of the root node.
pub fn write_mesh_glb_with_extras(mesh: &TexturedMesh, extras: Option<serde_json::Value>) -> Vec<u8> {
    let mut file = GlbFile::default();
    let mesh = file.add_mesh("mesh", mesh);
    let root = doc::Node {
        name: Some("root".to_owned()),
        mesh,
        rotation: Some(ROOT_ROTATION_XYZW),
        extras,
        ..doc::Node::default()
    };
    file.document.nodes.push(root);
    file.finish(0)
}

/// One body of a scene file, or one link of a robot's.
pub struct SceneNode<'a> {
    pub name: &'a str,
    /// Data of the application.
    pub extras: serde_json::Value,
    pub mesh: &'a TexturedMesh,
    /// Index of the node that carries this one, which is lower; the world carries it where it is absent.
    pub parent: Option<usize>,
    pub parent_from_node: Pose,
}

/// A GLB file with all nodes at their poses, under the root rotation.
///
/// # Panics
/// Where a parent does not come before its children.
pub fn write_scene_glb(nodes: &[SceneNode<'_>]) -> Vec<u8> {
    let mut file = GlbFile::default();
    let mut children = Vec::new();
    let mut written: Vec<(&TexturedMesh, Option<usize>)> = Vec::new();
    for node in nodes {
        let mesh = match written.iter().find(|(known, _)| *known == node.mesh) {
            Some(&(_, mesh)) => mesh,
            None => {
                let mesh = file.add_mesh(node.name, node.mesh);
                written.push((node.mesh, mesh));
                mesh
            }
        };
        let index = file.document.nodes.len();
        match node.parent {
            Some(parent) => file.document.nodes[parent].children.push(index),
            None => children.push(index),
        }
        file.document.nodes.push(doc::Node {
            name: Some(node.name.to_owned()),
            mesh,
            translation: Some(node.parent_from_node.translation_m.to_array()),
            rotation: Some(node.parent_from_node.rotation.normalize().to_array()),
            extras: Some(node.extras.clone()),
            ..doc::Node::default()
        });
    }
    let root = file.document.nodes.len();
    file.document.nodes.push(doc::Node {
        name: Some("root".to_owned()),
        rotation: Some(ROOT_ROTATION_XYZW),
        children,
        ..doc::Node::default()
    });
    file.finish(root)
}

#[derive(Default)]
struct GlbFile {
    document: doc::Document,
    binary: Vec<u8>,
    textures: Vec<Texture>,
}

impl GlbFile {
    fn add_mesh(&mut self, name: &str, mesh: &TexturedMesh) -> Option<usize> {
        let materials: Vec<usize> = mesh.materials.iter().map(|m| self.add_material(m)).collect();
        let groups: Vec<_> = mesh.groups.iter().filter(|group| !group.triangles.is_empty()).collect();
        if groups.is_empty() || mesh.positions.is_empty() {
            return None;
        }
        let positions: Vec<[f32; 3]> = mesh.positions.iter().map(|p| p.as_vec3().to_array()).collect();
        let (mut low, mut high) = (positions[0], positions[0]);
        for position in &positions {
            for axis in 0..3 {
                low[axis] = low[axis].min(position[axis]);
                high[axis] = high[axis].max(position[axis]);
            }
        }
        let position = self.add_accessor(&floats(&positions), doc::FLOAT, "VEC3", positions.len(), true);
        self.document.accessors[position].min = Some(low.map(f64::from).to_vec());
        self.document.accessors[position].max = Some(high.map(f64::from).to_vec());
        let normals: Vec<[f32; 3]> = mesh.normals.iter().map(|n| n.to_array()).collect();
        let normal = self.add_accessor(&floats(&normals), doc::FLOAT, "VEC3", normals.len(), true);
        let uvs: Vec<[f32; 2]> = mesh.uvs.iter().map(|uv| uv.to_array()).collect();
        let texcoord = self.add_accessor(&floats(&uvs), doc::FLOAT, "VEC2", uvs.len(), true);
        let attributes =
            doc::Attributes { position: Some(position), normal: Some(normal), texcoord: Some(texcoord) };
        let primitives = groups
            .into_iter()
            .map(|group| {
                let corners = group.triangles.as_flattened();
                let bytes: Vec<u8> = corners.iter().flat_map(|v| v.to_le_bytes()).collect();
                let indices = self.add_accessor(&bytes, doc::UNSIGNED_INT, "SCALAR", corners.len(), false);
                doc::Primitive {
                    attributes: attributes.clone(),
                    indices: Some(indices),
                    material: materials.get(group.material).copied(),
                    mode: Some(doc::TRIANGLES),
                }
            })
            .collect();
        self.document.meshes.push(doc::Mesh { name: Some(name.to_owned()), primitives });
        Some(self.document.meshes.len() - 1)
    }

    fn add_material(&mut self, material: &Material) -> usize {
        let texture = material.base_color_texture.as_ref().map(|texture| self.add_texture(texture));
        // The file has the image upside down, and up in the file is where green points.
        let normals = material.normal_map(GreenAxis::Down).map(|map| self.add_texture(&map));
        let reference = |index: usize| doc::TextureReference { index, tex_coord: None };
        let [r, g, b] = material.base_color.to_linear().map(|c| f64::from(c.clamp(0.0, 1.0)));
        let unit = |value: f32| f64::from(value.clamp(0.0, 1.0));
        self.document.materials.push(doc::Material {
            name: Some(material.name.clone()),
            pbr_metallic_roughness: Some(doc::MetallicRoughness {
                base_color_factor: Some([r, g, b, unit(material.opacity)]),
                base_color_texture: texture.map(reference),
                metallic_factor: Some(unit(material.metalness)),
                roughness_factor: Some(unit(material.roughness)),
            }),
            normal_texture: normals.map(reference),
            alpha_mode: Some(if material.opacity < 1.0 { "BLEND" } else { "OPAQUE" }.to_owned()),
            extras: Some(doc::MaterialExtras {
                base_color_srgb: Some(material.base_color.0.map(f64::from)),
                relief: (material.relief > 0.0).then(|| f64::from(material.relief)),
            }),
        });
        self.document.materials.len() - 1
    }

    /// Index of the texture in the document; textures, images and `self.textures` share indices.
    fn add_texture(&mut self, texture: &Texture) -> usize {
        if let Some(index) = self.textures.iter().position(|known| known == texture) {
            return index;
        }
        let view = self.add_view(texture.upside_down_png(), None);
        self.document.images.push(doc::Image {
            mime_type: Some("image/png".to_owned()),
            buffer_view: Some(view),
            ..doc::Image::default()
        });
        if self.document.samplers.is_empty() {
            self.document.samplers.push(doc::Sampler {
                mag_filter: Some(doc::LINEAR),
                min_filter: Some(doc::LINEAR_MIPMAP_LINEAR),
                wrap_s: Some(doc::REPEAT),
                wrap_t: Some(doc::REPEAT),
            });
        }
        let source = Some(self.document.images.len() - 1);
        self.document.textures.push(doc::Texture { sampler: Some(0), source });
        self.textures.push(texture.clone());
        self.textures.len() - 1
    }

    fn add_accessor(
        &mut self,
        bytes: &[u8],
        component_type: u32,
        kind: &str,
        count: usize,
        is_vertex_data: bool,
    ) -> usize {
        let target = if is_vertex_data { doc::ARRAY_BUFFER } else { doc::ELEMENT_ARRAY_BUFFER };
        let view = self.add_view(bytes, Some(target));
        self.document.accessors.push(doc::Accessor {
            buffer_view: Some(view),
            component_type,
            count,
            kind: kind.to_owned(),
            ..doc::Accessor::default()
        });
        self.document.accessors.len() - 1
    }

    /// Appends the bytes at the next multiple of four.
    fn add_view(&mut self, bytes: &[u8], target: Option<u32>) -> usize {
        self.binary.resize(self.binary.len().next_multiple_of(4), 0);
        self.document.buffer_views.push(doc::BufferView {
            buffer: 0,
            byte_offset: Some(self.binary.len()),
            byte_length: bytes.len(),
            byte_stride: None,
            target,
        });
        self.binary.extend_from_slice(bytes);
        self.document.buffer_views.len() - 1
    }

    fn finish(mut self, root: usize) -> Vec<u8> {
        self.document.asset =
            doc::DocumentAsset { version: "2.0".to_owned(), generator: Some("tabletopgen".to_owned()) };
        self.document.scene = Some(0);
        self.document.scenes.push(doc::DocumentScene { nodes: vec![root] });
        self.binary.resize(self.binary.len().next_multiple_of(4), 0);
        if !self.binary.is_empty() {
            self.document.buffers.push(doc::Buffer { byte_length: self.binary.len(), uri: None });
        }
        let mut json = serde_json::to_vec(&self.document).expect("plain structs serialize to memory");
        json.resize(json.len().next_multiple_of(4), b' ');
        let mut glb = Vec::with_capacity(28 + json.len() + self.binary.len());
        let binary_chunk = if self.binary.is_empty() { 0 } else { 8 + self.binary.len() };
        let total = 12 + 8 + json.len() + binary_chunk;
        glb.extend_from_slice(b"glTF");
        glb.extend_from_slice(&2_u32.to_le_bytes());
        glb.extend_from_slice(&(total as u32).to_le_bytes());
        glb.extend_from_slice(&(json.len() as u32).to_le_bytes());
        glb.extend_from_slice(b"JSON");
        glb.extend_from_slice(&json);
        if !self.binary.is_empty() {
            glb.extend_from_slice(&(self.binary.len() as u32).to_le_bytes());
            glb.extend_from_slice(b"BIN\0");
            glb.extend_from_slice(&self.binary);
        }
        glb
    }
}

fn floats<const N: usize>(rows: &[[f32; N]]) -> Vec<u8> {
    rows.as_flattened().iter().flat_map(|value| value.to_le_bytes()).collect()
}
