//! Compares how texture detail is distributed over the faces of two meshes' bounding boxes.
//!
//! A book has a title on its cover and none on its back, whatever the title; a keyboard has its letters on top. The
//! position of color variation is a property of the category more than of the object. It separates sides of equal
//! shape, and does not change with a generator's choice of colors.

use glam::{DQuat, DVec3, Vec2, Vec3};

use super::surface_samples::{CELLS, apart, centered};
use geometry::{Material, TexturedMesh};

/// Samples along a cell's side.
const SAMPLES: f64 = 4.0;

/// Mean of surface share times standard deviation of color below which a mesh counts as plain, sRGB 0..1.
const PLAIN: f64 = 0.005;

/// Dissimilarity 0..1 of the mesh to the example under each rotation: half the L1 distance between the shares of
/// texture detail in each cell of the box, both boxes stretched to the unit cube. 0 everywhere if either is plain.
pub fn costs(mesh: &TexturedMesh, turns: &[DQuat], example: &TexturedMesh) -> Vec<f64> {
    match (drawn(example), drawn(mesh)) {
        (Some(wanted), Some(found)) => turns.iter().map(|&turn| 0.5 * apart(&wanted, &found, turn)).collect(),
        _ => vec![0.0; turns.len()],
    }
}

/// Moments of the colors in one cell, weighted by area.
#[derive(Clone, Copy, Default)]
struct Moments {
    area: f64,
    sum: Vec3,
    squares: f64,
}

/// Share of the texture detail in each cell, x fastest: area times standard deviation of the color there.
fn drawn(mesh: &TexturedMesh) -> Option<Vec<f64>> {
    let cells = CELLS * CELLS * CELLS;
    let mut moments = vec![Moments::default(); cells * mesh.materials.len()];
    centered(mesh, SAMPLES, |sample| {
        let at = ((sample.in_box + 0.5) * CELLS as f64).clamp(DVec3::ZERO, DVec3::splat(CELLS as f64 - 0.5));
        let cell = (at.z as usize * CELLS + at.y as usize) * CELLS + at.x as usize;
        let cell = &mut moments[sample.material * cells + cell];
        let color = color(&mesh.materials[sample.material], sample.uv);
        cell.area += sample.area;
        cell.sum += sample.area as f32 * color;
        cell.squares += sample.area * f64::from(color.length_squared());
    });
    let whole: f64 = moments.iter().map(|cell| cell.area).sum::<f64>().max(1e-30);
    let mut drawn = vec![0.0; cells];
    for (k, of) in moments.iter().enumerate().filter(|(_, of)| of.area > 0.0) {
        let mean = of.sum.as_dvec3() / of.area;
        drawn[k % cells] += of.area / whole * (of.squares / of.area - mean.length_squared()).max(0.0).sqrt();
    }
    let total: f64 = drawn.iter().sum();
    (total > PLAIN).then(|| drawn.iter().map(|share| share / total).collect())
}

/// sRGB, each channel 0..1, of the texel nearest to these texture coordinates.
fn color(material: &Material, uv: Vec2) -> Vec3 {
    let own = Vec3::from(material.base_color.0);
    let Some(image) = &material.base_color_texture else { return own };
    let (width, height) = (image.width_px(), image.height_px());
    let texel = |at: f32, count: u32| ((at - at.floor()) * count as f32).min(count as f32 - 1.0) as u32;
    let [r, g, b, _] = image.pixel(texel(uv.x, width), height - 1 - texel(uv.y, height));
    own * Vec3::new(f32::from(r), f32::from(g), f32::from(b)) / 255.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::upright::rotations::axis_aligned;
    use catalog::{Recipe, build, category};
    use geometry::{Rgb, shapes};

    fn book(seed: u64) -> TexturedMesh {
        let size_m = category("book").expect("in the catalog").size.typical_m();
        build(&Recipe { category: "book".into(), size_m, color: None, material: None, seed }).expect("builds")
    }

    #[test]
    fn texture_detail_separates_cover_from_back() {
        let example = book(0);
        for seed in 1..6 {
            let costs = costs(
                &book(seed),
                &[DQuat::IDENTITY, DQuat::from_rotation_x(std::f64::consts::PI)],
                &example,
            );
            assert!(costs[0] + 0.3 < costs[1], "{seed}: {costs:?}");
        }
    }

    #[test]
    fn texture_detail_of_plain_mesh_is_zero() {
        let mut brick = TexturedMesh::default();
        brick.add(
            shapes::block(DVec3::new(0.2, 0.1, 0.05)),
            &Material::plain("clay", Rgb::hex(0xa0_50_30), 0.8),
        );
        assert_eq!(costs(&brick, &axis_aligned(), &book(0)), vec![0.0; 24]);
    }
}
