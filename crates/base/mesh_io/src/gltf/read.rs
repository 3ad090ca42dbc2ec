//! Reads the triangles of a GLB file into one mesh, z up.
//!
//! Accepts the output of mesh generators: node transforms, interleaved arrays, 8, 16 and 32-bit indices,
//! embedded PNG, JPEG and WebP images, missing normals and texture coordinates. Rejects external files, sparse
//! arrays and required extensions. Every index, offset and count is checked and the totals are bounded
//! ([`Limits`]), so hostile bytes give an error and never a panic.

use glam::{DMat3, DMat4, DQuat, DVec3, Vec2, Vec3};

use geometry::{FaceGroup, Material, Rgb, TexturedMesh};
use imaging::codec::{CodecError, decode_image};
use imaging::{Image, Texture};

use super::ROOT_ROTATION_XYZW;
use super::document as doc;

/// Bounds on the allocations that a file can cause.
pub(super) struct Limits;

impl Limits {
    const JSON_BYTES: usize = 8 << 20;
    pub const VERTICES: usize = 8_000_000;
    pub const TRIANGLES: usize = 8_000_000;
    const NODE_VISITS: usize = 100_000;
    const NODE_DEPTH: usize = 64;
    pub const MATERIALS: usize = 4096;
    pub const PIXELS: u64 = 128 << 20;
}

/// Longest name of a material; longer ones are cut.
pub(super) const MAX_NAME_CHARS: usize = 48;

