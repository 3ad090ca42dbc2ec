//! Back-face culling for closed meshes.

use glam::DVec3;

use geometry::{Material, TexturedMesh};

/// Whether the counted faces bound a closed volume with outward normals. Then every back face is hidden by a front
/// face. (A part turned inside out in an otherwise correct mesh is not detected; it then shows its inside, as in
/// viewers that follow glTF literally.)
///
/// The condition is that every edge is used equally often in both directions. The counts are not stored: each directed
/// edge adds a random number of its own, or subtracts it in the other direction. The sum is zero if all counts are,
/// and otherwise with probability 2^-64.
pub fn shows_no_backs(mesh: &TexturedMesh, counts: impl Fn(&Material) -> bool) -> bool {
    // Adding zero turns -0.0 into 0.0, which compare equal but differ in bits.
    let number = |p: &DVec3| (*p + DVec3::ZERO).to_array().iter().fold(0, |sum, c| mixed(sum, c.to_bits()));
    let numbers: Vec<u64> = mesh.positions.iter().map(number).collect();
    let (mut edges, mut volume_m3) = (0_u64, 0.0);
    for group in mesh.groups.iter().filter(|group| counts(&mesh.materials[group.material])) {
        for triangle in &group.triangles {
            let [p, q, r] = triangle.map(|v| mesh.positions[v as usize]);
            volume_m3 += p.dot(q.cross(r)) / 6.0;
            let [a, b, c] = triangle.map(|v| numbers[v as usize]);
            for (from, to) in [(a, b), (b, c), (c, a)] {
                let own = mixed(from.min(to), from.max(to));
                edges = if from < to { edges.wrapping_add(own) } else { edges.wrapping_sub(own) };
            }
        }
    }
    edges == 0 && volume_m3 > 0.0
}

/// Pseudorandom number from two inputs (finalizer of SplitMix64, Steele et al. 2014).
fn mixed(a: u64, b: u64) -> u64 {
    let mut z = a.rotate_left(25).wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ b;
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::{Rgb, shapes};

    #[test]
    fn shows_no_backs_is_true_for_closed_solids_only() {
        let gray = Material::plain("gray", Rgb([0.5; 3]), 0.5);
        let mut mesh = TexturedMesh::default();
        mesh.add(shapes::block(DVec3::new(0.1, 0.2, 0.3)), &gray);
        mesh.add(shapes::cone(0.05, 0.02, 0.12, 32).translated(DVec3::X), &gray);
        assert!(shows_no_backs(&mesh, |_| true));
        let mut open = mesh.clone();
        open.groups[0].triangles.pop();
        assert!(!shows_no_backs(&open, |_| true));
        let mut inside_out = mesh.clone();
        inside_out.groups.iter_mut().flat_map(|g| &mut g.triangles).for_each(|t| t.swap(0, 1));
        assert!(!shows_no_backs(&inside_out, |_| true));
        let mut one_turned = mesh.clone();
        one_turned.groups[0].triangles[0].swap(0, 1);
        assert!(!shows_no_backs(&one_turned, |_| true));
        // Half glass: the opaque half alone is open.
        let mut half = mesh;
        let glass = half.materials.len();
        half.materials.push(Material { opacity: 0.2, ..gray });
        let triangles = half.groups[0].triangles.split_off(5);
        half.groups.push(geometry::FaceGroup { material: glass, triangles });
        assert!(shows_no_backs(&half, |_| true));
        assert!(!shows_no_backs(&half, |material| material.opacity > 0.5));
    }
}
