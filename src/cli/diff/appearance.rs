//! Appearance of a body by its visual mesh: its mean color, its materials, its triangles.

use super::compare::Appearance;
use geometry::{Rgb, TexturedMesh};
use store::Digest;

impl Appearance {
    /// Of a mesh. The mean color weighs faces by their area and textures as a whole.
    pub fn of(mesh: &TexturedMesh) -> Self {
        let plain = mesh.without_textures();
        let plain = plain.as_ref().unwrap_or(mesh);
        let (mut sum, mut area_m2) = ([0.0; 3], 0.0);
        for group in &plain.groups {
            let own_m2: f64 = group.triangles.iter().map(|&triangle| area_of(plain, triangle)).sum();
            let Rgb(color) = plain.materials[group.material].base_color;
            (0..3).for_each(|channel| sum[channel] += own_m2 * f64::from(color[channel]));
            area_m2 += own_m2;
        }
        let mean = |channel: f64| if area_m2 > 0.0 { (channel / area_m2) as f32 } else { 0.0 };
        let [red, green, blue, _] = Rgb(sum.map(mean)).to_rgba8();
        let mut materials: Vec<String> =
            mesh.materials.iter().map(|material| material.name.clone()).collect();
        materials.sort();
        let triangles: Vec<u8> = mesh.triangles().flatten().flat_map(u32::to_le_bytes).collect();
        Self { color: [red, green, blue], materials, triangles: Digest::of(&triangles).to_string() }
    }
}

fn area_of(mesh: &TexturedMesh, triangle: [u32; 3]) -> f64 {
    let [a, b, c] = triangle.map(|vertex| mesh.positions[vertex as usize]);
    0.5 * (b - a).cross(c - a).length()
}

#[cfg(test)]
mod tests {
    use geometry::{FaceGroup, Material};
    use glam::{DVec3, Vec2, Vec3};

    use super::*;

    /// A red triangle and a blue one of three times its area.
    fn mesh() -> TexturedMesh {
        let positions = [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (3.0, 0.0)];
        TexturedMesh {
            positions: positions.map(|(x, y)| DVec3::new(x, y, 0.0)).to_vec(),
            normals: vec![Vec3::Z; 4],
            uvs: vec![Vec2::ZERO; 4],
            groups: vec![
                FaceGroup { material: 0, triangles: vec![[0, 1, 2]] },
                FaceGroup { material: 1, triangles: vec![[0, 3, 2]] },
            ],
            materials: vec![
                Material::plain("red", Rgb([1.0, 0.0, 0.0]), 0.5),
                Material::plain("blue", Rgb([0.0, 0.0, 0.8]), 0.5),
            ],
        }
    }

    #[test]
    fn the_mean_color_weighs_by_area() {
        let appearance = Appearance::of(&mesh());
        assert_eq!(appearance.color, [64, 0, 153]);
        assert_eq!(appearance.materials, ["blue", "red"]);
    }

    #[test]
    fn a_scale_changes_nothing_and_another_triangle_the_digest() {
        let appearance = Appearance::of(&mesh());
        assert_eq!(Appearance::of(&mesh().scaled(DVec3::splat(2.0))), appearance);
        let mut other = mesh();
        other.groups[0].triangles[0] = [1, 2, 0];
        let other = Appearance::of(&other);
        assert_ne!(other.triangles, appearance.triangles);
        assert_eq!(other.color, appearance.color);
    }

    #[test]
    fn an_empty_mesh_is_black() {
        assert_eq!(Appearance::of(&TexturedMesh::default()).color, [0, 0, 0]);
    }
}
