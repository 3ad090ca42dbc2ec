//! Height of an object's bottom above the table, given the objects that carry it.

use glam::{DVec2, DVec3};

use geometry::TexturedMesh;

/// World z of the bottom of an object centered on these supporters: the canonical meshes (meters) of everything below
/// it, in any order. Each counts with the height of its surface at its center (a plate's well, not its rim), or of its
/// box if it has a hole there. 0 for none. Cost: each triangle once.
pub fn support_height_m<'a>(below: impl Iterator<Item = &'a TexturedMesh>) -> f64 {
    below.map(height_over_center_m).sum()
}

fn height_over_center_m(mesh: &TexturedMesh) -> f64 {
    let (low, high) = mesh.bounds();
    let center = 0.5 * (low + high).truncate();
    let top = mesh
        .triangles()
        .filter_map(|corners| height_at(corners.map(|v| mesh.positions[v as usize]), center))
        .fold(f64::NEG_INFINITY, f64::max);
    if top.is_finite() { top - low.z } else { high.z - low.z }
}

/// Height at which the upright line through the point meets the triangle, borders included.
fn height_at([a, b, c]: [DVec3; 3], point: DVec2) -> Option<f64> {
    let [ab, ac, ap] = [b.truncate() - a.truncate(), c.truncate() - a.truncate(), point - a.truncate()];
    let area = ab.perp_dot(ac);
    let (u, v) = (ap.perp_dot(ac) / area, ab.perp_dot(ap) / area);
    // The center of a fan lies on corners of all its triangles; a vertical triangle has no area and gives NaN.
    let inside = u >= -1e-9 && v >= -1e-9 && u + v <= 1.0 + 1e-9;
    inside.then_some(a.z + u * (b.z - a.z) + v * (c.z - a.z))
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::{Material, Rgb, shapes};

    fn gray(solid: geometry::Solid) -> TexturedMesh {
        let mut mesh = TexturedMesh::default();
        mesh.add(solid, &Material::plain("gray", Rgb::hex(0x808080), 0.5));
        mesh
    }

    #[test]
    fn support_height_of_stack_is_sum_of_heights() {
        let book = gray(shapes::block(DVec3::new(0.2, 0.15, 0.03)));
        let cone = gray(shapes::cone(0.05, 0.02, 0.12, 32));
        assert_eq!(support_height_m([].into_iter()), 0.0);
        assert!((support_height_m([&book, &cone].into_iter()) - 0.15).abs() < 1e-9);
    }

    #[test]
    fn support_height_of_plate_is_its_well() {
        let category = catalog::category("plate").expect("in the catalog");
        let recipe = catalog::Recipe {
            category: category.name.clone(),
            size_m: category.size.typical_m(),
            color: None,
            material: None,
            seed: 3,
        };
        let plate = catalog::build(&recipe).expect("builds");
        let height_m = support_height_m([&plate].into_iter());
        assert!(height_m > 0.0 && height_m < 0.8 * plate.size_m().z, "{height_m}");
    }
}
