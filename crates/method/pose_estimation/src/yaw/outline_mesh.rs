//! Mesh topology of a silhouette: welded positions, triangles, and the edges between them.

use std::collections::BTreeMap;

use glam::{DQuat, DVec3};

use geometry::TexturedMesh;

/// Positions (object frame, meters) and triangles without attributes.
#[derive(Clone, Debug)]
pub struct OutlineMesh {
    pub positions: Vec<DVec3>,
    /// Wound as in the mesh.
    pub triangles: Vec<[u32; 3]>,
    /// Of each, its number among all triangles of the mesh.
    pub faces: Vec<u32>,
    /// The edges of a closed surface, else `None`. The outline of a closed surface lies on its contour edges, a few
    /// hundred lines instead of thousands of triangles.
    pub edges: Option<Vec<Edge>>,
    /// Lowest and highest corner of its box.
    pub bounds: (DVec3, DVec3),
}

/// An edge between two triangles that run along it in opposite directions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Edge {
    pub ends: [u32; 2],
    /// The triangle that runs from the first end to the second.
    pub along: u32,
    /// The one that runs back.
    pub against: u32,
}

/// Meshes up to this size are only welded.
const PLAIN_TRIANGLES: usize = 20_000;

impl OutlineMesh {
    /// Welds equal positions; a mesh of more than 20,000 triangles is merged on a grid of `cells` along
    /// its largest extent. Merging keeps a closed surface closed.
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
        let (faces, triangles): (Vec<u32>, Vec<[u32; 3]>) = (0..)
            .zip(mesh.triangles().map(|t| t.map(|v| merged[v as usize])))
            .filter(|(_, [a, b, c])| a != b && b != c && c != a)
            .unzip();
        let positions = sums.iter().zip(&counts).map(|(sum, count)| *sum / *count).collect();
        Self { positions, edges: closed_edges(&triangles), triangles, faces, bounds }
    }

    /// The same mesh turned, scaled evenly, and moved so that the center of the bottom of its box is the
    /// origin.
    pub fn stood_up(&self, rotation: DQuat, scale: f64) -> Self {
        let mut positions: Vec<DVec3> = self.positions.iter().map(|p| scale * (rotation * *p)).collect();
        let (low, high) = positions
            .iter()
            .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), p| (low.min(*p), high.max(*p)));
        let seat = DVec3::new(0.5 * (low.x + high.x), 0.5 * (low.y + high.y), low.z);
        positions.iter_mut().for_each(|p| *p -= seat);
        Self {
            positions,
            triangles: self.triangles.clone(),
            faces: self.faces.clone(),
            edges: self.edges.clone(),
            bounds: (low - seat, high - seat),
        }
    }
}

/// The edges, each with a triangle on either side; `None` if somewhere more triangles run one way than the
/// other: the surface has a border there. Where several shells share an edge it is listed for each pair;
/// which are paired does not matter to the outline.
fn closed_edges(triangles: &[[u32; 3]]) -> Option<Vec<Edge>> {
    // Ends with the smaller first, whether the triangle runs the other way, the triangle.
    let mut sides: Vec<(u32, u32, bool, u32)> = Vec::with_capacity(3 * triangles.len());
    for (index, t) in triangles.iter().enumerate() {
        for k in 0..3 {
            let (a, b) = (t[k], t[(k + 1) % 3]);
            sides.push((a.min(b), a.max(b), a > b, index as u32));
        }
    }
    sides.sort_unstable();
    let mut edges = Vec::with_capacity(sides.len() / 2);
    for sides in sides.chunk_by(|s, t| (s.0, s.1) == (t.0, t.1)) {
        let (along, against) = sides.split_at(sides.iter().position(|s| s.2).unwrap_or(sides.len()));
        if along.len() != against.len() {
            return None;
        }
        let ends = [sides[0].0, sides[0].1];
        edges.extend(along.iter().zip(against).map(|(s, t)| Edge { ends, along: s.3, against: t.3 }));
    }
    Some(edges)
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::{Material, Rgb, shapes};

    fn sphere() -> TexturedMesh {
        let mut mesh = TexturedMesh::default();
        mesh.add(shapes::sphere(0.1, 200), &Material::plain("gray", Rgb::hex(0x808080), 0.5));
        mesh
    }

    #[test]
    fn outline_mesh_simplifies_fine_mesh_and_keeps_bounds() {
        let (plain, thin) = (OutlineMesh::new(&sphere(), 1_000_000), OutlineMesh::new(&sphere(), 32));
        assert!(thin.triangles.len() * 2 < plain.triangles.len());
        let top = thin.positions.iter().map(|p| p.z).fold(0.0, f64::max);
        assert!((top - 0.2).abs() < 0.006);
    }

    #[test]
    fn outline_mesh_detects_closed_and_open_surfaces() {
        for cells in [1_000_000, 32] {
            let mesh = OutlineMesh::new(&sphere(), cells);
            let edges = mesh.edges.expect("a sphere is closed");
            assert_eq!(2 * edges.len(), 3 * mesh.triangles.len());
        }
        let mut open = sphere();
        open.groups[0].triangles.pop();
        assert_eq!(OutlineMesh::new(&open, 1_000_000).edges, None);
    }
}
