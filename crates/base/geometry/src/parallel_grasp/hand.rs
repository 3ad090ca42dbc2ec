//! The hand of a gripper as axes, and where hulls lie in the way of its fingers.
//!
//! A finger that closes sweeps a column: as wide as the finger, from its tip up, without end along the closing line.
//! Each convex hull occupies one interval of that line inside the column; since the column cuts the hull only across
//! the line, the ends of the interval lie on the hull's triangles, clipped to the column (Sutherland and Hodgman,
//! "Reentrant polygon clipping", 1974). So opening, closing and approach are questions about intervals. Object frame,
//! meters.

use glam::DVec3;

use crate::ConvexHull;

/// Intervals closer than this are one: nothing fits between, meters.
const SAME_M: f64 = 1e-4;

/// Axes of a hand, unit and perpendicular.
pub(super) struct Hand {
    /// Along which the fingers close.
    pub closing: DVec3,
    /// From the tips to the palm.
    pub up: DVec3,
    across: DVec3,
}

/// The column that the fingers sweep, but for its height.
pub(super) struct Column {
    /// On its center line.
    pub point_m: DVec3,
    pub half_width_m: f64,
}

/// A hull with a ball around it.
pub(super) struct Part<'a> {
    hull: &'a ConvexHull,
    center_m: DVec3,
    radius_m: f64,
}

impl<'a> Part<'a> {
    pub fn of(hull: &'a ConvexHull) -> Self {
        let center_m = hull.points.iter().sum::<DVec3>() / hull.points.len().max(1) as f64;
        let radius_m = hull.points.iter().map(|p| p.distance(center_m)).fold(0.0, f64::max);
        Self { hull, center_m, radius_m }
    }
}

impl Hand {
    /// `up` is perpendicular to `closing`.
    pub fn new(closing: DVec3, up: DVec3) -> Self {
        Self { closing, up, across: up.cross(closing) }
    }

    /// The hand that is as upright as its closing line allows.
    pub fn upright(closing: DVec3) -> Option<Self> {
        let up = (DVec3::Z - closing.z * closing).try_normalize()?;
        Some(Self::new(closing, up))
    }

    /// Height of the tips along `up`: the wanted one, or as much more as keeps fingers above the floor that reach so
    /// far along the closing line. `None` where more does not help.
    pub fn tip_above(
        &self,
        point_m: DVec3,
        wanted_m: f64,
        reach_m: f64,
        width_m: f64,
        floor_m: f64,
    ) -> Option<f64> {
        let center_m = point_m.z + (wanted_m - point_m.dot(self.up)) * self.up.z;
        let spread_m = reach_m * self.closing.z.abs() + 0.5 * width_m * self.across.z.abs();
        let missing_m = floor_m - (center_m - spread_m);
        if missing_m <= 0.0 {
            Some(wanted_m)
        } else if self.up.z > 0.3 {
            Some(wanted_m + missing_m / self.up.z)
        } else {
            None
        }
    }

    /// Parts of the object in the column between two heights along `up`, as disjoint intervals of the closing line,
    /// ascending.
    pub fn spans(&self, parts: &[Part], column: &Column, [from_m, to_m]: [f64; 2]) -> Vec<[f64; 2]> {
        let across_m = column.point_m.dot(self.across);
        let limits = [
            (self.across, across_m + column.half_width_m),
            (-self.across, column.half_width_m - across_m),
            (self.up, to_m),
            (-self.up, -from_m),
        ];
        let mut found: Vec<[f64; 2]> = parts
            .iter()
            .filter(|part| {
                limits.iter().all(|(way, limit_m)| way.dot(part.center_m) - part.radius_m <= *limit_m)
            })
            .filter_map(|part| self.span(part.hull, &limits))
            .collect();
        found.sort_by(|a, b| a[0].total_cmp(&b[0]));
        let mut merged: Vec<[f64; 2]> = Vec::new();
        for [from, to] in found {
            match merged.last_mut() {
                Some(last) if from <= last[1] + SAME_M => last[1] = last[1].max(to),
                _ => merged.push([from, to]),
            }
        }
        merged
    }

