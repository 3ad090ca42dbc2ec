//! The mesh as a silhouette needs it: welded positions and triangles, thinned where there are too many.

use std::collections::BTreeMap;

use glam::DVec3;

use crate::geometry::TexturedMesh;

/// Positions (object frame, meters) and triangles without attributes.
#[derive(Clone, Debug)]
pub struct OutlineMesh {
    pub positions: Vec<DVec3>,
    pub triangles: Vec<[u32; 3]>,
    /// Lowest and highest corner of its box.
    pub bounds: (DVec3, DVec3),
}

/// Meshes up to this size are only welded.
const PLAIN_TRIANGLES: usize = 20_000;

impl OutlineMesh {
    /// Welds equal positions; a mesh of more than 20,000 triangles is merged on a grid of `cells` along
    /// its largest extent.
    pub fn new(mesh: &TexturedMesh, cells: u32) -> Self {
        let bounds = mesh.bounds();
        let largest = (bounds.1 - bounds.0).max_element().max(1e-9);
        let divisions = if mesh.triangle_count() > PLAIN_TRIANGLES { f64::from(cells.max(8)) } else { 1e6 };
        let cell = largest / divisions;
        let mut known: BTreeMap<[i64; 3], u32> = BTreeMap::new();
        let (mut sums, mut counts): (Vec<DVec3>, Vec<f64>) = (Vec::new(), Vec::new());
        let merged: Vec<u32> = mesh
            .positions
            .iter()
            .map(|&p| {
                let key = ((p - bounds.0) / cell).round().to_array().map(|c| c as i64);
                let index = *known.entry(key).or_insert_with(|| {
                    sums.push(DVec3::ZERO);
                    counts.push(0.0);
                    sums.len() as u32 - 1
                });
                sums[index as usize] += p;
                counts[index as usize] += 1.0;
                index
            })
            .collect();
        let mut triangles: Vec<[u32; 3]> = mesh
            .triangles()
            .map(|t| t.map(|v| merged[v as usize]))
            .filter(|[a, b, c]| a != b && b != c && c != a)
            .map(|mut t| {
                t.sort_unstable();
                t
            })
            .collect();
        triangles.sort_unstable();
        triangles.dedup();
        let positions = sums.iter().zip(&counts).map(|(sum, count)| *sum / *count).collect();
        Self { positions, triangles, bounds }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Material, Rgb, shapes};

    #[test]
    fn thins_a_fine_mesh_and_keeps_its_box() {
        let mut mesh = TexturedMesh::default();
        mesh.add(shapes::sphere(0.1, 200), &Material::plain("gray", Rgb::hex(0x808080), 0.5));
        let (plain, thin) = (OutlineMesh::new(&mesh, 1_000_000), OutlineMesh::new(&mesh, 32));
        assert!(thin.triangles.len() * 2 < plain.triangles.len());
        let top = thin.positions.iter().map(|p| p.z).fold(0.0, f64::max);
        assert!((top - 0.2).abs() < 0.006);
    }
}
