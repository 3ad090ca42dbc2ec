//! The 24 axis-aligned rotations.

use glam::{DMat3, DQuat, DVec3};

/// The six directions that may be up in the raw mesh.
pub fn up_directions() -> Vec<DVec3> {
    vec![DVec3::Z, -DVec3::Z, DVec3::Y, -DVec3::Y, DVec3::X, -DVec3::X]
}

/// All 24, the identity first; rotations with the same up direction are adjacent.
pub fn axis_aligned() -> Vec<DQuat> {
    let axes = [DVec3::X, DVec3::Y, -DVec3::X, -DVec3::Y, DVec3::Z, -DVec3::Z];
    up_directions()
        .into_iter()
        .flat_map(|up| {
            axes.into_iter().filter(move |right| right.dot(up).abs() < 0.5).map(move |right| {
                // Rows are the raw directions that become x, y and z.
                let rows = DMat3::from_cols(right, up.cross(right), up);
                DQuat::from_mat3(&rows.transpose()).normalize()
            })
        })
        .collect()
}

/// The raw direction that the rotation turns up.
pub fn raw_up(canonical_from_raw: DQuat) -> DVec3 {
    canonical_from_raw.conjugate() * DVec3::Z
}

/// Extents after the rotation.
pub fn turned_size(size: DVec3, canonical_from_raw: DQuat) -> DVec3 {
    (canonical_from_raw * size).abs()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axis_aligned_gives_24_distinct_rotations() {
        let all = axis_aligned();
        assert_eq!(all.len(), 24);
        for (k, a) in all.iter().enumerate() {
            for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
                assert!(((*a * axis).abs().max_element() - 1.0).abs() < 1e-12);
            }
            assert!(all[k + 1..].iter().all(|b| a.dot(*b).abs() < 0.99));
        }
        assert!(all[0].abs_diff_eq(DQuat::IDENTITY, 1e-12));
    }
}
