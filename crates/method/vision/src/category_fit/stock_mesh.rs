//! Light meshes of the catalog's categories, built once a process when they are first compared.
//!
//! They are a pure function of the catalog, so results do not depend on the order of construction. Stand-ins and
//! categories of a stated size have meshes of their own, in that size.

use std::collections::BTreeMap;
use std::f64::consts::FRAC_PI_2;
use std::sync::{LazyLock, OnceLock};

use glam::{DQuat, DVec3, Vec3};

use super::views::{self, View};
use crate::pixels::{lab_of, lab_of_srgb};
use catalog::{Category, Recipe, SizeRange};
use geometry::{Rgb, TexturedMesh};

/// Variants of a category: its generator runs with this many seeds.
pub(super) const VARIANTS: usize = 2;

/// Vertex-clustering cells along the longest extent, for outlines.
const OUTLINE_CELLS: f32 = 30.0;

/// Step between elevations with precomputed views.
pub(super) const ELEVATION_STEP_RAD: f64 = 0.105;
const ELEVATIONS: usize = 16;

/// A mesh of a category in its canonical frame, at its usual size.
pub(super) struct StockMesh {
    /// Number of yaws at which it appears the same; 0 stands for any.
    pub symmetry_order: u32,
    pub is_lying: bool,
    pub variant: u64,
    /// Extents, meters.
    pub size_m: DVec3,
    pub positions: Vec<Vec3>,
    pub triangles: Vec<[u32; 3]>,
    /// Part of each triangle; each part has its material.
    pub part: Vec<u8>,
    /// Outward normal of each triangle, as its corners are shaded.
    pub normal: Vec<Vec3>,
    /// CIELAB of each triangle's center, and of each part as a whole.
    pub surface_lab: Vec<[f32; 3]>,
    pub part_lab: Vec<[f32; 3]>,
    /// The same shape with few triangles.
    pub outline_positions: Vec<Vec3>,
    pub outline_triangles: Vec<[u32; 3]>,
    views: Vec<OnceLock<Vec<View>>>,
}

/// Meshes and palette of a category.
pub(super) struct StockCategory {
    pub category: &'static Category,
    /// Extents of small and large specimens.
    pub size: SizeRange,
    meshes: [OnceLock<Option<StockMesh>>; VARIANTS],
    lying: OnceLock<Option<StockMesh>>,
    /// CIELAB.
    pub palette: Vec<[f32; 3]>,
}

/// The category with its meshes, of usual size; `None` for a hidden one.
pub(super) fn stock_of(category: &Category) -> Option<&'static StockCategory> {
    stock().iter().find(|stock| stock.category.name == category.name)
}

/// Every category of the catalog, in its order.
fn stock() -> &'static [StockCategory] {
    static STOCK: LazyLock<Vec<StockCategory>> = LazyLock::new(|| {
        let of = |category: &'static Category| StockCategory::new(category, category.size);
        catalog::categories().iter().map(of).collect()
    });
    &STOCK
}

/// From this ratio of height to width on, a mesh may also lie on its side.
const SLIM: f64 = 1.6;

impl StockCategory {
    pub fn new(category: &'static Category, size: SizeRange) -> Self {
        let hex = category.palette.iter().map(|text| u32::from_str_radix(text.trim_start_matches('#'), 16));
        let palette = hex.flatten().map(|hex| lab_of_srgb(Rgb::hex(hex))).collect();
        Self { category, size, meshes: Default::default(), lying: OnceLock::new(), palette }
    }

    /// The mesh of that variant; `None` where the catalog makes none.
    pub fn mesh(&self, variant: usize) -> Option<&StockMesh> {
        self.meshes[variant].get_or_init(|| self.build(variant, false)).as_ref()
    }

    /// The mesh of the first variant on its side; `None` for what is not slim.
    pub fn lying_mesh(&self) -> Option<&StockMesh> {
        self.lying.get_or_init(|| self.build(0, true)).as_ref()
    }

    fn build(&self, variant: usize, is_lying: bool) -> Option<StockMesh> {
        let upright = catalog::build(&Recipe {
            category: self.category.name.clone(),
            size_m: self.size.typical_m(),
            color: None,
            material: None,
            seed: variant as u64,
        })?;
        if !is_lying {
            return Some(StockMesh::new(&upright, self.category.symmetry_order, variant as u64, false));
        }
        let size_m = upright.size_m();
        let lying = (size_m.z > SLIM * size_m.x.max(size_m.y))
            .then(|| upright.rotated(DQuat::from_rotation_x(FRAC_PI_2)).seated())?;
        Some(StockMesh::new(&lying, 1, variant as u64, true))
    }
}

