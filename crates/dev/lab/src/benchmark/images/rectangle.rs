//! Minimum-area bounding rectangles of a footprint: its yaw and aspect.

use glam::DVec2;

use geometry::polygon::convex_hull_2d;

/// Rectangles up to this factor larger than the smallest also count: those on the three sides of a triangle have
/// equal areas.
const SLACK: f64 = 1.02;

/// A rectangle in the plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rectangle {
    /// Direction of its longer sides, radians in [0, pi).
    pub yaw_rad: f64,
    /// Longer side over shorter; at least 1.
    pub aspect: f64,
}

/// Bounding rectangles of minimum or nearly minimum area, the smallest first; none if the points enclose no area.
/// One side of each lies on a side of the hull, so all hull sides are tried.
pub fn smallest_around(points: &[DVec2]) -> Vec<Rectangle> {
    let hull = convex_hull_2d(points);
    let along = |k: usize| (hull[(k + 1) % hull.len()] - hull[k]).try_normalize();
    let mut all: Vec<(f64, Rectangle)> = (0..hull.len())
        .filter_map(along)
        .map(|axis| {
            let local = hull.iter().map(|p| DVec2::new(p.dot(axis), p.dot(axis.perp())));
            let (low, high) =
                local.fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(l, h), p| (l.min(p), h.max(p)));
            let size = high - low;
            let longer = if size.x >= size.y { axis } else { axis.perp() };
            let rectangle = Rectangle {
                yaw_rad: longer.to_angle().rem_euclid(std::f64::consts::PI),
                aspect: size.max_element() / size.min_element(),
            };
            (size.element_product(), rectangle)
        })
        .filter(|(_, rectangle)| rectangle.aspect.is_finite())
        .collect();
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    let min_area = all.first().map_or(0.0, |(area, _)| *area);
    all.into_iter()
        .take_while(|(area, _)| *area <= SLACK * min_area)
        .map(|(_, rectangle)| rectangle)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn smallest_around_recovers_rotated_rectangle() {
        let turn = DVec2::from_angle(0.4);
        let at = DVec2::new(0.3, -0.2);
        let corners = [(-2.0, -1.0), (2.0, -1.0), (2.0, 1.0), (-2.0, 1.0), (0.5, 0.2)]
            .map(|(x, y)| at + turn.rotate(DVec2::new(x, y)));
        let found = smallest_around(&corners);
        assert!(found.iter().all(|found| (found.aspect - 2.0).abs() < 1e-12), "{found:?}");
        assert!(found.iter().all(|found| (found.yaw_rad - 0.4).abs() < 1e-12), "{found:?}");
        assert_eq!(smallest_around(&[DVec2::ZERO, DVec2::X]), []);
    }

    #[test]
    fn triangle_has_three_smallest_rectangles() {
        let corners = [(0.0, 0.0), (3.0, 0.0), (1.0, 2.0)].map(|(x, y)| DVec2::new(x, y));
        assert_eq!(smallest_around(&corners).len(), 3);
    }
}
