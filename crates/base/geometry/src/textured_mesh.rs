//! A visual mesh: positions, normals, texture coordinates, and faces grouped by material.
//!
//! Vertices are split where normals or texture coordinates break; *watertight* means that after
//! welding equal positions every edge is shared by exactly two opposite triangles. A mesh may be
//! several closed shells (a mug's body and its handle), which may overlap.

use glam::{DQuat, DVec3, Vec2, Vec3};

use super::{Material, Rgb};

/// Triangles with one material.
#[derive(Clone, Debug, PartialEq)]
pub struct FaceGroup {
    /// Index into [`TexturedMesh::materials`].
    pub material: usize,
    /// Vertex indices, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
}

/// A triangle mesh with materials. `positions`, `normals` and `uvs` have equal lengths.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct TexturedMesh {
    /// Object frame, meters.
    pub positions: Vec<DVec3>,
    /// Unit, outward.
    pub normals: Vec<Vec3>,
    /// v grows upward in the texture.
    pub uvs: Vec<Vec2>,
    pub groups: Vec<FaceGroup>,
    pub materials: Vec<Material>,
}

impl TexturedMesh {
    /// All triangles, group after group.
    pub fn triangles(&self) -> impl Iterator<Item = [u32; 3]> + '_ {
        self.groups.iter().flat_map(|group| group.triangles.iter().copied())
    }

    /// Number of triangles in all groups.
    pub fn triangle_count(&self) -> usize {
        self.groups.iter().map(|group| group.triangles.len()).sum()
    }

    /// Axis-aligned box as (lowest, highest) corner, meters; zeros for an empty mesh.
    pub fn bounds(&self) -> (DVec3, DVec3) {
        let Some(&first) = self.positions.first() else { return (DVec3::ZERO, DVec3::ZERO) };
        self.positions.iter().fold((first, first), |(low, high), &p| (low.min(p), high.max(p)))
    }

    /// Edge lengths of the axis-aligned box, meters.
    pub fn size_m(&self) -> DVec3 {
        let (low, high) = self.bounds();
        high - low
    }

    /// The mesh rotated about the origin.
    pub fn rotated(mut self, rotation: DQuat) -> Self {
        let rotation_f32 = rotation.as_quat();
        self.positions.iter_mut().for_each(|p| *p = rotation * *p);
        self.normals.iter_mut().for_each(|n| *n = (rotation_f32 * *n).normalize_or_zero());
        self
    }

    /// The mesh translated.
    pub fn translated(mut self, offset_m: DVec3) -> Self {
        self.positions.iter_mut().for_each(|p| *p += offset_m);
        self
    }

    /// The mesh scaled per axis (positive factors); normals follow the inverse scale.
    pub fn scaled(mut self, scale: DVec3) -> Self {
        let inverse = (1.0 / scale).as_vec3();
        self.positions.iter_mut().for_each(|p| *p *= scale);
        self.normals.iter_mut().for_each(|n| *n = (*n * inverse).normalize_or_zero());
        self
    }

    /// The mesh with every position rounded to the nearest `f32`, so that formats with
    /// single-precision positions store it without loss. Idempotent.
    pub fn snap_to_f32(mut self) -> Self {
        self.positions.iter_mut().for_each(|p| *p = p.as_vec3().as_dvec3());
        self
    }

    /// Moves the center of the bottom face of the axis-aligned box to the origin: the canonical origin.
    pub fn seated(self) -> Self {
        let (low, high) = self.bounds();
        let offset = -DVec3::new(0.5 * (low.x + high.x), 0.5 * (low.y + high.y), low.z);
        self.translated(offset)
    }

    /// The mesh with every texture replaced by its mean color; `None` if it has no texture.
    pub fn without_textures(&self) -> Option<Self> {
        if self.materials.iter().all(|material| material.base_color_texture.is_none()) {
            return None;
        }
        let mut plain = self.clone();
        for material in &mut plain.materials {
            if let Some(image) = material.base_color_texture.take() {
                let [r, g, b, _] = image.halved().last().unwrap_or(&image).pixel(0, 0);
                let mean = [r, g, b].map(|level| f32::from(level) / 255.0);
                let Rgb(own) = material.base_color;
                material.base_color = Rgb([0, 1, 2].map(|channel| own[channel] * mean[channel]));
            }
        }
        Some(plain)
    }

    /// Adds another mesh's faces, sharing materials that are equal.
    pub fn append(&mut self, other: TexturedMesh) {
        let base = self.positions.len() as u32;
        self.positions.extend(other.positions);
        self.normals.extend(other.normals);
        self.uvs.extend(other.uvs);
        for group in other.groups {
            let material = &other.materials[group.material];
            let material = self.material_index(material);
            let triangles = group.triangles.into_iter().map(|t| t.map(|v| v + base));
            self.group_mut(material).triangles.extend(triangles);
        }
    }

    /// Adds a closed solid with this material.
    pub fn add(&mut self, solid: super::Solid, material: &Material) {
        let base = self.positions.len() as u32;
        let index = self.material_index(material);
        self.positions.extend(solid.positions);
        self.normals.extend(solid.normals);
        self.uvs.extend(solid.uvs);
        let triangles = solid.triangles.into_iter().map(|t| t.map(|v| v + base));
        self.group_mut(index).triangles.extend(triangles);
    }

    fn material_index(&mut self, material: &Material) -> usize {
        if let Some(index) = self.materials.iter().position(|known| known == material) {
            return index;
        }
        let mut material = material.clone();
        let taken = self.materials.iter().filter(|known| known.name == material.name).count();
        if taken > 0 {
            material.name = format!("{}_{}", material.name, self.materials.len());
        }
        self.materials.push(material);
        self.materials.len() - 1
    }

    fn group_mut(&mut self, material: usize) -> &mut FaceGroup {
        let at = match self.groups.iter().position(|group| group.material == material) {
            Some(at) => at,
            None => {
                self.groups.push(FaceGroup { material, triangles: Vec::new() });
                self.groups.len() - 1
            }
        };
        &mut self.groups[at]
    }
}
