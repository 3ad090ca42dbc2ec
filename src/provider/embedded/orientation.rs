//! How generated meshes come: unit-sized, in any of the 24 axis-aligned orientations.

use glam::{DMat3, DQuat, DVec3};
use rand::RngExt;

use crate::geometry::TexturedMesh;
use crate::geometry::seed::child_rng;

/// The mesh scaled to a longest edge of 1, centered, and turned by a seeded one of the 24 rotations that
/// map axes to axes.
pub fn turned(mesh: TexturedMesh, seed: u64) -> TexturedMesh {
    let longest = mesh.size_m().max_element();
    let factor = if longest > 0.0 { 1.0 / longest } else { 1.0 };
    let (low, high) = mesh.bounds();
    let index = child_rng(seed, "orientation").random_range(0..24);
    mesh.translated(-0.5 * (low + high)).scaled(DVec3::splat(factor)).rotated(rotation(index))
}

/// The `index`-th (0..24) rotation of the cube.
fn rotation(index: usize) -> DQuat {
    let axes = [DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_Z];
    let first = axes[index / 4];
    let others: Vec<DVec3> = axes.into_iter().filter(|axis| axis.dot(first).abs() < 0.5).collect();
    let second = others[index % 4];
    DQuat::from_mat3(&DMat3::from_cols(first, second, first.cross(second))).normalize()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_24_rotations_differ_and_map_axes_to_axes() {
        for a in 0..24 {
            let turned = rotation(a) * DVec3::X;
            assert!((turned.abs().max_element() - 1.0).abs() < 1e-12, "{turned}");
            for b in 0..a {
                assert!(rotation(a).angle_between(rotation(b)) > 0.1, "{a} {b}");
            }
        }
    }
}
