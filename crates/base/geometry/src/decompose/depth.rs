//! Signed distance to one shell of the solid, for many queries close to each other.
//!
//! The bounding-volume hierarchy is that of the shell, regrouped to four boxes per node in single precision with
//! outward rounding, so that one step tests four boxes. A query starts from the triangle of an earlier one as a
//! guess: a good guess prunes most boxes, a poor one costs one triangle. The nearest triangle and the depth are
//! computed in double precision, as in [`MeshSolid`]. Of equally near triangles the first is taken, so the guess
//! changes the time and not the result.
//!
//! Object frame, meters. A query takes some tenths of a microsecond.
//!
//! [`MeshSolid`]: crate::solid_query::MeshSolid

use glam::DVec3;
use parry3d_f64::partitioning::TraversalAction;
use parry3d_f64::query::PointQueryWithLocation;
use parry3d_f64::shape::{TriMesh, Triangle, TrianglePointLocation};
use wide::{f32x4, f64x4};

/// Bit set in the reference to a child that is a triangle.
const TRIANGLE: u32 = 1 << 31;
/// A reference to no child.
const NOTHING: u32 = u32::MAX;
/// Slack of a bound, as a share and in meters; far above rounding errors of distances in double precision.
const SLACK: f64 = 1e-9;
const SLACK_M: f64 = 1e-12;
/// Relative rounding error of a squared distance in single precision.
const SLACK_SINGLE: f32 = 1e-5;

pub(super) struct ShellDepth<'a> {
    surface: &'a TriMesh,
    /// The root first.
    nodes: Vec<Node>,
    prisms: Vec<Prism>,
    /// Largest rounding error of a distance in single precision, meters.
    rounding_m: f64,
}

/// Four boxes with their children: a node or, marked by [`TRIANGLE`], a triangle.
#[derive(Clone, Copy)]
struct Node {
    low: [f32x4; 3],
    high: [f32x4; 3],
    child: [u32; 4],
}

/// A box of the shell's hierarchy with its child.
#[derive(Clone, Copy)]
struct Branch {
    low: DVec3,
    high: DVec3,
    child: u32,
}

impl<'a> ShellDepth<'a> {
    /// For points no farther from the origin than `reach_m` along any axis.
    pub(super) fn new(surface: &'a TriMesh, reach_m: f64) -> Self {
        let prisms = surface.triangles().map(|t| Prism::over([t.a, t.b, t.c])).collect();
        let rounding_m = 8.0 * f64::from(f32::EPSILON) * reach_m;
        Self { surface, nodes: gathered(&branches(surface)), prisms, rounding_m }
    }

    /// Distance to the surface: positive behind it, negative in front of it. `triangle` is the guess on entry and the
    /// nearest triangle on return.
    pub(super) fn depth_m(&self, point: DVec3, triangle: &mut u32, open: &mut Vec<(f32, u32)>) -> f64 {
        let mut best = Best { triangle: *triangle, ..Best::default() };
        let mut limit = f32::INFINITY;
        let mut look_at = |triangle: u32, limit: &mut f32| {
            let face = self.surface.triangle(triangle);
            let (at, feature) = nearest_of_triangle([face.a, face.b, face.c], point);
            let distance_m = (at - point).length();
            let nearer = distance_m < best.distance_m;
            // The first of equally near triangles, so that the guess does not change the result.
            if nearer || (distance_m == best.distance_m && triangle < best.triangle) {
                best = Best { distance_m, triangle, at, feature: Some(feature) };
                let reach = (distance_m + self.rounding_m) as f32;
                *limit = reach * reach * (1.0 + SLACK_SINGLE);
            }
            (best.distance_m * (1.0 + SLACK) + SLACK_M).powi(2)
        };
        let mut bound_m2 = look_at(*triangle, &mut limit);
        let single = point.to_array().map(|c| f32x4::splat(c as f32));
        open.clear();
        open.push((0.0, 0));
        while let Some((squared, index)) = open.pop() {
            if squared > limit {
                continue;
            }
            let node = &self.nodes[index as usize];
            let squared = node.squared_m2(single);
            let (mut lowest, mut nearest) = (f32::INFINITY, None);
            let mut close = squared.simd_le(f32x4::splat(limit)).to_bitmask();
            let squared = squared.to_array();
            while close != 0 {
                let k = close.trailing_zeros() as usize;
                close &= close - 1;
                let child = node.child[k];
                if child & TRIANGLE == 0 {
                    if squared[k] < lowest {
                        (lowest, nearest) = (squared[k], Some(open.len()));
                    }
                    open.push((squared[k], child));
                } else if child != NOTHING {
                    let triangle = child & !TRIANGLE;
                    if self.prisms[triangle as usize].squared_m2(point) <= bound_m2 {
                        bound_m2 = look_at(triangle, &mut limit);
                    }
                }
            }
            if let Some(nearest) = nearest {
                let last = open.len() - 1;
                open.swap(nearest, last);
            }
        }
        *triangle = best.triangle;
        if self.is_behind(point, &best) { best.distance_m } else { -best.distance_m }
    }

