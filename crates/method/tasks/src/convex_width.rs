//! Smallest width of points in the plane.

use geometry::polygon::convex_hull_2d;
use glam::DVec2;

/// Smallest width of points over all directions, meters; 0 for fewer than three. A convex polygon is narrowest across
/// one of its sides (Houle and Toussaint, "Computing the width of a set", 1988). Quadratic in the corners of the hull.
pub(crate) fn narrowest_width_m(points: &[DVec2]) -> f64 {
    let corners = convex_hull_2d(points);
    let width_m = |k: usize| {
        let normal = (corners[(k + 1) % corners.len()] - corners[k]).perp().try_normalize()?;
        Some(corners.iter().map(|corner| (*corner - corners[k]).dot(normal)).fold(0.0, f64::max))
    };
    (0..corners.len()).filter_map(width_m).reduce(f64::min).unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn turned_rectangle_is_as_wide_as_its_short_side() {
        for turn in 0..20 {
            let turned = |x: f64, y: f64| DVec2::from_angle(0.1 * f64::from(turn)).rotate(DVec2::new(x, y));
            let corners =
                [turned(-0.15, -0.01), turned(0.15, -0.01), turned(0.15, 0.01), turned(-0.15, 0.01)];
            assert!((narrowest_width_m(&corners) - 0.02).abs() < 1e-12, "{turn}");
        }
        assert_eq!(narrowest_width_m(&[DVec2::ZERO, DVec2::X]), 0.0);
    }
}
