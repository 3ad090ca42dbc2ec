//! Mesh degradation as in generated meshes: stretched, coarse, recolored.

use glam::DVec3;
use rand::RngExt;

use super::Noise;
use geometry::decimate::decimated;
use geometry::{Rgb, TexturedMesh};
use runtime::seed::child_rng;

/// The mesh stretched along its axes, decimated and recolored. It gets the textures of `other`, the same category
/// built from another seed, if that has as many materials.
pub fn degrade(mesh: TexturedMesh, other: Option<&TexturedMesh>, noise: &Noise, seed: u64) -> TexturedMesh {
    let mut rng = child_rng(seed, "stretch");
    let mut factor = || 1.0 + noise.stretch_share * rng.random_range(-1.0..1.0);
    let stretch = DVec3::new(factor(), factor(), factor());
    let max_triangles = (noise.kept_triangles * mesh.triangle_count() as f64) as usize;
    let max_off_m = noise.mesh_off_share * mesh.size_m().max_element();
    let mut mesh = decimated(&mesh.scaled(stretch), max_triangles, max_off_m);
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

#[cfg(test)]
mod tests {
    use super::*;
    use catalog::{Recipe, build};
    use geometry::solid_query::MeshSolid;

    #[test]
    fn degraded_meshes_are_coarser_and_still_solids() {
        for category in ["mug", "fork", "laptop", "potted_plant"] {
            let size_m = catalog::category(category).expect("known").size.typical_m();
            let recipe = Recipe { category: category.into(), size_m, color: None, material: None, seed: 4 };
            let mesh = build(&recipe).expect("builds");
            let degraded = degrade(mesh.clone(), None, &Noise::NOISY, 8);
            assert!(3 * degraded.triangle_count() < 2 * mesh.triangle_count(), "{category}");
            let ratio = degraded.size_m() / mesh.size_m();
            assert!(ratio.min_element() > 0.92 && ratio.max_element() < 1.07, "{category}: {ratio}");
            assert!(MeshSolid::new(&degraded).is_ok(), "{category}");
        }
    }
}
