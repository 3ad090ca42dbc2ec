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
        // The bound makes an edge without length its start.
        let t = ((point - a).dot(b - a) / (b - a).length_squared().max(1e-300)).clamp(0.0, 1.0);
        nearest = nearest.min((point - (a + t * (b - a))).length());
        inside &= (b - a).perp_dot(point - a) >= 0.0;
    }
    if inside { nearest } else { -nearest }
}

/// Signed distance of two convex counter-clockwise polygons, meters: the distance of their nearest points where they
/// are apart; negative where they overlap, by the shortest translation that separates them. `f64::INFINITY` if one is
/// empty. O(n m).
pub fn convex_distance_m(a: &[DVec2], b: &[DVec2]) -> f64 {
    let separation = separation_m(a, b).max(separation_m(b, a));
    if separation < 0.0 {
        return separation;
    }
    let to = |polygon: &[DVec2], points: &[DVec2]| {
        points.iter().map(|&p| -depth_in_convex_m(polygon, p)).fold(f64::INFINITY, f64::min)
    };
    if a.is_empty() || b.is_empty() { f64::INFINITY } else { to(a, b).min(to(b, a)).max(0.0) }
}

/// Largest separation of `b` from `a` along the edge normals of `a`; negative if no edge separates them.
fn separation_m(a: &[DVec2], b: &[DVec2]) -> f64 {
    (0..a.len())
        .filter_map(|k| {
            let normal = -(a[(k + 1) % a.len()] - a[k]).perp().try_normalize()?;
            Some(b.iter().map(|p| (*p - a[k]).dot(normal)).fold(f64::INFINITY, f64::min))
        })
        .fold(f64::NEG_INFINITY, f64::max)
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

    /// The signed distance by samples on both outlines, for polygons that are apart.
    fn sampled_distance_m(a: &[DVec2], b: &[DVec2]) -> f64 {
        let samples = |polygon: &[DVec2]| -> Vec<DVec2> {
            (0..polygon.len())
                .flat_map(|k| {
                    let (from, to) = (polygon[k], polygon[(k + 1) % polygon.len()]);
                    (0..200).map(move |step| from.lerp(to, f64::from(step) / 200.0))
                })
                .collect()
        };
        let (a, b) = (samples(a), samples(b));
        a.iter().flat_map(|p| b.iter().map(|q| p.distance(*q))).fold(f64::INFINITY, f64::min)
    }

    #[test]
    fn convex_distance_matches_cases_by_hand_and_slow_reference() {
        let square = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(DVec2::from);
        let at = |x: f64, y: f64, turn: f64| {
            square.map(|c| DVec2::new(x, y) + DVec2::from_angle(turn).rotate(c)).to_vec()
        };
        assert!((convex_distance_m(&square, &at(2.5, 0.5, 0.0)) - 0.5).abs() < 1e-12);
        // The nearest points are two corners.
        assert!((convex_distance_m(&square, &at(2.3, 2.4, 0.0)) - 0.5).abs() < 1e-12);
        assert!((convex_distance_m(&square, &at(1.5, 0.0, 0.0)) + 0.5).abs() < 1e-12);
        assert!((convex_distance_m(&square, &[DVec2::new(3.0, 0.0)]) - 2.0).abs() < 1e-12);
        for k in 0..12 {
            let angle = 0.7 * f64::from(k);
            let offset = DVec2::from_angle(angle) * (3.0 + 0.1 * f64::from(k));
            let other = at(offset.x, offset.y, 0.4 * f64::from(k));
            let exact = convex_distance_m(&square, &other);
            assert!((exact - sampled_distance_m(&square, &other)).abs() < 0.01, "{k}: {exact}");
            assert_eq!(exact, convex_distance_m(&other, &square));
        }
    }
}
