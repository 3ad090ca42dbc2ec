//! Mesh topology of a soft silhouette: triangles, and the triangles that meet at each edge.

use super::MovingPoint;

/// Triangles and edges; positions come with each image.
#[derive(Clone, Debug)]
pub struct Surface {
    pub triangles: Vec<[u32; 3]>,
    /// Whether at every edge as many triangles run one way as the other: a ray that meets some of one
    /// orientation meets as many of the other.
    pub closed: bool,
    pub(super) edges: Vec<Edge>,
    /// Of all edges, one after another.
    pub(super) sides: Vec<Side>,
    /// For each edge the two triangles that run along it in opposite directions, if there are exactly these; else
    /// [`OTHERWISE`]. Nearly all edges are of this kind, and most poses need no more of them.
    pub(super) pairs: Vec<[u32; 2]>,
}

/// Not two triangles that run along an edge in opposite directions.
pub(super) const OTHERWISE: [u32; 2] = [u32::MAX; 2];

/// An edge of at least one triangle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Edge {
    pub ends: [u32; 2],
    /// Range of the triangles at the edge: `sides[first..end]`.
    pub first: u32,
    pub end: u32,
}

/// A triangle at an edge.
#[derive(Clone, Copy, Debug)]
pub(super) struct Side {
    pub triangle: u32,
    /// Whether it runs from the edge's second end to its first.
    pub back: bool,
}

impl Surface {
    /// Requires welded positions: edges whose triangles do not share vertices cost time and carry no information.
    /// Closed or open, in any number of shells; triangles that repeat a vertex are left out.
    pub fn new(triangles: &[[u32; 3]]) -> Self {
        let triangles: Vec<[u32; 3]> =
            triangles.iter().copied().filter(|[a, b, c]| a != b && b != c && c != a).collect();
        let mut all: Vec<(u32, u32, u32, bool)> = Vec::with_capacity(3 * triangles.len());
        for (index, t) in triangles.iter().enumerate() {
            for k in 0..3 {
                let (a, b) = (t[k], t[(k + 1) % 3]);
                all.push((a.min(b), a.max(b), index as u32, a > b));
            }
        }
        all.sort_unstable();
        let mut edges = Vec::with_capacity(all.len() / 2);
        let mut pairs = Vec::with_capacity(all.len() / 2);
        let (mut first, mut closed) = (0, true);
        for group in all.chunk_by(|s, t| (s.0, s.1) == (t.0, t.1)) {
            let end = first + group.len() as u32;
            edges.push(Edge { ends: [group[0].0, group[0].1], first, end });
            closed &= 2 * group.iter().filter(|s| s.3).count() == group.len();
            pairs.push(match group {
                [s, t] if s.3 != t.3 => [s.2, t.2],
                _ => OTHERWISE,
            });
            first = end;
        }
        let sides = all.iter().map(|s| Side { triangle: s.2, back: s.3 }).collect();
        Self { triangles, closed, edges, sides, pairs }
    }

    /// Of each triangle: whether it runs clockwise on the screen (y down). One without area does not, for
    /// all of its edges alike, so contours stay closed.
    pub(super) fn find_clockwise<const N: usize>(
        &self,
        points: &[MovingPoint<N>],
        clockwise: &mut Vec<bool>,
    ) {
        clockwise.clear();
        clockwise.extend(self.triangles.iter().map(|t| {
            let [a, b, c] = t.map(|v| points[v as usize].at_px.map(f64::from));
            (b[0] - a[0]) * (c[1] - a[1]) > (b[1] - a[1]) * (c[0] - a[0])
        }));
    }

    /// Whether both triangles of an ordinary edge run the same way on the screen.
    #[inline]
    pub(super) fn passes_smoothly(pair: [u32; 2], clockwise: &[bool]) -> bool {
        pair != OTHERWISE && clockwise[pair[0] as usize] == clockwise[pair[1] as usize]
    }

    pub(super) fn sides(&self, edge: &Edge) -> &[Side] {
        &self.sides[edge.first as usize..edge.end as usize]
    }
}
