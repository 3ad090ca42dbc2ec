//! A tree of boxes over triangles, which answers rays.
//!
//! Binary splits by the surface area heuristic over bins of centroids (Wald, "On fast construction of SAH-based
//! bounding volume hierarchies", 2007), collapsed to four children per node, whose boxes are tested at once (Dammertz
//! et al., "Shallow bounding volume hierarchies", 2008). Leaves hold up to four triangles, which are intersected at
//! once (Moeller and Trumbore 1997, both faces). Traversal is iterative. World frame, meters, `f32`. Construction takes
//! one or two microseconds per triangle, and the result does not depend on the number of threads.

use std::array::from_fn;

use glam::Vec3A;
use wide::f32x4;

/// Triangles ordered for rays.
pub struct Bvh {
    nodes: Vec<Node>,
    packets: Vec<Packet>,
    root: Child,
}

/// A triangle that a ray meets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Met {
    /// Distance in lengths of the ray's direction.
    pub t: f32,
    /// Number of the triangle in the list that the tree was made of.
    pub triangle: u32,
    /// Weights of the second and the third corner.
    pub u: f32,
    pub v: f32,
}

/// Four boxes side by side.
struct Node {
    low: [f32x4; 3],
    high: [f32x4; 3],
    children: [Child; 4],
}

/// Four triangles side by side: first corner and two sides.
struct Packet {
    corner: [f32x4; 3],
    sides: [[f32x4; 3]; 2],
    triangles: [u32; 4],
}

/// Number of a node, or that of a packet with the highest bit set.
#[derive(Clone, Copy, PartialEq, Eq)]
struct Child(u32);

impl Child {
    const NONE: Self = Self(u32::MAX);
    const PACKET: u32 = 1 << 31;
}

/// Bins of centroids along the longest axis.
const BINS: usize = 16;
/// Triangles of a leaf.
const LEAF: usize = 4;
/// Depth from which on halves are taken, so that the stack of a traversal is bounded.
const HALVES_FROM_DEPTH: usize = 32;
/// Three siblings wait at each level. Below [`HALVES_FROM_DEPTH`] there are no more than 28 levels for 2^30 triangles.
const STACK: usize = 3 * (HALVES_FROM_DEPTH + 28) + 1;
/// Triangles from which on both parts of a split are built at once.
const PARALLEL_FROM: usize = 4096;
/// Farther than all that a ray meets, and nearer than the boxes of absent children.
pub const FAR: f32 = 1e20;
const ABSENT: f32 = 1e30;
/// Rounding of barycentric weights, so that no ray passes between two triangles that share an edge.
const EDGE: f32 = 1e-6;

#[derive(Clone, Copy)]
struct Bounds {
    low: Vec3A,
    high: Vec3A,
}

impl Bounds {
    const EMPTY: Self = Self { low: Vec3A::INFINITY, high: Vec3A::NEG_INFINITY };

    fn with(self, other: Self) -> Self {
        Self { low: self.low.min(other.low), high: self.high.max(other.high) }
    }

    fn half_area(self) -> f32 {
        let size = (self.high - self.low).max(Vec3A::ZERO);
        size.x * size.y + size.y * size.z + size.z * size.x
    }
}

/// A triangle while the tree is built.
#[derive(Clone, Copy)]
struct Item {
    bounds: Bounds,
    centroid: Vec3A,
    triangle: u32,
}

/// The binary tree.
enum Split {
    Leaf(Bounds, Vec<u32>),
    Inner(Bounds, Box<[Split; 2]>),
}

impl Split {
    fn bounds(&self) -> Bounds {
        match self {
            Self::Leaf(bounds, _) | Self::Inner(bounds, _) => *bounds,
        }
    }
}

