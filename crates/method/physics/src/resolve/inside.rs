//! Overhang of a footprint over the table's edge, and the direction back.

use glam::DVec2;

use geometry::Outline;
use geometry::polygon::depth_in_convex_m;

/// The largest violation of a convex footprint (counter-clockwise) on a table with that outline, of which it is to lie
/// at least `margin_m` inside: the missing distance, and the shift that removes it there. Zero if there is none.
/// Corners of the footprint count, and notches of the outline that reach into it.
pub(crate) fn missing(outline: &Outline, footprint: &[DVec2], margin_m: f64) -> (f64, DVec2) {
    let corners = outline.corners();
    let mut worst = (0.0, DVec2::ZERO);
    for &point in footprint {
        let missing = margin_m - outline.depth_inside_m(point);
        if missing <= worst.0 {
            continue;
        }
        let (edge, _) = (0..corners.len())
            .map(|k| {
                let (a, b) = (corners[k], corners[(k + 1) % corners.len()]);
                let t = ((point - a).dot(b - a) / (b - a).length_squared().max(1e-300)).clamp(0.0, 1.0);
                (k, (point - (a + t * (b - a))).length_squared())
            })
            .fold((0, f64::INFINITY), |best, next| if next.1 < best.1 { next } else { best });
        let (a, b) = (corners[edge], corners[(edge + 1) % corners.len()]);
        worst = (missing, (b - a).perp().normalize_or_zero() * missing);
    }
    for notch in notches(corners) {
        let missing = margin_m + depth_in_convex_m(footprint, notch);
        if missing > worst.0 {
            worst = (missing, inward_at(footprint, notch) * missing);
        }
    }
    worst
}

/// Corners at which the outline turns inward.
fn notches(corners: &[DVec2]) -> impl Iterator<Item = DVec2> + '_ {
    let count = corners.len();
    (0..count)
        .map(move |k| [corners[(k + count - 1) % count], corners[k], corners[(k + 1) % count]])
        .filter(|[a, b, c]| (*b - *a).perp_dot(*c - *b) < 0.0)
        .map(|[_, b, _]| b)
}

/// Unit normal, into the footprint, of its side nearest to a point.
fn inward_at(footprint: &[DVec2], point: DVec2) -> DVec2 {
    let sides = (0..footprint.len()).map(|k| (footprint[k], footprint[(k + 1) % footprint.len()]));
    let normals = sides.map(|(a, b)| ((b - a).perp().normalize_or_zero(), a));
    normals
        .map(|(normal, a)| (normal, normal.dot(point - a)))
        .fold((DVec2::ZERO, f64::INFINITY), |best, next| if next.1 < best.1 { next } else { best })
        .0
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points(corners: &[(f64, f64)]) -> Vec<DVec2> {
        corners.iter().map(|&(x, y)| DVec2::new(x, y)).collect()
    }

    #[test]
    fn missing_shift_returns_corners_and_avoids_notches() {
        // A square meter with a notch in the center of its front edge.
        let outline = Outline::new(points(&[
            (-0.5, -0.5),
            (-0.1, -0.5),
            (0.0, -0.3),
            (0.1, -0.5),
            (0.5, -0.5),
            (0.5, 0.5),
            (-0.5, 0.5),
        ]))
        .expect("an outline");
        let square = |x: f64, y: f64| points(&[(x, y), (x + 0.2, y), (x + 0.2, y + 0.2), (x, y + 0.2)]);
        assert_eq!(missing(&outline, &square(-0.4, 0.0), 0.01), (0.0, DVec2::ZERO));
        let (over_m, way) = missing(&outline, &square(0.35, 0.0), 0.01);
        assert!((over_m - 0.06).abs() < 1e-12 && (way - DVec2::new(-0.06, 0.0)).length() < 1e-12, "{way}");
        // Its corners lie on the table, the notch's tip under it.
        let (under_m, way) = missing(&outline, &square(-0.13, -0.42), 0.01);
        assert!((under_m - 0.08).abs() < 1e-12 && (way - DVec2::new(-0.08, 0.0)).length() < 1e-12, "{way}");
    }
}
