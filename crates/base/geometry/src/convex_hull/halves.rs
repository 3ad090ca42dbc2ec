//! Hulls of what is too round for one hull of few corners.
//!
//! A ball of 8 cm with 64 corners is missed by 1 to 2 mm between them, as much as two objects may overlap at all. Cut
//! in two through the center it has twice the corners, and each half grows until three quarters of what it misses lie
//! inside: two balls whose hulls touch then overlap by less than a millimeter. Meters. Milliseconds.

use glam::DVec3;

use super::{convex_hull, evenly_missed, farthest_outside, simplified};
use crate::ConvexHull;

/// Distance by which the corners of a hull may lie outside its simplified form before it is cut, meters.
const MAX_MISSED_BY_ONE_M: f64 = 0.0008;
/// Hulls with longer sides stay one, meters: what is large is not heaped, and its neighbors keep a distance.
const MAX_SIDE_M: f64 = 0.2;
/// Hulls with longer sides than so many times their shortest stay one: cans and bottles touch others along lines, and
/// one hull stands on a plane without a seam.
const MAX_ELONGATION: f64 = 1.5;
/// Share of what a half misses by which it grows.
const HALF_GROWTH: f64 = 0.75;

/// As [`convex_hull`], but two hulls where one of `max_vertices` corners would miss round points by too much; none
/// where there is no hull.
pub fn convex_hulls(points: &[DVec3], max_vertices: usize, min_thickness_m: f64) -> Vec<ConvexHull> {
    let Some(full) = convex_hull(points, usize::MAX, min_thickness_m) else { return Vec::new() };
    if full.points.len() <= max_vertices {
        return vec![full];
    }
    let Some(one) = simplified(&full, max_vertices) else { return Vec::new() };
    let missed_m = farthest_outside(&one, &full.points).map_or(0.0, |(_, outside_m)| outside_m);
    if missed_m <= MAX_MISSED_BY_ONE_M {
        return vec![one];
    }
    halves(&full, max_vertices).unwrap_or_else(|| vec![one])
}

/// The two halves of a hull, cut across its longest side.
fn halves(full: &ConvexHull, max_vertices: usize) -> Option<Vec<ConvexHull>> {
    let (low, high) = full
        .points
        .iter()
        .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), &p| (low.min(p), high.max(p)));
    let size = high - low;
    if size.max_element() > MAX_SIDE_M.min(MAX_ELONGATION * size.min_element()) {
        return None;
    }
    let axis = if size.x > size.y.max(size.z) {
        DVec3::X
    } else if size.y > size.z {
        DVec3::Y
    } else {
        DVec3::Z
    };
    let center_m = 0.5 * (low + high).dot(axis);
    [axis, -axis]
        .into_iter()
        .map(|side| {
            let half = convex_hull(&beyond(full, side, side.dot(axis) * center_m), usize::MAX, 0.0)?;
            if half.points.len() <= max_vertices {
                return Some(half);
            }
            evenly_missed(&half.points, max_vertices, HALF_GROWTH)
        })
        .collect()
}

/// The corners of a hull at least `from_m` along `way`, and the points where its edges cross that plane.
fn beyond(hull: &ConvexHull, way: DVec3, from_m: f64) -> Vec<DVec3> {
    let height = |corner: u32| way.dot(hull.points[corner as usize]) - from_m;
    let mut points: Vec<DVec3> =
        hull.points.iter().copied().filter(|p| way.dot(*p) - from_m >= 0.0).collect();
    for triangle in &hull.triangles {
        for k in 0..3 {
            let (from, to) = (triangle[k], triangle[(k + 1) % 3]);
            // Each edge belongs to two triangles, in opposite directions.
            if height(from) < 0.0 && height(to) > 0.0 {
                let share = height(from) / (height(from) - height(to));
                points.push(hull.points[from as usize].lerp(hull.points[to as usize], share));
            }
        }
    }
    points
}

