//! What a thing covers seen from above: a convex polygon.

use glam::DVec2;

use super::Placement;
use geometry::Outline;
use geometry::collide::convex_hull_2d;

/// Corners kept of a footprint; a circle of 12 cm radius is then missed by at most a millimeter.
const MOST_CORNERS: usize = 24;

/// A convex counter-clockwise polygon, meters.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Footprint {
    corners: Vec<DVec2>,
    center: DVec2,
    radius_m: f64,
}

impl Footprint {
    /// The convex hull of the points, reduced to a few corners.
    pub fn around(points: impl Iterator<Item = DVec2>) -> Self {
        let points: Vec<DVec2> = points.collect();
        let mut corners = convex_hull_2d(&points);
        while corners.len() > MOST_CORNERS {
            let count = corners.len();
            // The corner that cuts off the least area goes.
            let lost = |k: usize| {
                let (a, b, c) = (corners[(k + count - 1) % count], corners[k], corners[(k + 1) % count]);
                (b - a).perp_dot(c - b).abs()
            };
            let least = (0..count).min_by(|&a, &b| lost(a).total_cmp(&lost(b))).unwrap_or(0);
            corners.remove(least);
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

    /// Turned about the origin, then moved.
    pub fn placed(&self, at: &Placement) -> Self {
        let turn = DVec2::from_angle(at.yaw_rad);
        Self::of_corners(self.corners.iter().map(|c| at.xy_m + turn.rotate(*c)).collect())
    }

    pub fn corners(&self) -> &[DVec2] {
        &self.corners
    }

    /// Middle of the axis-aligned box.
    pub fn center(&self) -> DVec2 {
        self.center
    }

    pub fn bounds(&self) -> (DVec2, DVec2) {
        let first = self.center;
        self.corners.iter().fold((first, first), |(l, h), &c| (l.min(c), h.max(c)))
    }

    pub fn size_m(&self) -> DVec2 {
        let (low, high) = self.bounds();
        high - low
    }

    /// How far the polygon reaches from its center along the unit direction.
    pub fn reach_m(&self, direction: DVec2) -> f64 {
        self.corners.iter().map(|c| (*c - self.center).dot(direction)).fold(0.0, f64::max)
    }

    /// Area, m^2.
    pub fn area_m2(&self) -> f64 {
        let count = self.corners.len();
        (0..count).map(|k| 0.5 * self.corners[k].perp_dot(self.corners[(k + 1) % count])).sum()
    }

    /// Distance between two footprints, negative where they overlap. At most the true distance (exact
    /// unless corner faces corner).
    pub fn gap_m(&self, other: &Self) -> f64 {
        let apart = self.center.distance(other.center) - self.radius_m - other.radius_m;
        // Circles far apart need no closer look.
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

    /// Distance it keeps from the outline's edge, at least; negative where it reaches over.
    pub fn depth_inside_m(&self, outline: &Outline) -> f64 {
        let middle_m = outline.depth_inside_m(self.center);
        // Far from the edge the circle around it is answer enough.
        if middle_m < 0.0 || middle_m - self.radius_m > 0.1 {
            return middle_m - self.radius_m;
        }
        let count = self.corners.len();
        let edges = (0..count).flat_map(|k| {
            let (a, b) = (self.corners[k], self.corners[(k + 1) % count]);
            // Middles of edges too: an outline may be dented.
            [a, 0.5 * (a + b)]
        });
        edges.map(|p| outline.depth_inside_m(p)).fold(f64::INFINITY, f64::min)
    }

    /// Distance it keeps from the edge of a convex polygon around it; negative where it reaches over.
    pub fn depth_in_m(&self, around: &Self) -> f64 {
        let depth = |p: DVec2| geometry::collide::depth_in_convex_m(&around.corners, p);
        self.corners.iter().map(|&c| depth(c)).fold(f64::INFINITY, f64::min)
    }

    /// The hull of several.
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
    fn gaps_are_signed_and_round_things_keep_their_size() {
        assert!((square(0.0, 0.0).gap_m(&square(2.2, 0.5)) - 0.2).abs() < 1e-12);
        assert!((square(0.0, 0.0).gap_m(&square(1.7, 0.5)) + 0.3).abs() < 1e-12);
        let circle = Footprint::around((0..200).map(|k| 0.12 * DVec2::from_angle(0.0314159 * f64::from(k))));
        assert_eq!(circle.corners().len(), MOST_CORNERS);
        for k in 0..50 {
            let reach = circle.reach_m(DVec2::from_angle(0.13 * f64::from(k)));
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
