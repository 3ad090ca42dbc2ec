//! Other materials: the top of a table in another of the catalog's, an object in another that keeps its color.

use catalog::tables::{TABLE_MATERIALS, refinished};
use catalog::texture::material_finish;
use geometry::{Material, TexturedMesh};
use rand::{Rng, RngExt as _};
use runtime::seed::child_rng;
use serde::{Deserialize, Serialize};

/// Finishes that have the color which they are given, so that an object keeps the color by which a task may call it.
const OF_OBJECTS: [&str; 6] = ["ceramic", "plastic", "rubber", "stoneware", "fabric", LACQUERED_METAL];
/// The one that the catalog does not have: its metals have their own colors.
const LACQUERED_METAL: &str = "lacquered_metal";
const LACQUERED_METAL_ROUGHNESS: f32 = 0.35;
/// Material that is never drawn: objects behind glass have no color and no depth of their own in images.
const LEFT_OUT: &str = "glass";

/// A material that was drawn.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct FinishSample {
    /// Name of the material in the catalog.
    pub material: String,
    /// Of its texture.
    pub seed: u32,
}

/// Draws a finish of a table with a probability.
pub(crate) fn of_table(rng: &mut impl Rng, probability: f64) -> Option<FinishSample> {
    let names: Vec<&str> = TABLE_MATERIALS.iter().copied().filter(|name| *name != LEFT_OUT).collect();
    drawn(rng, probability, &names)
}

/// Draws a finish of an object with a probability.
pub(crate) fn of_object(rng: &mut impl Rng, probability: f64) -> Option<FinishSample> {
    drawn(rng, probability, &OF_OBJECTS)
}

/// Equally many random numbers, whatever comes out.
fn drawn(rng: &mut impl Rng, probability: f64, names: &[&str]) -> Option<FinishSample> {
    let is_other = rng.random::<f64>() < probability;
    let (name, seed) = (names[rng.random_range(0..names.len())], rng.random());
    is_other.then(|| FinishSample { material: name.to_owned(), seed })
}

/// Whether a table's mesh is one of the catalog, which can have other finishes.
pub(crate) fn is_table_of_catalog(mesh: &TexturedMesh) -> bool {
    refinished(mesh, "oak", &mut child_rng(0, "finish")).is_some()
}

/// Whether most of an object's surface has one color, so that it can have another finish. Labels, skins of fruit and
/// glass stay as they are.
pub(crate) fn is_of_one_color(mesh: &TexturedMesh) -> bool {
    let main = main_material(mesh).map(|index| &mesh.materials[index]);
    main.is_some_and(|main| main.base_color_texture.is_none() && main.opacity >= 1.0)
}

/// A table's mesh with the finish that was drawn.
pub(crate) fn refinished_table(mesh: TexturedMesh, finish: Option<&FinishSample>) -> TexturedMesh {
    let Some(finish) = finish else { return mesh };
    let mut rng = child_rng(u64::from(finish.seed), "table");
    refinished(&mesh, &finish.material, &mut rng).unwrap_or(mesh)
}

/// An object's mesh with the finish that was drawn, in its own color.
pub(crate) fn refinished_object(mut mesh: TexturedMesh, finish: Option<&FinishSample>) -> TexturedMesh {
    let Some((finish, index)) = finish.zip(main_material(&mesh)) else { return mesh };
    let Material { name, base_color, .. } = mesh.materials[index].clone();
    let other = match finish.material.as_str() {
        LACQUERED_METAL => Material::metal(&name, base_color, LACQUERED_METAL_ROUGHNESS),
        material => material_finish(material, base_color, &mut child_rng(u64::from(finish.seed), "object")),
    };
    mesh.materials[index] = Material { name, ..other };
    mesh
}

/// The material with most of the surface.
fn main_material(mesh: &TexturedMesh) -> Option<usize> {
    let area_m2 = |triangles: &[[u32; 3]]| -> f64 {
        let corners = triangles.iter().map(|triangle| triangle.map(|v| mesh.positions[v as usize]));
        corners.map(|[a, b, c]| 0.5 * (b - a).cross(c - a).length()).sum()
    };
    let mut areas_m2 = vec![0.0; mesh.materials.len()];
    for group in &mesh.groups {
        areas_m2[group.material] += area_m2(&group.triangles);
    }
    (0..areas_m2.len()).max_by(|a, b| areas_m2[*a].total_cmp(&areas_m2[*b]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::shapes::block;
    use geometry::{DVec3, Rgb};

    fn mesh(material: &Material) -> TexturedMesh {
        let mut mesh = TexturedMesh::default();
        mesh.add(block(DVec3::splat(0.05)), material);
        // A small part of another color.
        mesh.add(block(DVec3::splat(0.01)), &Material::plain("knob", Rgb::hex(0x10_10_10), 0.5));
        mesh
    }

    #[test]
    fn objects_keep_their_color_in_every_finish() {
        let red = Rgb::hex(0xc0_30_2a);
        let before = mesh(&Material::plain("body", red, 0.5));
        for material in OF_OBJECTS {
            let finish = FinishSample { material: material.to_owned(), seed: 3 };
            let after = refinished_object(before.clone(), Some(&finish));
            let main = &after.materials[0];
            let textured = main.base_color_texture.as_ref().map(|texture| {
                let pixels = texture.as_rgba().chunks_exact(4);
                let count = pixels.len() as f32;
                let sum = pixels.fold([0.0; 3], |sum: [f32; 3], pixel| {
                    std::array::from_fn(|channel| sum[channel] + f32::from(pixel[channel]) / 255.0)
                });
                sum.map(|channel| channel / count)
            });
            let color = textured.unwrap_or(main.base_color.0);
            let apart = color.iter().zip(red.0).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
            assert!(apart < 0.12, "{material}: {color:?}");
            assert!(*main != before.materials[0], "{material} changes nothing");
            assert_eq!((main.name.as_str(), &after.materials[1]), ("body", &before.materials[1]));
        }
    }

    #[test]
    fn what_has_no_color_of_its_own_keeps_its_finish() {
        let plain = Material::plain("body", Rgb::hex(0x20_60_a0), 0.5);
        assert!(is_of_one_color(&mesh(&plain)));
        assert!(!is_of_one_color(&mesh(&Material { opacity: 0.4, ..plain })));
        assert!(!is_of_one_color(&TexturedMesh::default()));
    }

    #[test]
    fn a_probability_is_how_often_there_is_another_finish() {
        let mut rng = child_rng(4, "finish");
        let count = (0..1000).filter(|_| of_table(&mut rng, 0.3).is_some()).count();
        assert!((250..350).contains(&count), "{count}");
        assert_eq!(of_object(&mut rng, 0.0), None);
    }
}
