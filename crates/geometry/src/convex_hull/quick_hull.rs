//! Quickhull of a cloud with volume (Barber, Dobkin and Huhdanpaa, "The quickhull algorithm for convex hulls",
//! 1996).
//!
//! The steps and their arithmetic are those of parry's `try_convex_hull` (Apache-2.0), so corners and faces are the
//! same and in the same order. Here all facets lie in one list, and the points above a facet form a linked list in
//! another, so that adding a point allocates nothing. Degenerate clouds, and those whose rounding errors give a
//! silhouette that is not a simple loop, return `None`; the caller then uses parry.
//!
//! Any frame and unit. For a hundred points it takes about a third of parry's time.

use glam::DVec3;
use parry3d_f64::math::MatExt;
use parry3d_f64::utils::{center_cov, remove_unused_points};
use wide::f64x4;

/// Rounding of coordinates scaled to about one.
const ROUNDING: f64 = 100.0 * f64::EPSILON;
/// Smallest spread of a cloud with volume along its thinnest axis, share of its squared size.
const FLAT: f64 = 1e-7;
/// The end of a linked list of points.
const NONE: u32 = u32::MAX;

/// Corners and outward faces, or `None` if parry must compute the hull.
pub(super) fn quick_hull(points: &[DVec3]) -> Option<(Vec<DVec3>, Vec<[u32; 3]>)> {
    if points.len() < 4 {
        return None;
    }
    let scaled = Scaled::of(points)?;
    let mut hull = Hull::start(&scaled)?;
    let mut index = 0;
    while index < hull.facets.len() {
        if hull.facets[index].is_open()
            && let Some(point) = hull.farthest(index)
        {
            hull.add(point, index)?;
        }
        index += 1;
    }
    let mut triangles: Vec<[u32; 3]> = hull.facets.iter().filter(|f| f.valid).map(|f| f.corners).collect();
    let mut corners = points.to_vec();
    remove_unused_points(&mut corners, &mut triangles);
    Some((corners, triangles))
}

/// The cloud moved to its mean and scaled by its spread.
struct Scaled {
    points: Vec<DVec3>,
    /// Principal axis of the largest spread.
    longest: DVec3,
}

impl Scaled {
    fn of(points: &[DVec3]) -> Option<Self> {
        let first = points[0];
        let (low, high) = points.iter().fold((first, first), |(low, high), &p| (low.min(p), high.max(p)));
        let (center, size) = (low.midpoint(high), low.distance(high));
        let mut points: Vec<DVec3> = points.iter().map(|&p| (p - center) / size).collect();
        let (mean, covariance) = center_cov(&points);
        let spread = covariance.symmetric_eigen();
        let (axes, values) = (spread.eigenvectors, spread.eigenvalues);
        // Written so that no number counts as flat.
        let has_volume = values.to_array().into_iter().all(|value| value.abs() > FLAT);
        if !has_volume {
            return None;
        }
        let mut longest = (axes.x_axis, values.x);
        for (axis, value) in [(axes.y_axis, values.y), (axes.z_axis, values.z)] {
            if value > longest.1 {
                longest = (axis, value);
            }
        }
        let scale = values.x.abs().max(values.y.abs()).max(values.z.abs());
        points.iter_mut().for_each(|p| *p = (*p - mean) / scale);
        Some(Self { points, longest: longest.0 })
    }

    fn farthest_along(&self, direction: DVec3, among: impl Iterator<Item = u32>) -> Option<u32> {
        let mut farthest = None;
        let mut highest = -f64::MAX;
        for point in among {
            let reach = direction.dot(self.points[point as usize]);
            if reach > highest {
                farthest = Some(point);
                highest = reach;
            }
        }
        farthest
    }
}

/// One triangle of the growing hull.
struct Facet {
    normal: DVec3,
    corners: [u32; 3],
    /// The facet across each edge, and which of its edges that is.
    across: [(u32, u8); 3],
    valid: bool,
    /// Its corners lie on a line.
    flat: bool,
    /// First and last of the points above it.
    first: u32,
    last: u32,
}

impl Facet {
    fn new(corners: [u32; 3], across: [(u32, u8); 3], points: &[DVec3]) -> Self {
        let [a, b, c] = corners.map(|v| points[v as usize]);
        let cross = (b - a).cross(c - a);
        let flat = cross.length_squared() <= ROUNDING * ROUNDING;
        let normal = if flat { DVec3::ZERO } else { cross.normalize() };
        Self { normal, corners, across, valid: true, flat, first: NONE, last: NONE }
    }

    /// Whether points may lie above it.
    fn is_open(&self) -> bool {
        self.valid && !self.flat
    }

    /// Whether an added point removes it.
    fn is_seen_from(&self, point: DVec3, points: &[DVec3]) -> bool {
        self.flat || self.corners.iter().any(|&v| (point - points[v as usize]).dot(self.normal) >= 0.0)
    }
}