    /// Whether the point lies behind the surface, by the pseudo-normal at the nearest point.
    fn is_behind(&self, point: DVec3, best: &Best) -> bool {
        let (Some(feature), Some(normals)) = (best.feature, self.surface.pseudo_normals()) else {
            return false;
        };
        let triangle = best.triangle as usize;
        let normal = match feature {
            Feature::Inside => self.surface.triangle(best.triangle).scaled_normal(),
            Feature::Edge(edge) => normals.edges_pseudo_normal[triangle][edge as usize],
            Feature::Corner(corner) => {
                normals.vertices_pseudo_normal[self.surface.indices()[triangle][corner as usize] as usize]
            }
        };
        (point - best.at).dot(normal) <= 0.0
    }
}

/// The place on a triangle of its point nearest to another point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Feature {
    Inside,
    /// From its first corner to the second, from the second to the third, or between the first and the third.
    Edge(u32),
    Corner(u32),
}

/// The point of a triangle nearest to a point: the result of parry's projection, by the same operations without those
/// that serve other results.
fn nearest_of_triangle([a, b, c]: [DVec3; 3], point: DVec3) -> (DVec3, Feature) {
    let (ab, ac, ap) = (b - a, c - a, point - a);
    let (ab_ap, ac_ap) = (ab.dot(ap), ac.dot(ap));
    if ab_ap <= 0.0 && ac_ap <= 0.0 {
        return (a, Feature::Corner(0));
    }
    let bp = point - b;
    let (ab_bp, ac_bp) = (ab.dot(bp), ac.dot(bp));
    if ab_bp >= 0.0 && ac_bp <= ab_bp {
        return (b, Feature::Corner(1));
    }
    let cp = point - c;
    let (ab_cp, ac_cp) = (ab.dot(cp), ac.dot(cp));
    if ac_cp >= 0.0 && ab_cp <= ac_cp {
        return (c, Feature::Corner(2));
    }
    let normal = ab.cross(ac);
    let beside_ab = normal.dot(ab.cross(ap));
    if beside_ab < 0.0 && ab_ap >= 0.0 && ab_bp <= 0.0 {
        return (a + ab * (ab_ap / ab.length_squared()), Feature::Edge(0));
    }
    let beside_ac = -normal.dot(ac.cross(cp));
    if beside_ac < 0.0 && ac_ap >= 0.0 && ac_cp <= 0.0 {
        return (a + ac * (ac_ap / ac.length_squared()), Feature::Edge(2));
    }
    let bc = c - b;
    let beside_bc = normal.dot(bc.cross(bp));
    if beside_bc < 0.0 && ac_bp - ab_bp >= 0.0 && ab_cp - ac_cp >= 0.0 {
        return (b + bc * (bc.dot(bp) / bc.length_squared()), Feature::Edge(1));
    }
    let whole = beside_bc + beside_ac + beside_ab;
    if whole == 0.0 {
        return nearest_of_line([a, b, c], point);
    }
    (a + ab * (beside_ac / whole) + ac * (beside_ab / whole), Feature::Inside)
}

/// As [`nearest_of_triangle`], for a triangle without area.
#[cold]
fn nearest_of_line([a, b, c]: [DVec3; 3], point: DVec3) -> (DVec3, Feature) {
    let (projected, location) = Triangle::new(a, b, c).project_local_point_and_get_location(point, false);
    let feature = match location {
        TrianglePointLocation::OnFace(..) | TrianglePointLocation::OnSolid => Feature::Inside,
        TrianglePointLocation::OnEdge(edge, _) => Feature::Edge(edge),
        TrianglePointLocation::OnVertex(corner) => Feature::Corner(corner),
    };
    (projected.point, feature)
}

/// The planes of a triangle and through its edges, across it; all four as x, y, z of the unit normals that
/// point outward, and offsets. Zeros for a triangle without area.
#[derive(Clone, Copy)]
struct Prism {
    x: f64x4,
    y: f64x4,
    z: f64x4,
    offset_m: f64x4,
}

impl Prism {
    fn over(corners: [DVec3; 3]) -> Self {
        let [a, b, c] = corners;
        let normal = (b - a).cross(c - a).normalize_or_zero();
        let across = |from: DVec3, to: DVec3| ((to - from).cross(normal).normalize_or_zero(), from);
        let planes = [(normal, a), across(a, b), across(b, c), across(c, a)];
        let axis = |k: usize| f64x4::from(planes.map(|(normal, _)| normal[k]));
        let offset_m = f64x4::from(planes.map(|(normal, at)| normal.dot(at)));
        Self { x: axis(0), y: axis(1), z: axis(2), offset_m }
    }