impl Bvh {
    /// The tree over triangles given by their corners.
    pub fn new(triangles: &[[Vec3A; 3]]) -> Self {
        let mut items: Vec<Item> = triangles
            .iter()
            .zip(0..)
            .filter(|(corners, _)| corners.iter().all(|corner| corner.is_finite()))
            .map(|([a, b, c], triangle)| {
                let bounds = Bounds { low: a.min(*b).min(*c), high: a.max(*b).max(*c) };
                Item { bounds, centroid: 0.5 * (bounds.low + bounds.high), triangle }
            })
            .collect();
        let mut bvh = Self { nodes: Vec::new(), packets: Vec::new(), root: Child::NONE };
        if !items.is_empty() {
            let split = split(&mut items, 0);
            bvh.root = bvh.collapse(split, triangles);
        }
        bvh
    }

    /// Number of the node or packet that a binary tree becomes.
    fn collapse(&mut self, split: Split, triangles: &[[Vec3A; 3]]) -> Child {
        let children = match split {
            Split::Leaf(_, members) => {
                self.packets.push(Packet::new(&members, triangles));
                return Child(Child::PACKET | (self.packets.len() - 1) as u32);
            }
            Split::Inner(_, halves) => {
                let mut children: Vec<Split> = (*halves).into();
                while children.len() < 4 {
                    let largest = (0..children.len())
                        .filter(|k| matches!(children[*k], Split::Inner(..)))
                        .max_by(|a, b| {
                            let area = |k: &usize| children[*k].bounds().half_area();
                            area(a).total_cmp(&area(b))
                        });
                    let Some(largest) = largest else { break };
                    if let Split::Inner(_, halves) = children.swap_remove(largest) {
                        children.extend(*halves);
                    }
                }
                children
            }
        };
        let number = self.nodes.len();
        let bound = |of: fn(Bounds) -> Vec3A, axis: usize| {
            f32x4::from(from_fn::<f32, 4, _>(|k| {
                children.get(k).map_or(ABSENT, |child| of(child.bounds())[axis])
            }))
        };
        let low = from_fn(|axis| bound(|bounds| bounds.low, axis));
        let high = from_fn(|axis| bound(|bounds| bounds.high, axis));
        self.nodes.push(Node { low, high, children: [Child::NONE; 4] });
        for (k, child) in children.into_iter().enumerate() {
            let child = self.collapse(child, triangles);
            self.nodes[number].children[k] = child;
        }
        Child(number as u32)
    }

    /// The nearest triangle that a ray meets before `t_max`.
    pub fn nearest(&self, origin: Vec3A, direction: Vec3A, t_max: f32) -> Option<Met> {
        let mut nearest = None;
        self.visit(origin, direction, t_max, |met| {
            nearest = Some(met);
            met.t
        });
        nearest
    }

    /// Calls `visit` with triangles that a ray meets, in no order. `visit` returns the distance up to which others
    /// count; a negative one ends the search.
    #[inline]
    pub fn visit(&self, origin: Vec3A, direction: Vec3A, t_max: f32, mut visit: impl FnMut(Met) -> f32) {
        let ray = Ray::new(origin, direction);
        let mut t_max = t_max.min(FAR);
        let mut stack = [(Child::NONE, 0.0_f32); STACK];
        let mut height = 0;
        let mut next = self.root;
        while next != Child::NONE {
            if next.0 & Child::PACKET != 0 {
                let packet = &self.packets[(next.0 & !Child::PACKET) as usize];
                packet.intersect(&ray, t_max, |met| {
                    // A packet is intersected as a whole, so a later one may be farther than an earlier one.
                    if met.t < t_max {
                        t_max = visit(met);
                    }
                });
                if t_max < 0.0 {
                    return;
                }
            } else {
                let node = &self.nodes[next.0 as usize];
                let (near, mut hits) = node.near(&ray, t_max);
                let first = height;
                while hits != 0 {
                    let k = hits.trailing_zeros() as usize;
                    hits &= hits - 1;
                    if node.children[k] == Child::NONE {
                        continue;
                    }
                    // The farthest lies lowest on the stack.
                    let mut place = height;
                    while place > first && stack[place - 1].1 < near[k] {
                        stack[place] = stack[place - 1];
                        place -= 1;
                    }
                    stack[place] = (node.children[k], near[k]);
                    height += 1;
                }
            }
            next = Child::NONE;
            while height > 0 {
                height -= 1;
                if stack[height].1 <= t_max {
                    next = stack[height].0;
                    break;
                }
            }
        }
    }
}