#[cfg(test)]
mod tests {
    use super::super::{distance_above, planes};
    use super::*;
    use crate::shapes::{block, cylinder, ellipsoid, sphere};

    /// Largest distance of a point outside all hulls, and of a corner of a hull outside the full hull.
    fn missed_and_excess_m(points: &[DVec3], hulls: &[ConvexHull]) -> (f64, f64) {
        let faces: Vec<_> = hulls.iter().map(planes).collect();
        let nearest =
            |p: &DVec3| faces.iter().map(|faces| distance_above(faces, *p)).fold(f64::INFINITY, f64::min);
        let missed_m = points.iter().map(nearest).fold(0.0, f64::max);
        let full = planes(&convex_hull(points, usize::MAX, 0.0).expect("a volume"));
        let corners = hulls.iter().flat_map(|hull| &hull.points);
        (missed_m, corners.map(|p| distance_above(&full, *p)).fold(0.0, f64::max))
    }

    /// Regression: oranges stuck out of their hulls by 1.8 mm, and heaps of them in a bowl overlapped after every
    /// round.
    #[test]
    fn hulls_of_fruit_miss_it_by_about_a_millimeter_at_most() {
        for radius_m in [0.02, 0.03, 0.038, 0.042] {
            for (name, size) in [("ball", DVec3::ONE), ("orange", DVec3::new(1.0, 1.0, 0.95))] {
                let fruit = ellipsoid(2.0 * radius_m * size, 48);
                let hulls = convex_hulls(&fruit.positions, 64, 0.001);
                let (missed_m, excess_m) = missed_and_excess_m(&fruit.positions, &hulls);
                let bound_m = MAX_MISSED_BY_ONE_M.max(0.026 * radius_m);
                assert!(missed_m < bound_m, "{name} of {radius_m}: sticks out by {missed_m}");
                assert!(excess_m < 0.0015, "{name} of {radius_m}: exceeded by {excess_m}");
                assert!(hulls.iter().all(|hull| hull.points.len() <= 64));
                let (low, high) = hulls
                    .iter()
                    .flat_map(|hull| &hull.points)
                    .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), p| (low.min(p.z), high.max(p.z)));
                let (from, to) = fruit
                    .positions
                    .iter()
                    .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), p| (low.min(p.z), high.max(p.z)));
                assert!((low - from).abs() < 1e-6 && (high - to).abs() < 1e-6, "its height changes");
            }
        }
    }

    #[test]
    fn what_one_hull_covers_stays_one() {
        let solids = [
            block(DVec3::splat(0.05)),
            cylinder(0.03, 0.1, 0.002, 64),
            sphere(0.012, 32),
            // As large as a table's top, which misses more.
            cylinder(0.4, 0.03, 0.002, 64),
        ];
        for solid in solids {
            let hulls = convex_hulls(&solid.positions, 64, 0.001);
            assert_eq!(hulls, [convex_hull(&solid.positions, 64, 0.001).expect("a volume")]);
        }
        assert!(convex_hulls(&[DVec3::ZERO, DVec3::X], 64, 0.0).is_empty());
    }

    #[test]
    fn halves_meet_in_the_plane_between_them() {
        let ball = sphere(0.04, 48);
        let full = convex_hull(&ball.positions, usize::MAX, 0.0).expect("a ball");
        let parts = halves(&full, 64).expect("two halves");
        let volume_m3: f64 = parts.iter().map(ConvexHull::volume_m3).sum();
        assert!((volume_m3 / full.volume_m3() - 1.0).abs() < 0.03, "{volume_m3}");
        let span = |hull: &ConvexHull| {
            hull.points
                .iter()
                .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), p| (low.min(p.z), high.max(p.z)))
        };
        let ((lower, seam), (same_seam, upper)) = (span(&parts[1]), span(&parts[0]));
        assert!((seam - same_seam).abs() < 1e-9 && lower < seam && seam < upper);
    }
}
