//! A convex hull prepared for contact queries: corners, merged face planes, box.
//!
//! Triangles of one facet share one plane, taken from the facet's largest triangle, so the noisy normals of slivers
//! have no effect. All corners are on or below every plane. Object frame, meters.

use glam::DVec3;
use parry3d_f64::shape::SupportMap;

use super::ConvexHull;

/// Largest 1 - cosine between normals of one facet (a tenth of a milliradian).
const SAME_FACET: f64 = 5e-9;

/// Smallest cosine between a direction and the normal of a facet that faces it (20 milliradians).
const FACES: f64 = 0.9998;

/// Largest distance of a facet's corners from its plane, meters.
const ON_FACET_M: f64 = 1e-6;

/// Corners and facet planes of a convex hull.
#[derive(Clone, Debug)]
pub struct ContactHull {
    pub points: Vec<DVec3>,
    pub planes: Vec<Plane>,
    pub low: DVec3,
    pub high: DVec3,
}

/// The half space `normal . x <= offset_m`, the normal unit and outward.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane {
    pub normal: DVec3,
    pub offset_m: f64,
}

impl ContactHull {
    pub fn new(hull: &ConvexHull) -> Self {
        let mut facets: Vec<(f64, DVec3)> = hull
            .triangles
            .iter()
            .filter_map(|t| {
                let [a, b, c] = t.map(|v| hull.points[v as usize]);
                let area = (b - a).cross(c - a);
                Some((area.length(), area.try_normalize()?))
            })
            .collect();
        facets.sort_by(|a, b| b.0.total_cmp(&a.0));
        let mut planes: Vec<Plane> = Vec::new();
        for (_, normal) in facets {
            if planes.iter().all(|plane| plane.normal.dot(normal) < 1.0 - SAME_FACET) {
                let offset_m = hull.points.iter().map(|p| normal.dot(*p)).fold(f64::NEG_INFINITY, f64::max);
                planes.push(Plane { normal, offset_m });
            }
        }
        let (low, high) = hull
            .points
            .iter()
            .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), &p| (low.min(p), high.max(p)));
        Self { points: hull.points.clone(), planes, low, high }
    }

    /// Corners of the facet whose normal is closest to the unit vector; empty if none is within [`FACES`].
    pub(crate) fn facet_facing(&self, direction: DVec3) -> Vec<DVec3> {
        let faces = |plane: &&Plane| plane.normal.dot(direction);
        match self.planes.iter().max_by(|a, b| faces(a).total_cmp(&faces(b))) {
            Some(plane) if faces(&plane) > FACES => {
                let on_it = |p: &&DVec3| plane.normal.dot(**p) > plane.offset_m - ON_FACET_M;
                self.points.iter().filter(on_it).copied().collect()
            }
            _ => Vec::new(),
        }
    }

    /// Largest extent along the unit vector.
    pub(crate) fn reach_along(&self, direction: DVec3) -> f64 {
        self.points.iter().map(|p| p.dot(direction)).fold(f64::NEG_INFINITY, f64::max)
    }
}

impl SupportMap for ContactHull {
    fn local_support_point(&self, direction: DVec3) -> DVec3 {
        let first = self.points.first().copied().unwrap_or(DVec3::ZERO);
        let mut best = (first.dot(direction), first);
        for &p in &self.points {
            let along = p.dot(direction);
            if along > best.0 {
                best = (along, p);
            }
        }
        best.1
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::convex_hull::convex_hull;
    use crate::shapes::{block, cylinder};

    #[test]
    fn contact_hull_merges_the_triangles_of_a_facet() {
        let block = convex_hull(&block(DVec3::new(0.2, 0.1, 0.05)).positions, 64, 0.001).expect("a block");
        assert_eq!(ContactHull::new(&block).planes.len(), 6);
        let can = convex_hull(&cylinder(0.03, 0.1, 0.002, 48).positions, 64, 0.001).expect("a can");
        let can = ContactHull::new(&can);
        assert_eq!(can.planes.iter().filter(|plane| plane.normal.z < -0.999).count(), 1);
        for plane in &can.planes {
            assert!(can.points.iter().all(|p| plane.normal.dot(*p) <= plane.offset_m));
        }
    }
}
