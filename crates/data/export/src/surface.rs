//! Normalization of a visual mesh for file formats.
//!
//! Positions are rounded to single precision, and triangles without area after rounding are removed. Normals have unit
//! length (the face normal where the mesh has none); texture coordinates are finite. Groups of one material are merged,
//! materials without faces are dropped, and material names are safe and unique.

use glam::{DVec3, Vec2, Vec3};

use geometry::{FaceGroup, Material, TexturedMesh};

/// The reason why a mesh cannot be normalized.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SurfaceFault {
    #[error("its vertex arrays differ in length")]
    ArrayLengths,
    #[error("a position of its mesh is not finite")]
    PositionNotFinite,
    #[error("a triangle of its mesh names a vertex that is not there")]
    NoVertex,
    #[error("a face group of its mesh wears a material that is not there")]
    NoMaterial,
    #[error("its mesh has no triangle")]
    NoTriangle,
}

/// The normalized mesh, or the reason why there is none.
pub fn printable_surface(mesh: &TexturedMesh) -> Result<TexturedMesh, SurfaceFault> {
    let count = mesh.positions.len();
    if mesh.normals.len() != count || mesh.uvs.len() != count {
        return Err(SurfaceFault::ArrayLengths);
    }
    if mesh.positions.iter().any(|p| !p.as_vec3().is_finite()) {
        return Err(SurfaceFault::PositionNotFinite);
    }
    if mesh.triangles().flatten().any(|v| v as usize >= count) {
        return Err(SurfaceFault::NoVertex);
    }
    // Adding zero turns -0 into 0, so that equal positions have equal bits and equal text.
    let positions: Vec<DVec3> =
        mesh.positions.iter().map(|p| (p.as_vec3() + Vec3::ZERO).as_dvec3()).collect();
    let mut groups: Vec<FaceGroup> = Vec::new();
    let mut materials: Vec<Material> = Vec::new();
    let mut written: Vec<Option<usize>> = vec![None; mesh.materials.len()];
    for group in &mesh.groups {
        let Some(material) = mesh.materials.get(group.material) else {
            return Err(SurfaceFault::NoMaterial);
        };
        let corner = |t: &[u32; 3], k: usize| positions[t[k] as usize];
        let triangles: Vec<[u32; 3]> = group
            .triangles
            .iter()
            .filter(|t| {
                corner(t, 0) != corner(t, 1) && corner(t, 1) != corner(t, 2) && corner(t, 2) != corner(t, 0)
            })
            .copied()
            .collect();
        if triangles.is_empty() {
            continue;
        }
        match written[group.material] {
            Some(index) => groups[index].triangles.extend(triangles),
            None => {
                written[group.material] = Some(groups.len());
                groups.push(FaceGroup { material: materials.len(), triangles });
                materials.push(Material { name: safe_name(&material.name, &materials), ..material.clone() });
            }
        }
    }
    if groups.is_empty() {
        return Err(SurfaceFault::NoTriangle);
    }
    let mut normals: Vec<Vec3> = mesh.normals.iter().map(|n| n.normalize_or_zero()).collect();
    for t in groups.iter().flat_map(|group| &group.triangles) {
        let [a, b, c] = t.map(|v| positions[v as usize]);
        for v in t.map(|v| v as usize) {
            if normals[v] == Vec3::ZERO {
                normals[v] = (b - a).cross(c - a).normalize_or(DVec3::Z).as_vec3();
            }
        }
    }
    normals.iter_mut().filter(|n| **n == Vec3::ZERO).for_each(|n| *n = Vec3::Z);
    let uvs = mesh.uvs.iter().map(|uv| if uv.is_finite() { *uv } else { Vec2::ZERO }).collect();
    Ok(TexturedMesh { positions, normals, uvs, groups, materials })
}

/// A name of the form `[a-z][a-z0-9_]*` that differs from the names of `taken`.
fn safe_name(name: &str, taken: &[Material]) -> String {
    let folded: String = name
        .chars()
        .take(40)
        .map(|c| c.to_ascii_lowercase())
        .map(|c| if c.is_ascii_alphanumeric() { c } else { '_' })
        .collect();
    let starts_well = folded.starts_with(|c: char| c.is_ascii_lowercase());
    let stem = if starts_well { folded } else { format!("m_{folded}") };
    let is_taken = |name: &str| taken.iter().any(|known| known.name == name);
    if is_taken(&stem) { format!("{stem}_{}", taken.len()) } else { stem }
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::{Rgb, shapes};

    #[test]
    fn printable_surface_repairs_or_rejects_bad_input() {
        let mut mesh = TexturedMesh::default();
        mesh.add(
            shapes::cylinder(0.1, 0.2, 0.0, 12),
            &Material::plain("7 Up \"can\"", Rgb::hex(0xff0000), 0.4),
        );
        mesh.normals[3] = Vec3::ZERO;
        mesh.uvs[2] = Vec2::NAN;
        mesh.groups.push(FaceGroup { material: 0, triangles: vec![[0, 0, 1]] });
        let clean = printable_surface(&mesh).expect("usable");
        assert_eq!(clean.triangle_count(), mesh.triangle_count() - 1);
        assert_eq!(clean.groups.len(), 1);
        assert_eq!(clean.materials[0].name, "m_7_up__can_");
        assert!(clean.normals.iter().all(|n| (n.length() - 1.0).abs() < 1e-5));
        assert!(clean.uvs.iter().all(|uv| uv.is_finite()));
        mesh.positions[0].x = f64::NAN;
        assert_eq!(printable_surface(&mesh), Err(SurfaceFault::PositionNotFinite));
        assert_eq!(printable_surface(&TexturedMesh::default()), Err(SurfaceFault::NoTriangle));
    }
}
