//! Ellipses in the image and on the table.

use glam::DVec2;

/// An ellipse.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Ellipse {
    pub center: DVec2,
    /// Semi-axes, and the direction of the first.
    pub semi_axes: DVec2,
    pub angle_rad: f64,
}

impl Ellipse {
    /// The ellipse with the area moments of a simple polygon; `None` if it is degenerate.
    pub fn with_moments_of(polygon: &[DVec2]) -> Option<Self> {
        let origin = *polygon.first()?;
        let (mut total, mut first) = (0.0, DVec2::ZERO);
        let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
        for pair in polygon[1..].windows(2) {
            let (b, c) = (pair[0] - origin, pair[1] - origin);
            let area = 0.5 * b.perp_dot(c);
            total += area;
            first += area * (b + c) / 3.0;
            // Second moments of a triangle with one corner at the origin.
            let sum = b + c;
            xx += area / 12.0 * (b.x * b.x + c.x * c.x + sum.x * sum.x);
            yy += area / 12.0 * (b.y * b.y + c.y * c.y + sum.y * sum.y);
            xy += area / 12.0 * (b.x * b.y + c.x * c.y + sum.x * sum.y);
        }
        if total.abs() < 1e-12 {
            return None;
        }
        let mean = first / total;
        let (xx, xy, yy) =
            (xx / total - mean.x * mean.x, xy / total - mean.x * mean.y, yy / total - mean.y * mean.y);
        let angle_rad = 0.5 * (2.0 * xy).atan2(xx - yy);
        let (half, spread) = (0.5 * (xx + yy), (0.5 * (xx - yy)).hypot(xy));
        // A filled ellipse has a quarter of its squared semi-axes as variances.
        let semi_axes = DVec2::new(2.0 * (half + spread).sqrt(), 2.0 * (half - spread).max(0.0).sqrt());
        (semi_axes.y > 1e-3 * semi_axes.x).then(|| Self { center: origin + mean, semi_axes, angle_rad })
    }

    /// Depth of a point inside the ellipse, to first order near its edge; negative outside.
    pub fn depth_px(&self, p: DVec2) -> f64 {
        let along = DVec2::from_angle(self.angle_rad);
        let away = p - self.center;
        let scaled = DVec2::new(along.dot(away), along.perp_dot(away)) / self.semi_axes;
        let radius = scaled.length();
        let steepness = (scaled / self.semi_axes).length() / radius.max(1e-9);
        (1.0 - radius) / steepness.max(1e-9)
    }

    /// Point at a parameter angle.
    pub fn at(&self, t: f64) -> DVec2 {
        let along = DVec2::from_angle(self.angle_rad);
        self.center + self.semi_axes.x * t.cos() * along + self.semi_axes.y * t.sin() * along.perp()
    }

    /// Points along the ellipse, in the order of growing angle.
    pub fn polygon(&self, corners: u32) -> Vec<DVec2> {
        (0..corners).map(|k| self.at(std::f64::consts::TAU * f64::from(k) / f64::from(corners))).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ellipse_is_recovered_from_its_moments() {
        let ellipse =
            Ellipse { center: DVec2::new(40.0, 30.0), semi_axes: DVec2::new(20.0, 7.0), angle_rad: 0.4 };
        let found = Ellipse::with_moments_of(&ellipse.polygon(720)).expect("an area");
        assert!((found.center - ellipse.center).length() < 1e-6);
        assert!((found.semi_axes - ellipse.semi_axes).length() < 1e-3);
        assert!((found.angle_rad - ellipse.angle_rad).abs() < 1e-6);
        assert_eq!(Ellipse::with_moments_of(&[DVec2::ZERO, DVec2::X, 2.0 * DVec2::X]), None);
    }
}