/// A ray in lanes.
struct Ray {
    origin: [f32x4; 3],
    direction: [f32x4; 3],
    inverse: [f32x4; 3],
}

impl Ray {
    fn new(origin: Vec3A, direction: Vec3A) -> Self {
        // A reciprocal of zero times a distance of zero would be no number.
        let inverse = |c: f32| 1.0 / if c.abs() < 1e-12 { 1e-12_f32.copysign(c) } else { c };
        Self {
            origin: from_fn(|axis| f32x4::splat(origin[axis])),
            direction: from_fn(|axis| f32x4::splat(direction[axis])),
            inverse: from_fn(|axis| f32x4::splat(inverse(direction[axis]))),
        }
    }
}

impl Node {
    /// Distances at which a ray enters the boxes, and a mask of those that it meets before `t_max`.
    #[inline]
    fn near(&self, ray: &Ray, t_max: f32) -> ([f32; 4], u32) {
        let (mut enters, mut leaves) = (f32x4::ZERO, f32x4::splat(t_max));
        for axis in 0..3 {
            let a = (self.low[axis] - ray.origin[axis]) * ray.inverse[axis];
            let b = (self.high[axis] - ray.origin[axis]) * ray.inverse[axis];
            enters = enters.fast_max(a.fast_min(b));
            // Wider by the rounding of the products (Ize, "Robust BVH ray traversal", 2013).
            leaves = leaves.fast_min(a.fast_max(b) * f32x4::splat(1.000_000_4));
        }
        (enters.to_array(), enters.simd_le(leaves).to_bitmask())
    }
}

impl Packet {
    fn new(members: &[u32], triangles: &[[Vec3A; 3]]) -> Self {
        let lanes = |of: &dyn Fn(&[Vec3A; 3]) -> f32| {
            let lane = |k: usize| members.get(k).map_or(0.0, |triangle| of(&triangles[*triangle as usize]));
            f32x4::from(from_fn::<f32, 4, _>(lane))
        };
        Self {
            corner: from_fn(|axis| lanes(&|[a, _, _]| a[axis])),
            sides: [
                from_fn(|axis| lanes(&|[a, b, _]| b[axis] - a[axis])),
                from_fn(|axis| lanes(&|[a, _, c]| c[axis] - a[axis])),
            ],
            triangles: from_fn(|k| members.get(k).copied().unwrap_or(u32::MAX)),
        }
    }

    /// Calls `visit` with the triangles that a ray meets before `t_max`. Lanes without a triangle have no determinant,
    /// so their weights are no numbers and no test holds.
    #[inline]
    fn intersect(&self, ray: &Ray, t_max: f32, mut visit: impl FnMut(Met)) {
        let [e1, e2] = &self.sides;
        let across = cross(&ray.direction, e2);
        let inverse = f32x4::ONE / dot(e1, &across);
        let from_corner = from_fn(|axis| ray.origin[axis] - self.corner[axis]);
        let u = dot(&from_corner, &across) * inverse;
        let q = cross(&from_corner, e1);
        let v = dot(&ray.direction, &q) * inverse;
        let t = dot(e2, &q) * inverse;
        let low = f32x4::splat(-EDGE);
        let inside = u.simd_ge(low) & v.simd_ge(low) & (u + v).simd_le(f32x4::splat(1.0 + EDGE));
        let mut hits = (inside & t.simd_gt(f32x4::ZERO) & t.simd_lt(f32x4::splat(t_max))).to_bitmask();
        if hits == 0 {
            return;
        }
        let (t, u, v) = (t.to_array(), u.to_array(), v.to_array());
        while hits != 0 {
            let k = hits.trailing_zeros() as usize;
            hits &= hits - 1;
            visit(Met { t: t[k], triangle: self.triangles[k], u: u[k], v: v[k] });
        }
    }
}