    /// The interval of the closing line that a hull occupies within the limits.
    fn span(&self, hull: &ConvexHull, limits: &[(DVec3, f64); 4]) -> Option<[f64; 2]> {
        // Of each point, a bit for each limit that it lies beyond.
        let beyond = |p: &DVec3| {
            limits
                .iter()
                .rev()
                .fold(0_u8, |bits, (way, limit_m)| bits << 1 | u8::from(way.dot(*p) > *limit_m))
        };
        let beyond: Vec<u8> = hull.points.iter().map(beyond).collect();
        if beyond.iter().fold(u8::MAX, |all, bits| all & bits) != 0 {
            return None;
        }
        let (mut from_m, mut to_m) = (f64::INFINITY, f64::NEG_INFINITY);
        let mut reach = |p: &DVec3| {
            let along_m = p.dot(self.closing);
            (from_m, to_m) = (from_m.min(along_m), to_m.max(along_m));
        };
        let mut polygon: Vec<DVec3> = Vec::with_capacity(8);
        let mut clipped: Vec<DVec3> = Vec::with_capacity(8);
        for [i, j, k] in &hull.triangles {
            let [i, j, k] = [*i as usize, *j as usize, *k as usize];
            if beyond[i] & beyond[j] & beyond[k] != 0 {
                continue;
            }
            let corners = [hull.points[i], hull.points[j], hull.points[k]];
            if beyond[i] | beyond[j] | beyond[k] == 0 {
                corners.iter().for_each(&mut reach);
                continue;
            }
            polygon.clear();
            polygon.extend(corners);
            for &(way, limit_m) in limits.iter().filter(|(_, limit_m)| limit_m.is_finite()) {
                clip(&polygon, way, limit_m, &mut clipped);
                std::mem::swap(&mut polygon, &mut clipped);
            }
            polygon.iter().for_each(&mut reach);
        }
        (from_m <= to_m).then_some([from_m, to_m])
    }
}

