//! Convex solids that move straight, against convex hulls.

use geometry::contact_hull::ContactHull;
use geometry::{DVec3, Pose};
use parry3d_f64::math::Pose as ParryPose;
use parry3d_f64::query::details::{
    contact_support_map_support_map, intersection_test_support_map_support_map,
};
use parry3d_f64::shape::SupportMap;

/// The corners of a convex solid at the begin and at the end of a straight motion: their hull is all that it passes.
pub(crate) struct Swept {
    corners: Vec<DVec3>,
    low: DVec3,
    high: DVec3,
}

impl Swept {
    /// A solid, given by its corners, in `frame_from_solid`, and on its way from `offset` in its own frame to there.
    pub fn along(corners: &[DVec3], frame_from_solid: &Pose, offset: DVec3) -> Self {
        let end = corners.iter().map(|p| frame_from_solid.transform_point(*p));
        let begin = corners.iter().map(|p| frame_from_solid.transform_point(*p + offset));
        let moved = if offset == DVec3::ZERO { None } else { Some(begin) };
        let corners: Vec<DVec3> = end.chain(moved.into_iter().flatten()).collect();
        let start = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        let (low, high) = corners.iter().fold(start, |(low, high), p| (low.min(*p), high.max(*p)));
        Self { corners, low, high }
    }

    /// Whether it overlaps the hull, or comes nearer to it than `gap_m`.
    pub fn is_near(&self, hull: &ContactHull, frame_from_hull: &Pose, gap_m: f64) -> bool {
        let pose = ParryPose::from_parts(frame_from_hull.translation_m, frame_from_hull.rotation);
        let center = frame_from_hull.transform_point(0.5 * (hull.low + hull.high));
        let half = 0.5 * (hull.high - hull.low);
        let axes = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| (frame_from_hull.rotation * axis).abs());
        let reach = half.x * axes[0] + half.y * axes[1] + half.z * axes[2] + DVec3::splat(gap_m);
        if !(self.low.cmple(center + reach).all() && (center - reach).cmple(self.high).all()) {
            return false;
        }
        if gap_m > 0.0 {
            contact_support_map_support_map(&pose, self, hull, gap_m).is_some()
        } else {
            intersection_test_support_map_support_map(&pose, self, hull)
        }
    }
}

impl SupportMap for Swept {
    fn local_support_point(&self, direction: DVec3) -> DVec3 {
        let start = (f64::NEG_INFINITY, DVec3::ZERO);
        let best = self.corners.iter().fold(start, |best, p| {
            let along = p.dot(direction);
            if along > best.0 { (along, *p) } else { best }
        });
        best.1
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_scenes::{block, hull};

    #[test]
    fn what_is_passed_on_the_way_is_met() {
        let small = hull(&block(DVec3::splat(0.01)));
        let wall = ContactHull::new(&hull(&block(DVec3::new(0.01, 0.5, 0.5))));
        let at =
            |x: f64| Pose { translation_m: DVec3::new(x, 0.0, 0.1), rotation: geometry::DQuat::IDENTITY };
        let meets = |from: f64, way: f64, gap_m: f64| {
            Swept::along(&small.points, &at(from), DVec3::new(way, 0.0, 0.0)).is_near(
                &wall,
                &Pose::IDENTITY,
                gap_m,
            )
        };
        assert!(meets(-0.2, 0.4, 0.0) && !meets(-0.2, 0.15, 0.0) && !meets(-0.2, 0.0, 0.0));
        assert!(meets(-0.2, 0.18, 0.012) && !meets(-0.2, 0.18, 0.008));
    }
}