struct Hull<'a> {
    scaled: &'a Scaled,
    facets: Vec<Facet>,
    /// The next of the points that see the same facet.
    next: Vec<u32>,
    /// Points near the planes of the facets they were held against.
    undecided: Vec<u32>,
    /// Facets the point being added removes.
    removed: Vec<u32>,
    /// Edges of the facets around them, as (facet, edge), in counter-clockwise order.
    silhouette: Vec<(u32, u8)>,
    /// The facet whose removal met a point in the silhouette last.
    met_by: Vec<u32>,
    /// The facets made last.
    fan: Fan,
}

impl<'a> Hull<'a> {
    /// The first triangle from both sides, with the points assigned to them.
    fn start(scaled: &'a Scaled) -> Option<Self> {
        let points = &scaled.points;
        let all = || 0..points.len() as u32;
        let a = scaled.farthest_along(scaled.longest, all())?;
        let b = scaled.farthest_along(-scaled.longest, all())?;
        let (mut highest, mut c) = (0.0, None);
        for (point, p) in all().zip(points) {
            let at = points[a as usize];
            let area = (points[b as usize] - at).cross(*p - at).length() * 0.5;
            if area > highest {
                (highest, c) = (area, Some(point));
            }
        }
        let c = c?;
        let mut hull = Self {
            scaled,
            facets: Vec::with_capacity(4 * points.len()),
            next: vec![NONE; points.len()],
            undecided: Vec::new(),
            removed: Vec::new(),
            silhouette: Vec::new(),
            met_by: vec![NONE; points.len()],
            fan: Fan::default(),
        };
        hull.facets.push(Facet::new([a, b, c], [(1, 0), (1, 2), (1, 1)], points));
        hull.facets.push(Facet::new([b, a, c], [(0, 0), (0, 2), (0, 1)], points));
        let corners = [a, b, c].map(|v| points[v as usize]);
        for (point, p) in all().zip(points) {
            if corners.contains(p) {
                continue;
            }
            match hull.seen_first(*p) {
                Some(facet) => hull.append(facet, point),
                None => hull.undecided.push(point),
            }
        }
        Some(hull)
    }

    /// The point that sees the facet from the farthest.
    fn farthest(&self, facet: usize) -> Option<u32> {
        let facet = &self.facets[facet];
        let chain = std::iter::successors(Some(facet.first).filter(|&p| p != NONE), |&point| {
            Some(self.next[point as usize]).filter(|&p| p != NONE)
        });
        self.scaled.farthest_along(facet.normal, chain)
    }

    /// Of the first two facets the one that the point sees.
    fn seen_first(&self, point: DVec3) -> Option<usize> {
        self.facets[..2].iter().position(|facet| {
            (point - self.scaled.points[facet.corners[0] as usize]).dot(facet.normal) >= ROUNDING
        })
    }

    fn append(&mut self, facet: usize, point: u32) {
        let facet = &mut self.facets[facet];
        self.next[point as usize] = NONE;
        if facet.first == NONE {
            facet.first = point;
        } else {
            self.next[facet.last as usize] = point;
        }
        facet.last = point;
    }

    /// Replaces what the point sees, starting with a facet it lies above, by facets from the silhouette to the
    /// point. `None` where the silhouette is no simple loop.
    fn add(&mut self, point: u32, facet: usize) -> Option<()> {
        self.removed.clear();
        self.silhouette.clear();
        self.remove(facet);
        for (other, edge) in self.facets[facet].across {
            self.walk(other, edge, point);
        }
        for k in 0..self.silhouette.len() {
            let (other, edge) = self.silhouette[k];
            let corner = self.facets[other as usize].corners[(edge as usize + 1) % 3] as usize;
            if std::mem::replace(&mut self.met_by[corner], facet as u32) == facet as u32 {
                return None;
            }
        }
        if self.silhouette.is_empty() {
            return None;
        }
        let first_new = self.facets.len();
        self.close(point)?;
        self.hand_over(point, first_new);
        Some(())
    }

    fn remove(&mut self, facet: usize) {
        self.facets[facet].valid = false;
        self.removed.push(facet as u32);
    }

    /// Finds what the point sees beyond an edge of a facet.
    fn walk(&mut self, facet: u32, edge: u8, point: u32) {
        let here = &self.facets[facet as usize];
        if !here.valid {
            return;
        }
        let points = &self.scaled.points;
        if !here.is_seen_from(points[point as usize], points) {
            self.silhouette.push((facet, edge));
            return;
        }
        let across = here.across;
        self.remove(facet as usize);
        for turn in 1..3 {
            let (other, other_edge) = across[(edge as usize + turn) % 3];
            self.walk(other, other_edge, point);
        }
    }

