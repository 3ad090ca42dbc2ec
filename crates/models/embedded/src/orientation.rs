//! Random orientation of meshes: simulates the unit-sized, arbitrarily rotated output of mesh generators.

use glam::{DMat3, DQuat, DVec3};
use rand::RngExt;

use geometry::TexturedMesh;
use runtime::seed::child_rng;

/// Scales the longest extent of a mesh to 1, applies one of the 24 axis-aligned rotations selected by `seed`, and
/// centers its bounding box on the origin. A mesh without extent is only rotated.
pub fn randomly_oriented(mesh: TexturedMesh, seed: u64) -> TexturedMesh {
    let index = child_rng(seed, "orientation").random_range(0..24);
    let longest = mesh.size_m().max_element();
    let unit = if longest > 0.0 { mesh.scaled(DVec3::splat(1.0 / longest)) } else { mesh };
    let mesh = unit.rotated(axis_aligned(index));
    let (low, high) = mesh.bounds();
    mesh.translated(-0.5 * (low + high))
}

/// One of the 24 proper rotations that map axes to axes; 0 is the identity.
fn axis_aligned(index: usize) -> DQuat {
    let axes = [DVec3::X, DVec3::Y, DVec3::Z, -DVec3::X, -DVec3::Y, -DVec3::Z];
    let x = axes[(index / 4) % 6];
    let across: Vec<DVec3> = axes.into_iter().filter(|axis| axis.dot(x).abs() < 0.5).collect();
    let y = across[index % 4];
    DQuat::from_mat3(&DMat3::from_cols(x, y, x.cross(y))).normalize()
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::{Material, Rgb, shapes};

    #[test]
    fn axis_aligned_gives_24_distinct_proper_rotations() {
        let all: Vec<DQuat> = (0..24).map(axis_aligned).collect();
        assert!(all[0].abs_diff_eq(DQuat::IDENTITY, 1e-12));
        for (k, a) in all.iter().enumerate() {
            assert!((DMat3::from_quat(*a).determinant() - 1.0).abs() < 1e-12);
            assert!(all[k + 1..].iter().all(|b| a.dot(*b).abs() < 0.99));
        }
    }

    #[test]
    fn longest_extent_becomes_one_and_orientation_varies_with_seed() {
        let mut mesh = TexturedMesh::default();
        mesh.add(
            shapes::block(DVec3::new(0.3, 0.2, 0.1)),
            &Material::plain("paint", Rgb::hex(0x808080), 0.5),
        );
        let sizes: Vec<DVec3> = (0..12).map(|seed| randomly_oriented(mesh.clone(), seed).size_m()).collect();
        assert!(sizes.iter().all(|size| (size.max_element() - 1.0).abs() < 1e-9));
        assert!(sizes.iter().any(|size| (*size - sizes[0]).length() > 0.1));
        assert_eq!(randomly_oriented(mesh.clone(), 5), randomly_oriented(mesh, 5));
    }
}