#[inline]
fn dot(a: &[f32x4; 3], b: &[f32x4; 3]) -> f32x4 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline]
fn cross(a: &[f32x4; 3], b: &[f32x4; 3]) -> [f32x4; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn split(items: &mut [Item], depth: usize) -> Split {
    let bounds = items.iter().fold(Bounds::EMPTY, |all, item| all.with(item.bounds));
    if items.len() <= LEAF {
        return Split::Leaf(bounds, items.iter().map(|item| item.triangle).collect());
    }
    let place = if depth < HALVES_FROM_DEPTH { place_of_split(items) } else { None };
    let place = place.unwrap_or_else(|| {
        let half = items.len() / 2;
        let axis = longest_axis(bounds.high - bounds.low);
        items.select_nth_unstable_by(half, |a, b| {
            a.centroid[axis].total_cmp(&b.centroid[axis]).then(a.triangle.cmp(&b.triangle))
        });
        half
    });
    let (before, after) = items.split_at_mut(place);
    let halves = if before.len() + after.len() >= PARALLEL_FROM {
        let (a, b) = rayon::join(|| split(before, depth + 1), || split(after, depth + 1));
        [a, b]
    } else {
        [split(before, depth + 1), split(after, depth + 1)]
    };
    Split::Inner(bounds, Box::new(halves))
}

/// Reorders the items about the cheapest border between bins; the number of items before it. `None` if all centroids
/// are in one bin.
fn place_of_split(items: &mut [Item]) -> Option<usize> {
    let centroids = items
        .iter()
        .fold(Bounds::EMPTY, |all, item| all.with(Bounds { low: item.centroid, high: item.centroid }));
    let size = centroids.high - centroids.low;
    let mut best: Option<(f32, usize, usize)> = None;
    for axis in 0..3 {
        if size[axis] <= 0.0 {
            continue;
        }
        let mut bins = [(Bounds::EMPTY, 0_usize); BINS];
        for item in items.iter() {
            let (bounds, count) = &mut bins[bin(item, axis, &centroids)];
            *bounds = bounds.with(item.bounds);
            *count += 1;
        }
        let mut after = [0.0; BINS];
        let (mut bounds, mut count) = (Bounds::EMPTY, 0);
        for k in (1..BINS).rev() {
            bounds = bounds.with(bins[k].0);
            count += bins[k].1;
            after[k] = if count > 0 { bounds.half_area() * count as f32 } else { f32::INFINITY };
        }
        (bounds, count) = (Bounds::EMPTY, 0);
        for border in 1..BINS {
            bounds = bounds.with(bins[border - 1].0);
            count += bins[border - 1].1;
            let cost = bounds.half_area() * count as f32 + after[border];
            if count > 0 && cost.is_finite() && best.is_none_or(|(lowest, _, _)| cost < lowest) {
                best = Some((cost, axis, border));
            }
        }
    }
    let (_, axis, border) = best?;
    let mut place = 0;
    for k in 0..items.len() {
        if bin(&items[k], axis, &centroids) < border {
            items.swap(place, k);
            place += 1;
        }
    }
    Some(place)
}

fn bin(item: &Item, axis: usize, centroids: &Bounds) -> usize {
    let share = (item.centroid[axis] - centroids.low[axis]) / (centroids.high[axis] - centroids.low[axis]);
    ((share * BINS as f32) as usize).min(BINS - 1)
}

fn longest_axis(size: Vec3A) -> usize {
    match size.cmpeq(Vec3A::splat(size.max_element())).bitmask() {
        mask if mask & 1 != 0 => 0,
        mask if mask & 2 != 0 => 1,
        _ => 2,
    }
}