    /// The point is at least this far from the triangle, squared: exact above the triangle and beside an edge.
    fn squared_m2(&self, point: DVec3) -> f64 {
        let heights =
            self.x * f64x4::splat(point.x) + self.y * f64x4::splat(point.y) + self.z * f64x4::splat(point.z)
                - self.offset_m;
        let [above, ab, bc, ca] = heights.to_array();
        let beside = ab.max(bc).max(ca).max(0.0);
        above * above + beside * beside
    }
}

/// The nearest point of the surface found so far.
struct Best {
    distance_m: f64,
    triangle: u32,
    at: DVec3,
    feature: Option<Feature>,
}

impl Default for Best {
    fn default() -> Self {
        Self { distance_m: f64::INFINITY, triangle: 0, at: DVec3::ZERO, feature: None }
    }
}

impl Node {
    const EMPTY: Self = Self { low: [f32x4::ZERO; 3], high: [f32x4::ZERO; 3], child: [NOTHING; 4] };

    /// Squared distance of the point to each box.
    fn squared_m2(&self, point: [f32x4; 3]) -> f32x4 {
        let mut sum = f32x4::ZERO;
        for (axis, &p) in point.iter().enumerate() {
            let off = (self.low[axis] - p).fast_max(p - self.high[axis]).fast_max(f32x4::ZERO);
            sum += off * off;
        }
        sum
    }
}

/// The boxes of the surface's hierarchy, two after each other that have one parent, the root's first.
fn branches(surface: &TriMesh) -> Vec<Branch> {
    let mut branches: Vec<Branch> = Vec::with_capacity(2 * surface.indices().len());
    // Boxes whose two parts are still to come, the next one last: both boxes of a pair are visited, then what
    // is in the first, then what is in the second.
    let mut awaiting: Vec<usize> = Vec::new();
    surface.bvh().traverse(|node| {
        let index = branches.len();
        if index.is_multiple_of(2)
            && let Some(parent) = awaiting.pop()
        {
            branches[parent].child = index as u32;
        }
        let child = node.leaf_data().map_or(NOTHING, |triangle| triangle | TRIANGLE);
        branches.push(Branch { low: node.mins(), high: node.maxs(), child });
        if index % 2 == 1 {
            awaiting.extend([index, index - 1].into_iter().filter(|&k| branches[k].child == NOTHING));
        }
        TraversalAction::Continue
    });
    branches
}

/// Pairs of boxes gathered into nodes of up to four: in place of a box come its two parts.
fn gathered(branches: &[Branch]) -> Vec<Node> {
    let pair = |first: u32| branches[first as usize..].iter().take(2).copied();
    let mut nodes = vec![Node::EMPTY];
    let mut open = vec![(0, 0)];
    while let Some((index, first)) = open.pop() {
        let (mut low, mut high) = ([[f32::INFINITY; 4]; 3], [[f32::NEG_INFINITY; 4]; 3]);
        let parts = pair(first).flat_map(|branch| {
            let split = branch.child & TRIANGLE == 0;
            let parts = split.then(|| pair(branch.child)).into_iter().flatten();
            parts.chain((!split).then_some(branch))
        });
        for (k, part) in parts.enumerate() {
            for axis in 0..3 {
                low[axis][k] = (part.low[axis] as f32).next_down();
                high[axis][k] = (part.high[axis] as f32).next_up();
            }
            nodes[index].child[k] = part.child;
            if part.child & TRIANGLE == 0 {
                nodes[index].child[k] = nodes.len() as u32;
                open.push((nodes.len(), part.child));
                nodes.push(Node::EMPTY);
            }
        }
        nodes[index].low = low.map(f32x4::from);
        nodes[index].high = high.map(f32x4::from);
    }
    nodes
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn nearest_of_triangle_is_the_projection_of_parry(
            corners in prop::array::uniform3(prop::array::uniform3(-1.0..1.0_f64)),
            point in prop::array::uniform3(-2.0..2.0_f64), step in prop::sample::select(vec![0.0, 1e-6, 0.25]),
        ) {
            // On a coarse grid, many triangles have no area and many points lie on an edge.
            let snapped = |p: [f64; 3]| {
                let p = DVec3::from(p);
                if step > 0.0 { (p / step).round() * step } else { p }
            };
            let (corners, point) = (corners.map(snapped), snapped(point));
            prop_assert_eq!(nearest_of_triangle(corners, point), nearest_of_line(corners, point));
        }
    }
}
