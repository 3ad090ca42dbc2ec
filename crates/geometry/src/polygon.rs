//! Polygons in the plane: convex hull, containment, signed distance.

use glam::DVec2;

/// Counter-clockwise convex hull of points in the plane, without repeated and collinear points. O(n log n).
pub fn convex_hull_2d(points: &[DVec2]) -> Vec<DVec2> {
    convex_hull_2d_with_tolerance(points, 0.0)
}

/// As [`convex_hull_2d`], without corners whose two edges have a cross product of at most `tolerance` (area units).
pub fn convex_hull_2d_with_tolerance(points: &[DVec2], tolerance: f64) -> Vec<DVec2> {
    convex_hull_indices(points, tolerance).into_iter().map(|k| points[k]).collect()
}

/// Indices of the corners of [`convex_hull_2d_with_tolerance`]: Andrew's monotone chain.
pub(crate) fn convex_hull_indices(points: &[DVec2], tolerance: f64) -> Vec<usize> {
    let mut order: Vec<usize> = (0..points.len()).collect();
    order.sort_by(|&a, &b| points[a].x.total_cmp(&points[b].x).then(points[a].y.total_cmp(&points[b].y)));
    order.dedup_by(|a, b| points[*a] == points[*b]);
    if order.len() < 3 {
        return order;
    }
    let half = |order: &mut dyn Iterator<Item = usize>| {
        let mut chain: Vec<usize> = Vec::new();
        for k in order {
            while let [.., a, b] = chain[..]
                && (points[b] - points[a]).perp_dot(points[k] - points[b]) <= tolerance
            {
                chain.pop();
            }
            chain.push(k);
        }
        chain.pop();
        chain
    };
    let mut hull = half(&mut order.iter().copied());
    hull.extend(half(&mut order.iter().rev().copied()));
    hull
}

/// Whether the point lies in a convex counter-clockwise polygon, or within rounding of its edge.
pub(crate) fn is_in_convex(polygon: &[DVec2], point: DVec2) -> bool {
    const ROUNDING_M2: f64 = 1e-9;
    polygon.len() >= 3
        && (0..polygon.len()).all(|k| {
            let (a, b) = (polygon[k], polygon[(k + 1) % polygon.len()]);
            (b - a).perp_dot(point - a) >= -ROUNDING_M2
        })
}

/// Signed distance of the point to a convex counter-clockwise polygon (or a segment, or a point):
/// positive inside. `f64::NEG_INFINITY` for an empty polygon.
pub fn depth_in_convex_m(polygon: &[DVec2], point: DVec2) -> f64 {
    let (mut nearest, mut inside) = (f64::INFINITY, polygon.len() >= 3);
    for (k, &a) in polygon.iter().enumerate() {
        let b = polygon[(k + 1) % polygon.len()];
        let t = ((point - a).dot(b - a) / (b - a).length_squared().max(1e-300)).clamp(0.0, 1.0);
        nearest = nearest.min((point - (a + t * (b - a))).length());
        inside &= (b - a).perp_dot(point - a) >= 0.0;
    }
    if inside { nearest } else { -nearest }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distance_is_defined_for_degenerate_polygons() {
        let point = DVec2::new(0.0, 1.0);
        assert_eq!(depth_in_convex_m(&[], point), f64::NEG_INFINITY);
        assert_eq!(depth_in_convex_m(&[DVec2::ZERO], point), -1.0);
        assert_eq!(depth_in_convex_m(&[DVec2::ZERO, DVec2::new(0.0, 2.0)], point), -0.0);
    }
}
