//! Connected shells of a visual mesh.
//!
//! A [`TexturedMesh`] splits its vertices at creases and texture seams. Positions that are bit-identical are welded;
//! the components connected by edges are the shells (the body of a mug, its handle). At an edge shared by several
//! components (the two wings of a bow tie), each triangle connects to the one across its own inside, so that
//! components that only touch stay apart. Shells are ordered by their first triangle and vertices by first use, so
//! the same mesh gives the same bytes.

use std::collections::HashMap;
use std::f64::consts::TAU;

use glam::DVec3;

use super::TexturedMesh;

/// One connected, welded surface in the object's frame, meters.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Shell {
    pub points: Vec<DVec3>,
    /// Counter-clockwise seen from outside; none has two equal corners.
    pub triangles: Vec<[u32; 3]>,
}

/// Height above a neighbor's plane up to which two faces count as coplanar, meters; above the rounding of
/// single-precision positions.
pub const CONVEX_M: f64 = 1e-6;

/// Angle below which faces at a shared edge count as coincident, radians: the accuracy of edges of a tenth of a
/// millimeter in single precision.
const SAME_FACE_RAD: f64 = 0.02;

#[derive(PartialEq, Eq, PartialOrd, Ord)]
struct Edge {
    a: u32,
    b: u32,
    forward: bool,
    triangle: u32,
}

impl Shell {
    /// Signed enclosed volume, m^3: negative for the wall of a cavity, whose faces are oriented inward.
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

    /// Whether every edge is used by two triangles, once in each direction: a closed manifold surface.
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
    split(points, triangles)
}

/// Triangles over welded corners as connected shells.
pub(super) fn split(points: Vec<DVec3>, triangles: Vec<[u32; 3]>) -> Vec<Shell> {
    let whole = Shell { points, triangles };
    let mut parent: Vec<u32> = (0..whole.triangles.len() as u32).collect();
    for same in whole.edges().chunk_by(|x, y| (x.a, x.b) == (y.a, y.b)) {
        for (t, mate) in across_the_inside(&whole, same) {
            let (a, b) = (root(&mut parent, t), root(&mut parent, mate));
            parent[b as usize] = a;
        }
    }
    let mut shell_of_root: HashMap<u32, usize> = HashMap::new();
    let mut index_in_shell: HashMap<(usize, u32), u32> = HashMap::with_capacity(whole.points.len());
    let mut shells: Vec<Shell> = Vec::new();
    for (index, t) in whole.triangles.iter().enumerate() {
        let number = *shell_of_root.entry(root(&mut parent, index as u32)).or_insert(shells.len());
        if number == shells.len() {
            shells.push(Shell::default());
        }
        let shell = &mut shells[number];
        let triangle = t.map(|v| {
            *index_in_shell.entry((number, v)).or_insert_with(|| {
                shell.points.push(whole.points[v as usize]);
                shell.points.len() as u32 - 1
            })
        });
        shell.triangles.push(triangle);
    }
    shells
}

/// Pairs of triangles that are connected at an edge that several share: those with only the inside between them.
fn across_the_inside(whole: &Shell, same: &[Edge]) -> Vec<(u32, u32)> {
    if let [x, y] = same {
        return vec![(x.triangle, y.triangle)];
    }
    let Some(first) = same.first() else { return Vec::new() };
    let (a, b) = (whole.points[first.a as usize], whole.points[first.b as usize]);
    let axis = (b - a).normalize_or_zero();
    let (u, v) = if axis == DVec3::ZERO { (DVec3::X, DVec3::Y) } else { axis.any_orthonormal_pair() };
    // The direction in which a triangle leaves the edge, as an angle around it.
    let angle = |edge: &Edge| {
        let away = whole.triangles[edge.triangle as usize]
            .iter()
            .find(|&&corner| corner != edge.a && corner != edge.b)
            .map_or(DVec3::ZERO, |&corner| whole.points[corner as usize] - a);
        away.dot(v).atan2(away.dot(u))
    };
    // The inside is clockwise of a triangle that runs along the axis. Coincident faces have none between them.
    let between = |forward: &Edge, backward: &Edge| {
        let turn = (angle(forward) - angle(backward)).rem_euclid(TAU);
        if turn < SAME_FACE_RAD { TAU } else { turn }
    };
    let mut waiting: Vec<&Edge> = same.iter().filter(|edge| !edge.forward).collect();
    let mut pairs = Vec::with_capacity(waiting.len());
    for forward in same.iter().filter(|edge| edge.forward) {
        let nearest = (0..waiting.len())
            .min_by(|&x, &y| between(forward, waiting[x]).total_cmp(&between(forward, waiting[y])));
        if let Some(nearest) = nearest {
            pairs.push((forward.triangle, waiting.remove(nearest).triangle));
        }
    }
    pairs
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
    use crate::shapes::{block, prism, tube};
    use crate::{Material, Rgb};
    use glam::DVec2;

    #[test]
    fn shells_of_two_separate_solids_are_two_closed_shells() {
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

    #[test]
    fn shells_of_touching_solids_stay_separate() {
        let plain = Material::plain("plain", Rgb::hex(0x80_80_80), 0.5);
        let wing = prism(&[DVec2::ZERO, DVec2::new(0.1, -0.05), DVec2::new(0.1, 0.05)], 0.02);
        let turned = wing.clone().rotated(glam::DQuat::from_xyzw(0.0, 0.0, 1.0, 0.0));
        let cube = block(DVec3::splat(0.1));
        let on_top = block(DVec3::splat(0.1)).translated(DVec3::new(0.0, 0.0, 0.1));
        for pair in [[wing, turned], [cube, on_top]] {
            let mut mesh = TexturedMesh::default();
            pair.into_iter().for_each(|solid| mesh.add(solid, &plain));
            let shells = shells(&mesh);
            assert_eq!(shells.len(), 2);
            assert!(shells.iter().all(|shell| shell.is_closed() && shell.volume_m3() > 0.0));
        }
    }
}
