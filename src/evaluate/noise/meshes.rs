//! Meshes as a generator leaves them: out of proportion, coarse, in other colors than the thing's.

use std::collections::BTreeMap;

use glam::DVec3;
use rand::RngExt;

use super::Noise;
use crate::geometry::seed::child_rng;
use crate::geometry::{FaceGroup, Rgb, TexturedMesh};

/// The mesh stretched along its axes, its corners merged on a grid, its materials recolored. Where `other`, the same
/// kind of thing built from another seed, has as many materials, its textures are worn.
pub fn worn(mesh: TexturedMesh, other: Option<&TexturedMesh>, noise: &Noise, seed: u64) -> TexturedMesh {
    let mut rng = child_rng(seed, "stretch");
    let mut factor = || 1.0 + noise.stretch_share * rng.random_range(-1.0..1.0);
    let stretch = DVec3::new(factor(), factor(), factor());
    let mut mesh = merged(mesh.scaled(stretch), noise.mesh_cells);
    let mut rng = child_rng(seed, "recolor");
    let other = other.filter(|other| other.materials.len() == mesh.materials.len());
    for (index, material) in mesh.materials.iter_mut().enumerate() {
        if let Some(other) = other {
            material.base_color_texture = other.materials[index].base_color_texture.clone();
            material.base_color = other.materials[index].base_color;
        }
        let factors = [0; 3].map(|_| 1.0 + noise.recolor_share as f32 * rng.random_range(-1.0..1.0_f32));
        let channels = material.base_color.0;
        material.base_color = Rgb([0, 1, 2].map(|c| (channels[c] * factors[c]).clamp(0.0, 1.0)));
    }
    mesh
}

/// Corners in one cell of a grid over the mesh's box meet in their middle; triangles without area go. A closed
/// surface stays closed.
fn merged(mut mesh: TexturedMesh, cells: u32) -> TexturedMesh {
    let (low, high) = mesh.bounds();
    let cell = (high - low).max(DVec3::splat(1e-9)) / f64::from(cells.max(1));
    let key = |p: DVec3| ((p - low) / cell).round().to_array().map(|c| c as i64);
    let mut middles: BTreeMap<[i64; 3], (DVec3, f64)> = BTreeMap::new();
    for &p in &mesh.positions {
        let middle = middles.entry(key(p)).or_insert((DVec3::ZERO, 0.0));
        *middle = (middle.0 + p, middle.1 + 1.0);
    }
    mesh.positions.iter_mut().for_each(|p| {
        if let Some((sum, count)) = middles.get(&key(*p)) {
            *p = *sum / *count;
        }
    });
    let positions = &mesh.positions;
    let has_area = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|v| positions[v as usize]);
        a != b && b != c && c != a
    };
    for FaceGroup { triangles, .. } in &mut mesh.groups {
        triangles.retain(has_area);
    }
    mesh
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::catalog::{Recipe, build};
    use crate::geometry::mesh_solid::MeshSolid;

    #[test]
    fn worn_meshes_are_coarser_and_still_solids() {
        for category in ["mug", "fork", "laptop", "potted_plant"] {
            let size_m = crate::catalog::category(category).expect("known").size.typical_m();
            let recipe = Recipe { category: category.into(), size_m, color: None, material: None, seed: 4 };
            let mesh = build(&recipe).expect("builds");
            let worn = worn(mesh.clone(), None, &Noise::NOISY, 8);
            assert!(worn.triangle_count() <= mesh.triangle_count(), "{category}");
            let ratio = worn.size_m() / mesh.size_m();
            assert!(ratio.min_element() > 0.92 && ratio.max_element() < 1.07, "{category}: {ratio}");
            assert!(MeshSolid::new(&worn).is_ok(), "{category}");
        }
    }
}
