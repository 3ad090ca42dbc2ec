//! A simple closed polygon in the plane: a table's edge, a footprint.

use glam::DVec2;
use serde::{Deserialize, Serialize};

/// Counter-clockwise corners, meters; at least three, positive area.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Vec<DVec2>", into = "Vec<DVec2>")]
pub struct Outline(Vec<DVec2>);

/// Reason why a list of corners is not an outline.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum OutlineError {
    #[error("an outline needs at least three finite corners")]
    TooFewCorners,
    #[error("the outline encloses no area")]
    NoArea,
}

impl Outline {
    /// Checks the corners and orients them counter-clockwise.
    pub fn new(mut corners: Vec<DVec2>) -> Result<Self, OutlineError> {
        if corners.len() < 3 || corners.iter().any(|c| !c.is_finite()) {
            return Err(OutlineError::TooFewCorners);
        }
        let area = signed_area_m2(&corners);
        if area.abs() < 1e-9 {
            return Err(OutlineError::NoArea);
        }
        if area < 0.0 {
            corners.reverse();
        }
        Ok(Self(corners))
    }

    pub fn corners(&self) -> &[DVec2] {
        &self.0
    }

    /// Enclosed area, m^2.
    pub fn area_m2(&self) -> f64 {
        signed_area_m2(&self.0)
    }

    /// Lowest and highest corner of the axis-aligned box.
    pub fn bounds(&self) -> (DVec2, DVec2) {
        self.0.iter().fold((self.0[0], self.0[0]), |(low, high), &c| (low.min(c), high.max(c)))
    }

    /// Distance to the nearest edge, meters: positive inside, negative outside.
    pub fn depth_inside_m(&self, point: DVec2) -> f64 {
        let (mut nearest, mut inside) = (f64::INFINITY, false);
        for (k, &b) in self.0.iter().enumerate() {
            let a = self.0[(k + self.0.len() - 1) % self.0.len()];
            let t = ((point - a).dot(b - a) / (b - a).length_squared().max(1e-300)).clamp(0.0, 1.0);
            nearest = nearest.min((point - (a + t * (b - a))).length());
            if (a.y > point.y) != (b.y > point.y)
                && point.x < a.x + (b.x - a.x) * (point.y - a.y) / (b.y - a.y)
            {
                inside = !inside;
            }
        }
        if inside { nearest } else { -nearest }
    }

    /// The point itself if inside, else the nearest point of the edge.
    pub fn nearest_inside(&self, point: DVec2) -> DVec2 {
        if self.contains(point) { point } else { self.nearest_on_edge(point) }
    }

    /// The nearest point of the edge.
    pub fn nearest_on_edge(&self, point: DVec2) -> DVec2 {
        let on_sides = self.0.iter().enumerate().map(|(k, &b)| {
            let a = self.0[(k + self.0.len() - 1) % self.0.len()];
            let t = ((point - a).dot(b - a) / (b - a).length_squared().max(1e-300)).clamp(0.0, 1.0);
            a + t * (b - a)
        });
        let away = |p: &DVec2| (point - *p).length_squared();
        on_sides.min_by(|a, b| away(a).total_cmp(&away(b))).unwrap_or(point)
    }

    /// Whether the point lies inside or on the edge.
    pub fn contains(&self, point: DVec2) -> bool {
        self.depth_inside_m(point) >= -1e-12
    }
}

fn signed_area_m2(corners: &[DVec2]) -> f64 {
    (0..corners.len()).map(|k| 0.5 * corners[k].perp_dot(corners[(k + 1) % corners.len()])).sum()
}

impl TryFrom<Vec<DVec2>> for Outline {
    type Error = OutlineError;
    fn try_from(corners: Vec<DVec2>) -> Result<Self, OutlineError> {
        Self::new(corners)
    }
}

impl From<Outline> for Vec<DVec2> {
    fn from(outline: Outline) -> Self {
        outline.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn outline_orients_clockwise_corners_and_signs_depths() {
        let square = [(0.0, 0.0), (0.0, 2.0), (2.0, 2.0), (2.0, 0.0)].map(|(x, y)| DVec2::new(x, y));
        let outline = Outline::new(square.to_vec()).expect("a square");
        assert!((outline.area_m2() - 4.0).abs() < 1e-12);
        assert!((outline.depth_inside_m(DVec2::new(1.5, 1.0)) - 0.5).abs() < 1e-12);
        assert!((outline.depth_inside_m(DVec2::new(3.0, 1.0)) + 1.0).abs() < 1e-12);
        assert_eq!(outline.nearest_inside(DVec2::new(1.5, 1.0)), DVec2::new(1.5, 1.0));
        assert_eq!(outline.nearest_inside(DVec2::new(3.0, 1.5)), DVec2::new(2.0, 1.5));
        assert_eq!(outline.nearest_inside(DVec2::new(-1.0, 3.0)), DVec2::new(0.0, 2.0));
        assert_eq!(Outline::new(vec![DVec2::ZERO; 3]), Err(OutlineError::NoArea));
    }
}