/// Reason why bytes were not read as a mesh.
#[derive(Debug, thiserror::Error)]
pub enum GltfError {
    #[error("not a binary glTF 2.0 file: {0}")]
    NotGlb(&'static str),
    #[error("the JSON of the glTF file could not be read")]
    Json(#[from] serde_json::Error),
    #[error("the glTF file refers to {what} {index}, which it does not have")]
    Missing { what: &'static str, index: usize },
    #[error("the glTF file uses {0}, which is not supported; export it plainly, in one file")]
    Unsupported(String),
    #[error("the glTF file is larger than accepted ({0}); reduce it")]
    TooLarge(&'static str),
    #[error("the glTF file contradicts itself: {0}")]
    Inconsistent(&'static str),
    #[error("a texture of the glTF file could not be read")]
    Texture(#[from] CodecError),
}

/// All triangles of the file's scene with z up and glTF's front (+Z) at -y. Node transforms are applied;
/// the output of [`super::write_mesh_glb`] round-trips. Material names are folded to `[a-z0-9_]` and made unique.
///
/// # Errors
///
/// [`GltfError`] for damaged, unsupported or oversized files.
pub fn read_mesh_glb(bytes: &[u8]) -> Result<TexturedMesh, GltfError> {
    let (document, binary) = split(bytes)?;
    if let Some(extension) = document.extensions_required.first() {
        return Err(GltfError::Unsupported(format!("the extension {extension:?}")));
    }
    let mesh = TexturedMesh::default();
    let mut reader = Reader { document: &document, binary, mesh, triangles: 0, visits: 0 };
    reader.read_materials()?;
    let roots = match document.scenes.get(document.scene.unwrap_or(0)) {
        Some(scene) => scene.nodes.clone(),
        None => (0..document.nodes.len()).collect(),
    };
    for root in roots {
        reader.visit(root, None, 0)?;
    }
    Ok(reader.mesh)
}

fn split(bytes: &[u8]) -> Result<(doc::Document, &[u8]), GltfError> {
    let word = |at: usize| bytes.get(at..at + 4).and_then(|w| w.try_into().ok()).map(u32::from_le_bytes);
    if bytes.get(..4) != Some(b"glTF") {
        return Err(GltfError::NotGlb("it does not start with \"glTF\""));
    }
    if word(4) != Some(2) {
        return Err(GltfError::NotGlb("its version is not 2"));
    }
    let length = word(8).map_or(0, |l| l as usize);
    if length > bytes.len() {
        return Err(GltfError::NotGlb("it is cut short"));
    }
    let (mut at, mut json, mut binary) = (12, None, None);
    while let (Some(size), Some(kind)) = (word(at), bytes.get(at + 4..at + 8)) {
        let end = (at + 8).saturating_add(size as usize);
        let chunk = bytes.get(at + 8..end).ok_or(GltfError::NotGlb("a chunk is cut short"))?;
        match kind {
            b"JSON" if json.is_none() => json = Some(chunk),
            b"BIN\0" if binary.is_none() => binary = Some(chunk),
            _ => {}
        }
        at = end;
    }
    let json = json.ok_or(GltfError::NotGlb("it has no JSON chunk"))?;
    if json.len() > Limits::JSON_BYTES {
        return Err(GltfError::TooLarge("8 MiB of JSON"));
    }
    Ok((serde_json::from_slice(json)?, binary.unwrap_or_default()))
}

struct Reader<'a> {
    document: &'a doc::Document,
    binary: &'a [u8],
    mesh: TexturedMesh,
    /// Number of triangles so far. Counting them again for each group takes minutes if there are many groups.
    triangles: usize,
    visits: usize,
}

/// Vertex arrays already read under the current node: accessors and first vertex.
type ReadVertices = Vec<(doc::Attributes, u32)>;

impl Reader<'_> {
    fn visit(&mut self, index: usize, parent: Option<DMat4>, depth: usize) -> Result<(), GltfError> {
        self.visits += 1;
        if self.visits > Limits::NODE_VISITS || depth > Limits::NODE_DEPTH {
            return Err(GltfError::TooLarge("nodes, or nodes that contain themselves"));
        }
        let document = self.document;
        let node = document.nodes.get(index).ok_or(GltfError::Missing { what: "node", index })?;
        // `None` represents exactly `ROOT_ROTATION_XYZW`, so that such meshes are read without arithmetic.
        let is_our_root = parent.is_none()
            && node.rotation == Some(ROOT_ROTATION_XYZW)
            && node.translation.is_none()
            && node.scale.is_none()
            && node.matrix.is_none();
        let gltf_from_node = match (is_our_root, parent) {
            (true, _) if node.children.is_empty() => None,
            (_, parent) => Some(parent.unwrap_or(DMat4::IDENTITY) * local_transform(node)?),
        };
        if let Some(mesh) = node.mesh {
            self.read_mesh(mesh, gltf_from_node)?;
        }
        for &child in &node.children {
            self.visit(child, Some(gltf_from_node.unwrap_or(DMat4::IDENTITY)), depth + 1)?;
        }
        Ok(())
    }

    fn read_mesh(&mut self, index: usize, gltf_from_node: Option<DMat4>) -> Result<(), GltfError> {
        let document = self.document;
        let mesh = document.meshes.get(index).ok_or(GltfError::Missing { what: "mesh", index })?;
        let mut read: ReadVertices = Vec::new();
        for primitive in &mesh.primitives {
            if primitive.mode.unwrap_or(doc::TRIANGLES) != doc::TRIANGLES {
                continue; // Points, lines and strips carry no solid surface that generators write.
            }
            let known = read.iter().find(|(attributes, _)| *attributes == primitive.attributes);
            let first = match known {
                Some(&(_, first)) => first,
                None => {
                    let first = self.mesh.positions.len() as u32;
                    self.read_vertices(primitive, gltf_from_node)?;
                    read.push((primitive.attributes.clone(), first));
                    first
                }
            };
            self.read_triangles(primitive, first, gltf_from_node)?;
        }
        Ok(())
    }

    fn read_vertices(
        &mut self,
        primitive: &doc::Primitive,
        gltf_from_node: Option<DMat4>,
    ) -> Result<(), GltfError> {
        let position = primitive.attributes.position.ok_or(GltfError::Inconsistent("no positions"))?;
        let positions: Vec<[f32; 3]> = self.read_floats(position, "VEC3")?;
        if self.mesh.positions.len() + positions.len() > Limits::VERTICES {
            return Err(GltfError::TooLarge("8 million vertices"));
        }
        if positions.as_flattened().iter().any(|c| !c.is_finite()) {
            return Err(GltfError::Inconsistent("a position is not finite"));
        }
        let normals: Vec<[f32; 3]> = match primitive.attributes.normal {
            Some(normal) => self.read_floats(normal, "VEC3")?,
            None => self.smooth_normals(primitive, &positions)?,
        };
        let uvs: Vec<[f32; 2]> = match primitive.attributes.texcoord {
            Some(texcoord) => self.read_floats(texcoord, "VEC2")?,
            None => vec![[0.0; 2]; positions.len()],
        };
        if normals.len() != positions.len() || uvs.len() != positions.len() {
            return Err(GltfError::Inconsistent("vertex arrays differ in length"));
        }
        let finite = |c: &f32| if c.is_finite() { *c } else { 0.0 };
        let normals = normals.iter().map(|n| Vec3::from_array([finite(&n[0]), finite(&n[1]), finite(&n[2])]));
        self.mesh.uvs.extend(uvs.iter().map(|uv| Vec2::new(finite(&uv[0]), finite(&uv[1]))));
        let positions = positions.iter().map(|p| Vec3::from_array(*p).as_dvec3());
        match gltf_from_node {
            None => {
                self.mesh.positions.extend(positions);
                self.mesh.normals.extend(normals);
            }
            Some(gltf_from_node) => {
                let ours_from_node = ours_from_gltf() * gltf_from_node;
                let linear = DMat3::from_mat4(ours_from_node);
                // Normals follow the cofactor matrix, which exists for flat scales too and, with the
                // determinant's sign, points outward in mirrored nodes (whose winding is reversed).
                let cofactor = DMat3::from_cols(
                    linear.y_axis.cross(linear.z_axis),
                    linear.z_axis.cross(linear.x_axis),
                    linear.x_axis.cross(linear.y_axis),
                );
                let sign = if linear.determinant() < 0.0 { -1.0 } else { 1.0 };
                self.mesh.positions.extend(positions.map(|p| ours_from_node.transform_point3(p)));
                let turned =
                    normals.map(|n| (sign * (cofactor * n.as_dvec3())).normalize_or_zero().as_vec3());
                self.mesh.normals.extend(turned);
            }
        }
        Ok(())
    }

    fn read_triangles(
        &mut self,
        primitive: &doc::Primitive,
        first: u32,
        gltf_from_node: Option<DMat4>,
    ) -> Result<(), GltfError> {
        let count = self.position_count(primitive)?;
        let corners = self.corners(primitive, count)?;
        self.triangles += corners.len() / 3;
        if self.triangles > Limits::TRIANGLES {
            return Err(GltfError::TooLarge("8 million triangles"));
        }
        let mirrored = gltf_from_node.is_some_and(|m| DMat3::from_mat4(m).determinant() < 0.0);
        let triangles: Vec<[u32; 3]> = corners
            .chunks_exact(3)
            .map(|t| if mirrored { [t[0], t[2], t[1]] } else { [t[0], t[1], t[2]] })
            .map(|t| t.map(|v| v + first))
            .collect();
        let material = match primitive.material {
            Some(index) if index < self.document.materials.len() => index,
            Some(index) => return Err(GltfError::Missing { what: "material", index }),
            None => {
                let plain = Material::plain("unnamed_surface", Rgb([0.8, 0.8, 0.8]), 0.7);
                let known = self.mesh.materials.iter().skip(self.document.materials.len());
                if known.count() == 0 {
                    self.mesh.materials.push(plain);
                }
                self.document.materials.len()
            }
        };
        self.mesh.groups.push(FaceGroup { material, triangles });
        Ok(())
    }

    fn position_count(&self, primitive: &doc::Primitive) -> Result<usize, GltfError> {
        let index = primitive.attributes.position.ok_or(GltfError::Inconsistent("no positions"))?;
        Ok(self.accessor(index)?.count)
    }

    /// Vertex indices into the primitive's arrays, all below `count`.
    fn corners(&self, primitive: &doc::Primitive, count: usize) -> Result<Vec<u32>, GltfError> {
        let corners = match primitive.indices {
            Some(indices) => self.read_indices(indices)?,
            None => (0..count as u32).collect(),
        };
        if !corners.len().is_multiple_of(3) {
            return Err(GltfError::Inconsistent("a triangle is incomplete"));
        }
        if corners.iter().any(|&v| v as usize >= count) {
            return Err(GltfError::Inconsistent("a triangle names a vertex that is not there"));
        }
        Ok(corners)
    }

    /// Area-weighted means of the faces around each vertex, in the node's frame.
    fn smooth_normals(
        &self,
        primitive: &doc::Primitive,
        positions: &[[f32; 3]],
    ) -> Result<Vec<[f32; 3]>, GltfError> {
        let mut sums = vec![DVec3::ZERO; positions.len()];
        for t in self.corners(primitive, positions.len())?.chunks_exact(3) {
            let [a, b, c] = [0, 1, 2].map(|k| Vec3::from_array(positions[t[k] as usize]).as_dvec3());
            let normal = (b - a).cross(c - a);
            t.iter().for_each(|&v| sums[v as usize] += normal);
        }
        Ok(sums.iter().map(|n| n.normalize_or(DVec3::Z).as_vec3().to_array()).collect())
    }

    fn accessor(&self, index: usize) -> Result<&doc::Accessor, GltfError> {
        self.document.accessors.get(index).ok_or(GltfError::Missing { what: "accessor", index })
    }

    fn view(&self, index: usize) -> Result<(&doc::BufferView, &[u8]), GltfError> {
        let missing = GltfError::Missing { what: "buffer view", index };
        let view = self.document.buffer_views.get(index).ok_or(missing)?;
        if view.buffer != 0 || self.document.buffers.first().is_some_and(|b| b.uri.is_some()) {
            return Err(GltfError::Unsupported("a buffer outside the file".to_owned()));
        }
        let start = view.byte_offset.unwrap_or(0);
        let bytes = start.checked_add(view.byte_length).and_then(|end| self.binary.get(start..end));
        Ok((view, bytes.ok_or(GltfError::Inconsistent("a buffer view leaves the buffer"))?))
    }

    /// The elements of an accessor as slices of `element_bytes`.
    fn elements(&self, accessor: &doc::Accessor, element_bytes: usize) -> Result<Vec<&[u8]>, GltfError> {
        if accessor.sparse.is_some() {
            return Err(GltfError::Unsupported("a sparse accessor".to_owned()));
        }
        let view = accessor.buffer_view.ok_or(GltfError::Inconsistent("an accessor has no data"))?;
        let (view, bytes) = self.view(view)?;
        let stride = view.byte_stride.unwrap_or(element_bytes);
        if stride < element_bytes {
            return Err(GltfError::Inconsistent("a stride is shorter than its element"));
        }
        if accessor.count > Limits::VERTICES.max(3 * Limits::TRIANGLES) {
            return Err(GltfError::TooLarge("elements of an accessor"));
        }
        let start = accessor.byte_offset.unwrap_or(0);
        (0..accessor.count)
            .map(|k| {
                let at = k.checked_mul(stride).and_then(|offset| start.checked_add(offset));
                at.and_then(|at| bytes.get(at..at.checked_add(element_bytes)?))
                    .ok_or(GltfError::Inconsistent("an accessor leaves its buffer view"))
            })
            .collect()
    }

    fn read_floats<const N: usize>(&self, index: usize, kind: &str) -> Result<Vec<[f32; N]>, GltfError> {
        let accessor = self.accessor(index)?;
        if accessor.kind != kind {
            return Err(GltfError::Inconsistent("a vertex array has the wrong number of components"));
        }
        let component_bytes = match accessor.component_type {
            doc::FLOAT => 4,
            doc::UNSIGNED_SHORT => 2,
            doc::UNSIGNED_BYTE => 1,
            _ => return Err(GltfError::Unsupported("a component type of a vertex array".to_owned())),
        };
        let component = |bytes: &[u8]| match *bytes {
            [a, b, c, d] => f32::from_le_bytes([a, b, c, d]),
            [a, b] => f32::from(u16::from_le_bytes([a, b])) / 65535.0,
            [a] => f32::from(a) / 255.0,
            _ => 0.0,
        };
        let elements = self.elements(accessor, component_bytes * N)?;
        let row = |bytes: &[u8]| {
            let mut row = [0.0; N];
            for (value, bytes) in row.iter_mut().zip(bytes.chunks_exact(component_bytes)) {
                *value = component(bytes);
            }
            row
        };
        Ok(elements.into_iter().map(row).collect())
    }

    fn read_indices(&self, index: usize) -> Result<Vec<u32>, GltfError> {
        let accessor = self.accessor(index)?;
        let bytes = match accessor.component_type {
            doc::UNSIGNED_INT => 4,
            doc::UNSIGNED_SHORT => 2,
            doc::UNSIGNED_BYTE => 1,
            _ => return Err(GltfError::Inconsistent("indices are not unsigned integers")),
        };
        let elements = self.elements(accessor, bytes)?;
        let number = |bytes: &[u8]| bytes.iter().rev().fold(0, |sum, &byte| (sum << 8) | u32::from(byte));
        Ok(elements.into_iter().map(number).collect())
    }

    fn read_materials(&mut self) -> Result<(), GltfError> {
        if self.document.materials.len() > Limits::MATERIALS {
            return Err(GltfError::TooLarge("4096 materials"));
        }
        let mut images: Vec<Option<Texture>> = vec![None; self.document.images.len()];
        let mut budget_px = Limits::PIXELS;
        for (index, material) in self.document.materials.iter().enumerate() {
            let surface = material.pbr_metallic_roughness.clone().unwrap_or_default();
            let texture = match &surface.base_color_texture {
                Some(reference) if reference.tex_coord.unwrap_or(0) == 0 => {
                    Some(self.texture(reference.index, &mut images, &mut budget_px)?)
                }
                _ => None,
            };
            let factor = surface.base_color_factor.unwrap_or([1.0; 4]);
            let exact = material.extras.as_ref().and_then(|extras| extras.base_color_srgb);
            let srgb = exact.unwrap_or([factor[0], factor[1], factor[2]].map(srgb_from_linear));
            let relief = material.extras.as_ref().and_then(|extras| extras.relief).unwrap_or(0.0);
            let opacity = if material.alpha_mode.as_deref() == Some("BLEND") { factor[3] } else { 1.0 };
            let name = self.unique_name(material.name.as_deref().unwrap_or_default(), index);
            self.mesh.materials.push(Material {
                name,
                base_color: Rgb(srgb.map(|c| c.clamp(0.0, 1.0) as f32)),
                base_color_texture: texture,
                roughness: surface.roughness_factor.unwrap_or(1.0).clamp(0.0, 1.0) as f32,
                metalness: surface.metallic_factor.unwrap_or(1.0).clamp(0.0, 1.0) as f32,
                opacity: opacity.clamp(0.0, 1.0) as f32,
                relief: relief.clamp(0.0, 1.0) as f32,
            });
        }
        Ok(())
    }

    fn unique_name(&self, wanted: &str, index: usize) -> String {
        let folded: String = wanted
            .chars()
            .take(MAX_NAME_CHARS)
            .map(|c| c.to_ascii_lowercase())
            .map(|c| if c.is_ascii_alphanumeric() || c == '_' { c } else { '_' })
            .collect();
        let taken = self.mesh.materials.iter().any(|known| known.name == folded);
        match (folded.is_empty(), taken) {
            (false, false) => folded,
            (true, _) => format!("material_{index}"),
            (false, true) => format!("{folded}_{index}"),
        }
    }

    fn texture(
        &self,
        index: usize,
        images: &mut [Option<Texture>],
        budget_px: &mut u64,
    ) -> Result<Texture, GltfError> {
        let texture =
            self.document.textures.get(index).ok_or(GltfError::Missing { what: "texture", index })?;
        let index = texture.source.ok_or(GltfError::Unsupported("a texture without an image".to_owned()))?;
        let missing = GltfError::Missing { what: "image", index };
        let (Some(image), Some(slot)) = (self.document.images.get(index), images.get_mut(index)) else {
            return Err(missing);
        };
        if let Some(known) = slot {
            return Ok(known.clone());
        }
        let view = image
            .buffer_view
            .ok_or_else(|| GltfError::Unsupported("an image outside the file".to_owned()))?;
        let image: Image = decode_image(self.view(view)?.1, *budget_px)?;
        *budget_px -= u64::from(image.width_px()) * u64::from(image.height_px());
        let texture = Texture::new(image.upside_down());
        *slot = Some(texture.clone());
        Ok(texture)
    }
}

fn ours_from_gltf() -> DMat4 {
    // (x, y, z) of glTF is (x, -z, y) here; written out to avoid rounding.
    DMat4::from_cols_array(&[1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, -1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0])
}

fn local_transform(node: &doc::Node) -> Result<DMat4, GltfError> {
    let transform = match node.matrix {
        Some(matrix) => DMat4::from_cols_array(&matrix),
        None => {
            let rotation = DQuat::from_array(node.rotation.unwrap_or([0.0, 0.0, 0.0, 1.0]));
            let length = rotation.length();
            if !(length.is_finite() && length > 1e-6) {
                return Err(GltfError::Inconsistent("a rotation has no length"));
            }
            DMat4::from_scale_rotation_translation(
                DVec3::from_array(node.scale.unwrap_or([1.0; 3])),
                rotation / length,
                DVec3::from_array(node.translation.unwrap_or([0.0; 3])),
            )
        }
    };
    let sane = transform.to_cols_array().iter().all(|c| c.is_finite() && c.abs() < 1e9);
    sane.then_some(transform).ok_or(GltfError::Inconsistent("a node's transform is not finite"))
}

fn srgb_from_linear(c: f64) -> f64 {
    let c = c.clamp(0.0, 1.0);
    if c <= 0.003_130_8 { 12.92 * c } else { 1.055 * c.powf(1.0 / 2.4) - 0.055 }
}

#[cfg(test)]
pub(super) mod tests {
    use super::super::{write_mesh_glb, write_scene_glb};
    use super::*;
    use crate::gltf::write::SceneNode;
    use geometry::{Pose, shapes};
    use proptest::prelude::*;

    pub(in super::super) fn two_tone_mesh() -> TexturedMesh {
        let mut texture = Image::filled(4, 3, [200, 150, 90, 255]);
        texture.set_pixel(1, 0, [3, 2, 1, 255]);
        let mut glass = Material::plain("glass", Rgb([0.3, 0.71, 0.93]), 0.05);
        glass.opacity = 0.35;
        let mut mesh = TexturedMesh::default();
        let label = Material { relief: 0.02, ..Material::textured("label", texture.into(), 0.6) };
        mesh.add(shapes::cylinder(0.04, 0.1, 0.003, 24), &label);
        mesh.add(shapes::sphere(0.03, 20).translated(DVec3::new(0.1, 0.0, 0.01)), &glass);
        mesh.add(shapes::cone(0.02, 0.01, 0.03, 9), &Material::metal("steel", Rgb::hex(0x8f9499), 0.3));
        mesh.snap_to_f32()
    }

    #[test]
    fn mesh_glb_round_trips_exactly() {
        let mesh = two_tone_mesh();
        let bytes = write_mesh_glb(&mesh);
        assert_eq!(bytes, write_mesh_glb(&mesh));
        assert_eq!(read_mesh_glb(&bytes).expect("our own file"), mesh);
    }

    #[test]
    fn read_mesh_glb_applies_the_poses_of_a_scene_file() {
        let mesh = two_tone_mesh();
        let pose = Pose::upright(DVec3::new(0.2, -0.1, 0.05), 0.8);
        let extras = serde_json::json!({ "label": "\"<a>\"\n🍎" });
        let carrier = TexturedMesh::default();
        let parent_from_node = Pose::upright(DVec3::new(-0.1, 0.3, 0.2), 0.5);
        let node = SceneNode {
            name: "a",
            extras: extras.clone(),
            mesh: &mesh,
            parent: Some(0),
            parent_from_node: parent_from_node.inverse() * pose,
        };
        let base = SceneNode { name: "base", extras, mesh: &carrier, parent: None, parent_from_node };
        let read = read_mesh_glb(&write_scene_glb(&[base, node])).expect("our own file");
        for (read, authored) in read.positions.iter().zip(&mesh.positions) {
            assert!((*read - pose.transform_point(*authored)).length() < 1e-9);
        }
        for (read, authored) in read.normals.iter().zip(&mesh.normals) {
            let expected = pose.transform_vector(authored.as_dvec3()).as_vec3();
            assert!((*read - expected).length() < 1e-5);
        }
        assert_eq!(read.groups, mesh.groups);
    }

    #[test]
    fn write_mesh_glb_accepts_an_empty_mesh() {
        let read = read_mesh_glb(&write_mesh_glb(&TexturedMesh::default())).expect("our own file");
        assert_eq!(read, TexturedMesh::default());
    }

    #[test]
    fn read_mesh_glb_rejects_hostile_documents() {
        let glb = |json: &str, binary: &[u8]| {
            let mut json = json.as_bytes().to_vec();
            json.resize(json.len().next_multiple_of(4), b' ');
            let mut bytes = b"glTF\x02\0\0\0".to_vec();
            bytes.extend(((28 + json.len() + binary.len()) as u32).to_le_bytes());
            bytes.extend((json.len() as u32).to_le_bytes());
            bytes.extend(b"JSON");
            bytes.extend(&json);
            bytes.extend((binary.len() as u32).to_le_bytes());
            bytes.extend(b"BIN\0");
            bytes.extend(binary);
            bytes
        };
        let cases = [
            r#"{"nodes":[{"children":[0]}],"scenes":[{"nodes":[0]}]}"#,
            r#"{"nodes":[{"children":[1,1]},{"children":[0,0]}],"scenes":[{"nodes":[0]}]}"#,
            r#"{"nodes":[{"mesh":7}]}"#,
            r#"{"extensionsRequired":["KHR_draco_mesh_compression"]}"#,
            r#"{"nodes":[{"mesh":0}],"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],
                "accessors":[{"bufferView":0,"componentType":5126,"count":99999999999,"type":"VEC3"}],
                "bufferViews":[{"buffer":0,"byteOffset":18446744073709551615,"byteLength":12}]}"#,
            r#"{"nodes":[{"mesh":0}],"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],
                "accessors":[{"bufferView":0,"componentType":5126,"count":9000,"type":"VEC3"}],
                "bufferViews":[{"buffer":0,"byteLength":12}],"buffers":[{"byteLength":12}]}"#,
            r#"{"images":[{"uri":"file:///etc/passwd"}],"textures":[{"source":0}],
                "materials":[{"pbrMetallicRoughness":{"baseColorTexture":{"index":0}}}]}"#,
            r#"{"nodes":[{"rotation":[0,0,0,0]}]}"#,
        ];
        for case in cases {
            assert!(read_mesh_glb(&glb(case, &[0; 12])).is_err(), "{case}");
        }
    }

    proptest! {
        #[test]
        fn read_mesh_glb_never_panics_on_changed_bytes(at in 0_usize..4000, value: u8, cut in 0_usize..4000) {
            let mut bytes = write_mesh_glb(&two_tone_mesh());
            let at = at % bytes.len();
            bytes[at] = value;
            let _ = read_mesh_glb(&bytes);
            let _ = read_mesh_glb(&bytes[..cut.min(bytes.len())]);
        }
    }
}