    /// Adds the facets between the silhouette and the point.
    fn close(&mut self, point: u32) -> Option<()> {
        let first_new = self.facets.len() as u32;
        let count = self.silhouette.len() as u32;
        for k in 0..count {
            let (other, edge) = self.silhouette[k as usize];
            let corners = self.facets[other as usize].corners;
            let (from, to) = (corners[(edge as usize + 1) % 3], corners[edge as usize]);
            let (before, after) = (first_new + (k + count - 1) % count, first_new + (k + 1) % count);
            let across = [(before, 2), (other, edge), (after, 0)];
            self.facets.push(Facet::new([point, from, to], across, &self.scaled.points));
            let link = &mut self.facets[other as usize].across[edge as usize];
            let replaced = std::mem::replace(link, (first_new + k, 1)).0;
            if self.facets[replaced as usize].valid {
                return None;
            }
        }
        Some(())
    }

    /// Reassigns the points above the removed facets to the new ones.
    fn hand_over(&mut self, added: u32, first_new: usize) {
        let apex = self.scaled.points[added as usize];
        self.fan.spread(apex, &self.facets[first_new..]);
        for k in 0..self.removed.len() {
            let mut waiting = self.facets[self.removed[k] as usize].first;
            while waiting != NONE {
                let point = waiting;
                waiting = self.next[point as usize];
                let p = self.scaled.points[point as usize];
                if p == apex {
                    continue;
                }
                if let Some(best) = self.fan.seen_best(p) {
                    self.append(first_new + best, point);
                }
            }
        }
        let mut k = 0;
        while k < self.undecided.len() {
            let point = self.undecided[k];
            match self.fan.seen_best(self.scaled.points[point as usize]) {
                Some(best) => {
                    self.append(first_new + best, point);
                    self.undecided.swap_remove(k);
                }
                None => k += 1,
            }
        }
    }
}

/// The planes of facets around an apex, four at a time.
#[derive(Default)]
struct Fan {
    apex: DVec3,
    /// x, y and z of the normals; zero for facets that no point sees.
    normals: Vec<[f64x4; 3]>,
}

impl Fan {
    fn spread(&mut self, apex: DVec3, facets: &[Facet]) {
        self.apex = apex;
        self.normals.clear();
        let normal = |facet: Option<&Facet>| facet.map_or(DVec3::ZERO, |facet| facet.normal);
        self.normals.extend(facets.chunks(4).map(|chunk| {
            let four: [DVec3; 4] = std::array::from_fn(|k| normal(chunk.get(k)));
            [0, 1, 2].map(|axis| f64x4::from(four.map(|normal| normal[axis])))
        }));
    }

    /// The first of the facets that the point sees from the farthest.
    fn seen_best(&self, point: DVec3) -> Option<usize> {
        let [px, py, pz] = (point - self.apex).to_array().map(f64x4::splat);
        let (mut highest, mut best) = (f64x4::ZERO, f64x4::ZERO);
        for (chunk, [x, y, z]) in self.normals.iter().enumerate() {
            let height = px * *x + py * *y + pz * *z;
            let higher = height.simd_gt(highest);
            highest = higher.select(height, highest);
            best = higher.select(f64x4::splat(chunk as f64), best);
        }
        let (highest, best) = (highest.to_array(), best.to_array());
        let mut found: Option<(f64, usize)> = None;
        for lane in 0..4 {
            let index = 4 * best[lane] as usize + lane;
            let is_better = found.is_none_or(|(height, first)| {
                highest[lane] > height || (highest[lane] == height && index < first)
            });
            if highest[lane] >= ROUNDING && is_better {
                found = Some((highest[lane], index));
            }
        }
        found.map(|(_, index)| index)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shapes::{block, cylinder, shell_of_revolution, sphere};
    use glam::DVec2;
    use parry3d_f64::transformation::try_convex_hull;
    use proptest::prelude::*;

    fn compare(points: &[DVec3]) -> bool {
        let ours = quick_hull(points);
        if let Some(ours) = &ours {
            assert_eq!(Some(ours), try_convex_hull(points).ok().as_ref());
        }
        ours.is_some()
    }

    #[test]
    fn quick_hull_equals_parry_on_known_shapes() {
        let profile = [DVec2::new(0.04, 0.0), DVec2::new(0.04, 0.1)];
        let shapes = [
            block(DVec3::new(0.1, 0.2, 0.3)),
            cylinder(0.03, 0.1, 0.002, 64),
            sphere(0.04, 48),
            shell_of_revolution(&profile, 0.004, 0.006, 64),
        ];
        let done = shapes.iter().filter(|shape| compare(&shape.positions)).count();
        assert!(done > 1, "{done}");
        assert!(quick_hull(&block(DVec3::new(0.1, 0.2, 0.0)).positions).is_none());
    }

    proptest! {
        #[test]
        fn quick_hull_equals_parry_on_any_cloud(
            cloud in prop::collection::vec(prop::array::uniform3(-1.0..1.0_f64), 4..80), grid in 1..9_i32,
        ) {
            // A coarse grid puts many points on common planes and lines.
            let grid = f64::from(grid);
            let snap = |c: f64| if grid < 8.0 { (c * grid).round() / grid } else { c };
            let points: Vec<DVec3> = cloud.iter().map(|c| DVec3::from_array(c.map(snap))).collect();
            compare(&points);
        }
    }
}
