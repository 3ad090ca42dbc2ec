//! Shading data of a mesh for soft images: per triangle its corners' texture coordinates and normals, per material its
//! base color and mipmaps in linear light.
//!
//! Method: trilinear filtering (Williams, "Pyramidal parametrics", 1983): bilinear within a level, linear between two
//! levels, which makes the sample continuous in u, v and level; its derivatives are those of the two interpolations,
//! exact except at texels' centers and whole levels, where they jump. Textures repeat.
//!
//! Inputs: texture coordinates with v = 0 at the bottom; levels counted from the finest that is kept. Cost: once per
//! mesh, at most 12 bytes a texel for textures of up to [`FINEST_TEXELS`] a side and their mipmaps. Roughness,
//! metalness and opacity are ignored, so shiny or transparent objects are not modelled.

use glam::{Vec2, Vec3};

use super::Surface;
use super::color_discontinuities::{Creases, alike, creases};
use geometry::TexturedMesh;
use imaging::Image;
use imaging::rounding::floor;
use imaging::srgb::LINEAR_OF_SRGB;

/// Longest side of the finest level that is kept: images of objects here are about a hundred pixels wide.
const FINEST_TEXELS: u32 = 512;

/// Colors of a surface's triangles.
pub struct ShadingMaterials {
    pub(super) faces: Vec<Face>,
    pub(super) materials: Vec<ShadingMaterial>,
    /// Of each triangle, among the surface's edges.
    pub(super) edges_of: Vec<[u32; 3]>,
    /// Edges at which colors are discontinuous at any yaw.
    pub(super) creases: Creases,
    /// Adjacent triangles of each triangle, all lists in one, and the start of each list.
    beside: Vec<u32>,
    beside_starts: Vec<u32>,
}

/// A triangle's corners.
pub(super) struct Face {
    pub uvs: [Vec2; 3],
    /// Unit, in the mesh's frame.
    pub normals: [Vec3; 3],
    pub material: usize,
}

/// A material.
pub(super) struct ShadingMaterial {
    /// Linear light; multiplies the texture.
    pub base_color: Vec3,
    /// The texture and its halved versions, finest first; none without a texture.
    pub levels: Vec<Texels>,
}

/// One level of a texture, linear light, rows from the top.
pub(super) struct Texels {
    pub width: usize,
    pub height: usize,
    pub colors: Vec<Vec3>,
}

/// A filtered color, linear light, and its derivatives.
pub(super) struct Sample {
    pub color: Vec3,
    pub by_u: Vec3,
    pub by_v: Vec3,
    pub by_level: Vec3,
}

impl ShadingMaterials {
    /// `faces` are the numbers, among all triangles of the mesh, of the surface's, in its order.
    pub fn new(mesh: &TexturedMesh, faces: &[u32], surface: &Surface) -> Self {
        let all: Vec<(usize, [u32; 3])> = mesh
            .groups
            .iter()
            .flat_map(|group| group.triangles.iter().map(|t| (group.material, *t)))
            .collect();
        let face = |&number: &u32| {
            let (material, corners) = all[number as usize];
            Face {
                uvs: corners.map(|v| mesh.uvs[v as usize]),
                normals: corners.map(|v| mesh.normals[v as usize]),
                material,
            }
        };
        let materials = mesh.materials.iter().map(|material| ShadingMaterial {
            base_color: Vec3::from(material.base_color.to_linear()),
            levels: material.base_color_texture.iter().flat_map(levels).collect(),
        });
        let faces: Vec<Face> = faces.iter().map(face).collect();
        let (edges_of, creases) = creases(surface, |a, b| alike(&faces, a, b));
        let (mut beside, mut beside_starts) = (Vec::new(), vec![0]);
        for (face, edges) in (0..).zip(&edges_of) {
            let sides = edges.iter().flat_map(|&edge| surface.sides(&surface.edges[edge as usize]));
            beside.extend(sides.map(|side| side.triangle).filter(|&other| other != face));
            beside_starts.push(beside.len() as u32);
        }
        let mut shading = Self {
            materials: materials.collect(),
            faces,
            edges_of,
            creases: Creases::default(),
            beside,
            beside_starts,
        };
        shading.creases = Creases::new(surface, creases, &shading);
        shading
    }

