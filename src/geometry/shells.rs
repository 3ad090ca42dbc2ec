//! The closed shells of a visual mesh.
//!
//! A [`TexturedMesh`] splits its vertices at creases and texture seams. Welding positions that are
//! equal to the bit joins them again; the connected parts of the welded surface are its shells (the
//! body of a mug, its handle). Shells come in the order of their first triangle, vertices in the order
//! of first use, so the same mesh gives the same bytes.

use std::collections::HashMap;

use glam::DVec3;

use super::TexturedMesh;

/// One connected, welded surface in the object's frame, meters.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Shell {
    pub points: Vec<DVec3>,
    /// Counter-clockwise seen from outside; none has two equal corners.
    pub triangles: Vec<[u32; 3]>,
}

/// Height above a neighbor's plane up to which two faces count as flat, meters: above the rounding of
/// single-precision positions.
pub const CONVEX_M: f64 = 1e-6;

#[derive(PartialEq, Eq, PartialOrd, Ord)]
struct Edge {
    a: u32,
    b: u32,
    forward: bool,
    triangle: u32,
}

impl Shell {
    /// Signed enclosed volume, m^3: negative for the wall of a cavity, whose faces look inward.
    pub fn volume_m3(&self) -> f64 {
        let origin = self.points.first().copied().unwrap_or(DVec3::ZERO);
        self.corners().map(|[a, b, c]| (a - origin).dot((b - origin).cross(c - origin)) / 6.0).sum()
    }

    /// Corners of each triangle.
    pub fn corners(&self) -> impl Iterator<Item = [DVec3; 3]> + '_ {
        self.triangles.iter().map(|t| t.map(|v| self.points[v as usize]))
    }

    /// Lowest and highest corner of the axis-aligned box.
    pub fn bounds(&self) -> (DVec3, DVec3) {
        let first = self.points.first().copied().unwrap_or(DVec3::ZERO);
        self.points.iter().fold((first, first), |(low, high), &p| (low.min(p), high.max(p)))
    }

    /// Whether every edge is used by two triangles, once in each direction: a closed surface in which no
    /// parts share an edge.
    pub fn is_closed(&self) -> bool {
        let edges = self.edges();
        !edges.is_empty()
            && edges
                .chunk_by(|x, y| (x.a, x.b) == (y.a, y.b))
                .all(|same| matches!(same, [x, y] if x.forward != y.forward))
    }

    /// Whether a closed shell bounds a convex solid: at every edge the neighbor bends away, or toward
    /// by less than [`CONVEX_M`].
    pub fn is_convex(&self) -> bool {
        let normal = |t: u32| {
            let [a, b, c] = self.triangles[t as usize].map(|v| self.points[v as usize]);
            ((b - a).cross(c - a).normalize_or_zero(), a)
        };
        self.edges().chunk_by(|x, y| (x.a, x.b) == (y.a, y.b)).all(|same| match same {
            [x, y] => [(x, y), (y, x)].into_iter().all(|(x, y)| {
                let (n, at) = normal(x.triangle);
                let [a, b, c] = self.triangles[y.triangle as usize].map(|v| self.points[v as usize]);
                [a, b, c].into_iter().all(|p| n.dot(p - at) <= CONVEX_M)
            }),
            _ => false,
        })
    }

    /// Every triangle's edges, those of one pair of corners together.
    fn edges(&self) -> Vec<Edge> {
        let mut edges: Vec<Edge> = self
            .triangles
            .iter()
            .enumerate()
            .flat_map(|(index, t)| (0..3).map(move |k| (index as u32, t[k], t[(k + 1) % 3])))
            .map(|(triangle, a, b)| Edge { a: a.min(b), b: a.max(b), forward: a < b, triangle })
            .collect();
        edges.sort_unstable();
        edges
    }
}

/// Welds equal positions of the mesh and splits it into connected shells.
pub fn shells(mesh: &TexturedMesh) -> Vec<Shell> {
    let mut known: HashMap<[u64; 3], u32> = HashMap::with_capacity(mesh.positions.len());
    let mut points: Vec<DVec3> = Vec::new();
    let welded: Vec<u32> = mesh
        .positions
        .iter()
        .map(|&p| {
            // Adding zero turns -0.0 into 0.0, which compare equal but differ in bits.
            *known.entry((p + DVec3::ZERO).to_array().map(f64::to_bits)).or_insert_with(|| {
                points.push(p);
                points.len() as u32 - 1
            })
        })
        .collect();
    let triangles: Vec<[u32; 3]> = mesh
        .triangles()
        .map(|t| t.map(|v| welded[v as usize]))
        .filter(|t| t[0] != t[1] && t[1] != t[2] && t[2] != t[0])
        .collect();

    let mut parent: Vec<u32> = (0..points.len() as u32).collect();
    for t in &triangles {
        let a = root(&mut parent, t[0]);
        for &v in &t[1..] {
            let b = root(&mut parent, v);
            parent[b as usize] = a;
        }
    }
    const NONE: u32 = u32::MAX;
    let mut shell_of_root = vec![NONE; points.len()];
    let mut index_in_shell = vec![NONE; points.len()];
    let mut shells: Vec<Shell> = Vec::new();
    for t in &triangles {
        let r = root(&mut parent, t[0]) as usize;
        if shell_of_root[r] == NONE {
            shell_of_root[r] = shells.len() as u32;
            shells.push(Shell::default());
        }
        let shell = &mut shells[shell_of_root[r] as usize];
        let triangle = t.map(|v| {
            let index = &mut index_in_shell[v as usize];
            if *index == NONE {
                *index = shell.points.len() as u32;
                shell.points.push(points[v as usize]);
            }
            *index
        });
        shell.triangles.push(triangle);
    }
    shells
}

fn root(parent: &mut [u32], mut v: u32) -> u32 {
    while parent[v as usize] != v {
        parent[v as usize] = parent[parent[v as usize] as usize];
        v = parent[v as usize];
    }
    v
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::shapes::{block, tube};
    use crate::geometry::{Material, Rgb};

    #[test]
    fn a_block_and_a_bar_are_two_closed_shells() {
        let plain = Material::plain("plain", Rgb::hex(0x80_80_80), 0.5);
        let mut mesh = TexturedMesh::default();
        mesh.add(block(DVec3::new(0.1, 0.2, 0.3)), &plain);
        mesh.add(
            tube(&[DVec3::X, DVec3::X + DVec3::Z], 0.1, 12),
            &Material::metal("m", plain.base_color, 0.2),
        );
        let shells = shells(&mesh);
        assert_eq!(shells.len(), 2);
        assert_eq!((shells[0].points.len(), shells[0].triangles.len()), (8, 12));
        assert!(shells.iter().all(Shell::is_closed));
        assert!((shells[0].volume_m3() - 0.006).abs() < 1e-12);
        let mut open = shells[0].clone();
        open.triangles.pop();
        assert!(!open.is_closed());
    }
}