impl StockMesh {
    fn new(mesh: &TexturedMesh, symmetry_order: u32, variant: u64, is_lying: bool) -> Self {
        let positions: Vec<Vec3> = mesh.positions.iter().map(|p| p.as_vec3()).collect();
        let (mut triangles, mut part, mut normal, mut surface_lab) =
            (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        let mut part_lab = vec![[0.0; 3]; mesh.groups.len()];
        for (index, group) in mesh.groups.iter().enumerate() {
            let surface = SurfaceColor::new(mesh, group.material);
            part_lab[index] = surface.mean;
            for t in &group.triangles {
                triangles.push(*t);
                part.push(index.min(usize::from(u8::MAX)) as u8);
                let [a, b, c] = t.map(|v| mesh.normals[v as usize]);
                normal.push((a + b + c).normalize_or_zero());
                surface_lab.push(surface.at(mesh, t));
            }
        }
        let (outline_positions, outline_triangles) = cluster_vertices(&positions, &triangles);
        Self {
            symmetry_order,
            is_lying,
            variant,
            size_m: mesh.size_m(),
            positions,
            triangles,
            part,
            normal,
            surface_lab,
            part_lab,
            outline_positions,
            outline_triangles,
            views: (0..ELEVATIONS).map(|_| OnceLock::new()).collect(),
        }
    }

    /// Outlines of the mesh from all directions, at about this elevation, rendered at the first call.
    pub fn views(&self, elevation_rad: f64) -> &[View] {
        let at = (elevation_rad / ELEVATION_STEP_RAD).floor().clamp(0.0, ELEVATIONS as f64 - 1.0) as usize;
        self.views[at].get_or_init(|| views::around(self, (at as f64 + 0.5) * ELEVATION_STEP_RAD))
    }
}

/// Surface color of a group of triangles.
struct SurfaceColor {
    mean: [f32; 3],
    base: [f32; 3],
    /// A few texels a side, CIELAB.
    texels: Option<(usize, usize, Vec<[f32; 3]>)>,
}

/// Longer side of a texture as it is compared.
const TEXTURE_PX: u32 = 16;

impl SurfaceColor {
    fn new(mesh: &TexturedMesh, material: usize) -> Self {
        let material = &mesh.materials[material];
        let base = material.base_color.to_linear();
        let Some(texture) = &material.base_color_texture else {
            return Self { mean: lab_of(base), base, texels: None };
        };
        let small =
            texture.halved().iter().find(|level| level.width_px().max(level.height_px()) <= TEXTURE_PX);
        let small = small.unwrap_or(texture);
        let lab = |p: &[u8]| {
            let light = Rgb([0, 1, 2].map(|k| f32::from(p[k]) / 255.0)).to_linear();
            lab_of(std::array::from_fn(|k| light[k] * base[k]))
        };
        let texels: Vec<[f32; 3]> = small.as_rgba().chunks_exact(4).map(lab).collect();
        let mean =
            std::array::from_fn(|k| texels.iter().map(|t| t[k]).sum::<f32>() / texels.len().max(1) as f32);
        Self { mean, base, texels: Some((small.width_px() as usize, small.height_px() as usize, texels)) }
    }

    fn at(&self, mesh: &TexturedMesh, triangle: &[u32; 3]) -> [f32; 3] {
        let Some((width, height, texels)) = &self.texels else { return lab_of(self.base) };
        let [a, b, c] = triangle.map(|v| mesh.uvs[v as usize]);
        let uv = (a + b + c) / 3.0;
        let index = |share: f32, size: usize| ((share.rem_euclid(1.0) * size as f32) as usize).min(size - 1);
        texels[index(1.0 - uv.y, *height) * width + index(uv.x, *width)]
    }
}

/// Vertex clustering: all vertices in a cell merge into their mean; the bounding box is restored.
fn cluster_vertices(positions: &[Vec3], triangles: &[[u32; 3]]) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let bounds = |points: &[Vec3]| {
        points.iter().fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), p| (low.min(*p), high.max(*p)))
    };
    let (low, high) = bounds(positions);
    let cell = ((high - low).max_element() / OUTLINE_CELLS).max(1e-9);
    let mut cells: BTreeMap<[i32; 3], u32> = BTreeMap::new();
    let mut sums: Vec<(Vec3, f32)> = Vec::new();
    let of: Vec<u32> = positions
        .iter()
        .map(|p| {
            let key = ((*p - low) / cell).floor().to_array().map(|c| c as i32);
            let index = *cells.entry(key).or_insert_with(|| {
                sums.push((Vec3::ZERO, 0.0));
                sums.len() as u32 - 1
            });
            let (sum, count) = &mut sums[index as usize];
            (*sum, *count) = (*sum + *p, *count + 1.0);
            index
        })
        .collect();
    let mut drawn: Vec<Vec3> = sums.into_iter().map(|(sum, count)| sum / count).collect();
    let (own_low, own_high) = bounds(&drawn);
    let stretch = (high - low) / (own_high - own_low).max(Vec3::splat(1e-6));
    drawn.iter_mut().for_each(|p| *p = low + (*p - own_low) * stretch.min(Vec3::splat(1.5)));
    let mut kept: Vec<[u32; 3]> = triangles.iter().map(|t| t.map(|v| of[v as usize])).collect();
    kept.retain(|[a, b, c]| a != b && b != c && c != a);
    kept.iter_mut().for_each(|t| {
        let first = (0..3).min_by_key(|k| t[*k]).unwrap_or(0);
        t.rotate_left(first);
    });
    kept.sort_unstable();
    kept.dedup();
    (drawn, kept)
}
