//! Footprints: the vertical projection of an object as a convex polygon.

use glam::DVec2;

use super::Placement;
use geometry::Outline;
use geometry::polygon::convex_hull_2d;

/// Maximum number of corners; the error for a circle of 12 cm radius is at most a millimeter.
const MAX_CORNERS: usize = 24;

/// A convex counter-clockwise polygon, meters.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Footprint {
    corners: Vec<DVec2>,
    center: DVec2,
    radius_m: f64,
}

impl Footprint {
    /// The convex hull of the points, simplified to at most [`MAX_CORNERS`] corners.
    pub fn around(points: impl Iterator<Item = DVec2>) -> Self {
        let points: Vec<DVec2> = points.collect();
        let mut corners = convex_hull_2d(&points);
        while corners.len() > MAX_CORNERS {
            let count = corners.len();
            // Remove the corner whose triangle has the smallest area.
            let removed_area = |k: usize| {
                let (a, b, c) = (corners[(k + count - 1) % count], corners[k], corners[(k + 1) % count]);
                (b - a).perp_dot(c - b).abs()
            };
            let corner = (0..count).min_by(|&a, &b| removed_area(a).total_cmp(&removed_area(b))).unwrap_or(0);
            corners.remove(corner);
        }
        Self::of_corners(corners)
    }

    fn of_corners(corners: Vec<DVec2>) -> Self {
        let first = corners.first().copied().unwrap_or_default();
        let (low, high) = corners.iter().fold((first, first), |(l, h), &c| (l.min(c), h.max(c)));
        let center = 0.5 * (low + high);
        let radius_m = corners.iter().map(|c| c.distance(center)).fold(0.0, f64::max);
        Self { corners, center, radius_m }
    }

    /// The footprint rotated about the origin, then translated.
    pub fn placed(&self, at: &Placement) -> Self {
        let turn = DVec2::from_angle(at.yaw_rad);
        Self::of_corners(self.corners.iter().map(|c| at.xy_m + turn.rotate(*c)).collect())
    }

    pub fn corners(&self) -> &[DVec2] {
        &self.corners
    }

    /// Center of the axis-aligned bounding box.
    pub fn center(&self) -> DVec2 {
        self.center
    }

    pub fn bounds(&self) -> (DVec2, DVec2) {
        let first = self.center;
        self.corners.iter().fold((first, first), |(l, h), &c| (l.min(c), h.max(c)))
    }

    /// Radius of the circle around the center that contains the polygon, meters.
    pub fn radius_m(&self) -> f64 {
        self.radius_m
    }

    pub fn size_m(&self) -> DVec2 {
        let (low, high) = self.bounds();
        high - low
    }

    /// Extent of the polygon from its center along a unit direction, meters.
    pub fn extent_m(&self, direction: DVec2) -> f64 {
        self.corners.iter().map(|c| (*c - self.center).dot(direction)).fold(0.0, f64::max)
    }

    /// Area, m^2.
    pub fn area_m2(&self) -> f64 {
        let count = self.corners.len();
        (0..count).map(|k| 0.5 * self.corners[k].perp_dot(self.corners[(k + 1) % count])).sum()
    }

    /// Signed distance between two footprints, negative on overlap. A lower bound of the true distance, exact unless
    /// the closest features are two corners.
    pub fn gap_m(&self, other: &Self) -> f64 {
        let apart = self.center.distance(other.center) - self.radius_m - other.radius_m;
        // The distance of the bounding circles is sufficient for distant footprints.
        if apart > 0.3 { apart } else { self.separation_m(other).max(other.separation_m(self)) }
    }

    fn separation_m(&self, other: &Self) -> f64 {
        let count = self.corners.len();
        (0..count)
            .filter_map(|k| {
                let (a, b) = (self.corners[k], self.corners[(k + 1) % count]);
                let normal = -(b - a).perp().try_normalize()?;
                let nearest =
                    other.corners.iter().map(|c| (*c - a).dot(normal)).fold(f64::INFINITY, f64::min);
                Some(nearest)
            })
            .fold(f64::NEG_INFINITY, f64::max)
    }

    /// Lower bound of the distance to the outline's edge, meters; negative if the footprint extends beyond the edge.
    pub fn depth_inside_m(&self, outline: &Outline) -> f64 {
        let center_m = outline.depth_inside_m(self.center);
        // Far from the edge the bounding circle is sufficient.
        if center_m < 0.0 || center_m - self.radius_m > 0.1 {
            return center_m - self.radius_m;
        }
        let count = self.corners.len();
        let edges = (0..count).flat_map(|k| {
            let (a, b) = (self.corners[k], self.corners[(k + 1) % count]);
            // Edge midpoints are included because an outline may be concave.
            [a, 0.5 * (a + b)]
        });
        edges.map(|p| outline.depth_inside_m(p)).fold(f64::INFINITY, f64::min)
    }

    /// Distance to the edge of an enclosing convex polygon, meters; negative if the footprint extends beyond the edge.
    pub fn depth_in_m(&self, around: &Self) -> f64 {
        let depth = |p: DVec2| geometry::polygon::depth_in_convex_m(&around.corners, p);
        self.corners.iter().map(|&c| depth(c)).fold(f64::INFINITY, f64::min)
    }

    /// The convex hull of several footprints.
    pub fn union<'a>(parts: impl Iterator<Item = &'a Self>) -> Self {
        Self::around(parts.flat_map(|part| part.corners.iter().copied()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square(x: f64, y: f64) -> Footprint {
        let at = Placement { xy_m: DVec2::new(x, y), yaw_rad: 0.0 };
        Footprint::around([(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].into_iter().map(DVec2::from))
            .placed(&at)
    }

    #[test]
    fn gap_is_signed_and_simplified_circle_keeps_its_radius() {
        assert!((square(0.0, 0.0).gap_m(&square(2.2, 0.5)) - 0.2).abs() < 1e-12);
        assert!((square(0.0, 0.0).gap_m(&square(1.7, 0.5)) + 0.3).abs() < 1e-12);
        let circle = Footprint::around((0..200).map(|k| 0.12 * DVec2::from_angle(0.0314159 * f64::from(k))));
        assert_eq!(circle.corners().len(), MAX_CORNERS);
        for k in 0..50 {
            let reach = circle.extent_m(DVec2::from_angle(0.13 * f64::from(k)));
            // Fewer corners keep the radius within two hundredths.
            assert!((0.1176..0.1224).contains(&reach), "{reach}");
        }
        assert!(
            (circle.placed(&Placement { xy_m: DVec2::ZERO, yaw_rad: 0.5 }).depth_in_m(&square(0.0, 0.0))
                - 0.88)
                .abs()
                < 3e-3
        );
    }
}
