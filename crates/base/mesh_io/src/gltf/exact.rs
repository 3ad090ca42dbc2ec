//! Meshes that a GLB file holds exactly.

use std::collections::BTreeSet;

use super::read::{Limits, MAX_NAME_CHARS};
use geometry::{FaceGroup, Material, TexturedMesh};

/// Whether [`super::read_mesh_glb`] returns exactly this mesh from the file that [`super::write_mesh_glb`] makes: the
/// reader folds, clamps and bounds nothing, and every number is exact in single precision. It may be `false` of a mesh
/// that does read back equal.
pub fn reads_back_equal(mesh: &TexturedMesh) -> bool {
    let TexturedMesh { positions, normals, uvs, groups, materials } = mesh;
    let vertices = positions.len();
    let fits = vertices <= Limits::VERTICES
        && normals.len() == vertices
        && uvs.len() == vertices
        && mesh.triangle_count() <= Limits::TRIANGLES
        && groups.len() <= Limits::MATERIALS
        && materials.len() <= Limits::MATERIALS;
    let textures = materials.iter().filter_map(|material| material.base_color_texture.as_deref());
    let areas_px = textures.map(|texture| u64::from(texture.width_px()) * u64::from(texture.height_px()));
    let areas_px: Vec<u64> = areas_px.collect();
    let mut names = BTreeSet::new();
    let is_name_kept = |name: &str| {
        let kept = |byte: u8| byte.is_ascii_lowercase() || byte.is_ascii_digit() || byte == b'_';
        !name.is_empty() && name.len() <= MAX_NAME_CHARS && name.bytes().all(kept)
    };
    let is_unit = |value: f32| (0.0..=1.0).contains(&value);
    let is_kept = |material: &Material| {
        let [r, g, b] = material.base_color.0;
        [r, g, b, material.roughness, material.metalness, material.opacity, material.relief]
            .into_iter()
            .all(is_unit)
            && is_name_kept(&material.name)
    };
    let is_drawn = |group: &FaceGroup| {
        let corners = group.triangles.as_flattened();
        !corners.is_empty()
            && group.material < materials.len()
            && corners.iter().all(|vertex| (*vertex as usize) < vertices)
    };
    fits && !groups.is_empty()
        && groups.iter().all(is_drawn)
        && materials.iter().all(|material| is_kept(material) && names.insert(&material.name))
        && areas_px.iter().all(|area_px| *area_px > 0)
        && areas_px.iter().sum::<u64>() <= Limits::PIXELS
        && positions.iter().all(|p| p.is_finite() && p.as_vec3().as_dvec3() == *p)
        && normals.iter().all(|normal| normal.is_finite())
        && uvs.iter().all(|uv| uv.is_finite())
}

#[cfg(test)]
mod tests {
    use super::super::read::tests::two_tone_mesh;
    use super::super::{read_mesh_glb, write_mesh_glb};
    use super::*;

    #[test]
    fn reads_back_equal_is_false_where_the_reader_changes_something() {
        let mesh = two_tone_mesh();
        assert!(reads_back_equal(&mesh));
        let changes: [fn(&mut TexturedMesh); 9] = [
            |mesh| mesh.materials[0].name = "Label".to_owned(),
            |mesh| mesh.materials[0].name = mesh.materials[1].name.clone(),
            |mesh| mesh.materials[0].name.clear(),
            |mesh| mesh.materials[1].opacity = 1.5,
            |mesh| mesh.materials[1].base_color.0[2] = -0.1,
            |mesh| mesh.positions[0].x += 1e-12,
            |mesh| mesh.normals[3].y = f32::NAN,
            |mesh| mesh.groups[1].triangles.clear(),
            |mesh| mesh.groups.clear(),
        ];
        for (k, change) in changes.iter().enumerate() {
            let mut changed = mesh.clone();
            change(&mut changed);
            assert!(!reads_back_equal(&changed), "change {k}");
            assert_ne!(read_mesh_glb(&write_mesh_glb(&changed)).ok(), Some(changed), "change {k}");
        }
    }
}