/// The part of a polygon at most `limit_m` along `way`.
fn clip(polygon: &[DVec3], way: DVec3, limit_m: f64, clipped: &mut Vec<DVec3>) {
    clipped.clear();
    for (k, &here) in polygon.iter().enumerate() {
        let next = polygon[(k + 1) % polygon.len()];
        let (beyond, next_beyond) = (way.dot(here) - limit_m, way.dot(next) - limit_m);
        if beyond <= 0.0 {
            clipped.push(here);
        }
        if (beyond < 0.0 && next_beyond > 0.0) || (beyond > 0.0 && next_beyond < 0.0) {
            clipped.push(here + beyond / (beyond - next_beyond) * (next - here));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::convex_hull::convex_hull;
    use crate::shapes::{block, cylinder};

    fn spans(hulls: &[ConvexHull], height_m: [f64; 2], across_m: f64) -> Vec<[f64; 2]> {
        let parts: Vec<Part> = hulls.iter().map(Part::of).collect();
        let hand = Hand::new(DVec3::X, DVec3::Z);
        let column = Column { point_m: across_m * hand.across, half_width_m: 0.01 };
        hand.spans(&parts, &column, height_m)
    }

    #[test]
    fn spans_are_what_lies_in_the_column() {
        let hull = |solid: crate::Solid| convex_hull(&solid.positions, 256, 0.0).expect("a volume");
        let cube = |x: f64| hull(block(DVec3::splat(0.04)).translated(DVec3::new(x, 0.0, 0.0)));
        let near = |found: Vec<[f64; 2]>, expected: &[[f64; 2]]| {
            assert_eq!(found.len(), expected.len(), "{found:?}");
            for (found, expected) in found.iter().flatten().zip(expected.iter().flatten()) {
                assert!((found - expected).abs() < 1e-9, "{found} is not {expected}");
            }
        };
        let two = [cube(0.1), cube(0.0)];
        near(spans(&two, [0.01, 0.02], 0.0), &[[-0.02, 0.02], [0.08, 0.12]]);
        near(spans(&two, [0.01, f64::INFINITY], 0.025), &[[-0.02, 0.02], [0.08, 0.12]]);
        near(spans(&two, [0.05, f64::INFINITY], 0.0), &[]);
        near(spans(&two, [0.01, 0.02], 0.035), &[]);
        near(spans(&[cube(0.0), cube(0.04)], [0.0, 0.01], 0.0), &[[-0.02, 0.06]]);
        // A column beside the center of a can meets less of it; one wider than the hull meets all.
        let can = [hull(cylinder(0.05, 0.1, 0.0, 256))];
        let [[from, to]] = spans(&can, [0.02, 0.03], 0.03)[..] else { panic!("one interval") };
        let half = (0.05_f64.powi(2) - 0.02_f64.powi(2)).sqrt();
        assert!((to - half).abs() < 2e-4 && (from + half).abs() < 2e-4, "{from} {to}");
    }

    /// [`Hand::span`] with every triangle clipped against every limit.
    fn slow_span(hand: &Hand, hull: &ConvexHull, limits: &[(DVec3, f64); 4]) -> Option<[f64; 2]> {
        let mut ends: Option<[f64; 2]> = None;
        for triangle in &hull.triangles {
            let mut polygon: Vec<DVec3> =
                triangle.iter().map(|corner| hull.points[*corner as usize]).collect();
            let mut clipped = Vec::new();
            for &(way, limit_m) in limits.iter().filter(|(_, limit_m)| limit_m.is_finite()) {
                clip(&polygon, way, limit_m, &mut clipped);
                std::mem::swap(&mut polygon, &mut clipped);
            }
            for along_m in polygon.iter().map(|p| p.dot(hand.closing)) {
                let [from, to] = ends.unwrap_or([along_m; 2]);
                ends = Some([from.min(along_m), to.max(along_m)]);
            }
        }
        ends
    }

    #[test]
    fn span_equals_that_of_all_triangles_clipped() {
        let hull = convex_hull(&cylinder(0.05, 0.1, 0.004, 24).positions, 256, 0.0).expect("a volume");
        let mut found = 0;
        for k in 0..240 {
            let turn = f64::from(k) * 0.37;
            let hand = Hand::new(DVec3::new(turn.cos(), turn.sin(), 0.0), DVec3::Z);
            let (across_m, low_m) = (0.08 * (turn * 1.7).sin(), 0.12 * (turn * 0.9).sin());
            let half_m = 0.002 + 0.03 * (turn * 0.3).cos().abs();
            let high_m = if k % 3 == 0 { f64::INFINITY } else { low_m + 0.02 };
            let limits = [
                (hand.across, across_m + half_m),
                (-hand.across, half_m - across_m),
                (hand.up, high_m),
                (-hand.up, -low_m),
            ];
            let span = hand.span(&hull, &limits);
            assert_eq!(span, slow_span(&hand, &hull, &limits), "{k}");
            found += usize::from(span.is_some());
        }
        assert!((60..240).contains(&found), "{found} of 240 columns meet the can");
    }

    #[test]
    fn tips_stay_above_the_floor() {
        let upright = Hand::new(DVec3::X, DVec3::Z);
        let low = DVec3::new(0.0, 0.0, 0.004);
        assert_eq!(upright.tip_above(low, -0.004, 0.09, 0.02, 0.0), Some(0.0));
        assert_eq!(upright.tip_above(low, 0.001, 0.09, 0.02, 0.0), Some(0.001));
        // A hand from the side cannot go lower than half its finger's width.
        let sideways = Hand::new(DVec3::X, DVec3::Y);
        assert_eq!(sideways.tip_above(low, -0.01, 0.09, 0.02, 0.0), None);
        assert_eq!(sideways.tip_above(low.with_z(0.02), -0.01, 0.09, 0.02, 0.0), Some(-0.01));
    }
}