    /// The triangles that have an edge in common with one, edge by edge.
    #[inline]
    pub(super) fn beside(&self, face: u32) -> &[u32] {
        let bounds = &self.beside_starts[face as usize..][..2];
        &self.beside[bounds[0] as usize..bounds[1] as usize]
    }

    /// Whether two triangles are neighbors.
    pub(super) fn share_an_edge(&self, faces: [u32; 2]) -> bool {
        let [one, other] = faces.map(|face| &self.edges_of[face as usize]);
        one.iter().any(|edge| other.contains(edge))
    }
}

fn levels(texture: &imaging::Texture) -> Vec<Texels> {
    let small = |image: &&Image| image.width_px().max(image.height_px()) <= FINEST_TEXELS;
    std::iter::once(&**texture).chain(texture.halved()).filter(small).map(Texels::new).collect()
}

impl ShadingMaterial {
    /// Texels of the finest level.
    pub fn area_texels(&self) -> f32 {
        self.levels.first().map_or(1.0, |level| (level.width * level.height) as f32)
    }

    /// `level` within 0 and the last; white where there is no texture.
    #[inline]
    pub fn sample(&self, uv: Vec2, level: f32) -> Sample {
        if self.levels.is_empty() {
            return Sample { color: Vec3::ONE, by_u: Vec3::ZERO, by_v: Vec3::ZERO, by_level: Vec3::ZERO };
        }
        let fine = (level as usize).min(self.levels.len() - 1);
        let share = level - fine as f32;
        let [color, by_u, by_v] = self.levels[fine].bilinear(uv);
        let Some(coarse) = self.levels.get(fine + 1) else {
            return Sample { color, by_u, by_v, by_level: Vec3::ZERO };
        };
        let other = coarse.bilinear(uv);
        Sample {
            color: color.lerp(other[0], share),
            by_u: by_u.lerp(other[1], share),
            by_v: by_v.lerp(other[2], share),
            by_level: other[0] - color,
        }
    }
}

impl Texels {
    fn new(image: &Image) -> Self {
        let linear = |byte: u8| LINEAR_OF_SRGB[byte as usize];
        let texel = |p: &[u8]| Vec3::new(linear(p[0]), linear(p[1]), linear(p[2]));
        Self {
            width: image.width_px() as usize,
            height: image.height_px() as usize,
            colors: image.as_rgba().chunks_exact(4).map(texel).collect(),
        }
    }

    /// Color, and its derivatives by u and by v.
    #[inline]
    fn bilinear(&self, uv: Vec2) -> [Vec3; 3] {
        let (width, height) = (self.width as f32, self.height as f32);
        let x = (uv.x - floor(uv.x) as f32) * width - 0.5;
        let y = (1.0 - (uv.y - floor(uv.y) as f32)) * height - 0.5;
        let (left, upper) = (floor(x), floor(y));
        let (tx, ty) = (x - left as f32, y - upper as f32);
        let wrap = |c: i32, size: usize| {
            if c < 0 {
                size - 1
            } else if c as usize >= size {
                0
            } else {
                c as usize
            }
        };
        let (x0, x1) = (wrap(left, self.width), wrap(left + 1, self.width));
        let rows = [upper, upper + 1].map(|row| wrap(row, self.height) * self.width);
        let [above, below] = rows.map(|row| [self.colors[row + x0], self.colors[row + x1]]);
        let (top, bottom) = (above[0].lerp(above[1], tx), below[0].lerp(below[1], tx));
        let across = (above[1] - above[0]).lerp(below[1] - below[0], ty);
        [top.lerp(bottom, ty), width * across, -height * (bottom - top)]
    }
}
