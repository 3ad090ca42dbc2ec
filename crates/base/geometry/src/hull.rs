//! A convex polyhedron: one piece of a collision geometry.

use glam::DVec3;
use serde::{Deserialize, Serialize};

/// Corners and outward triangles of a convex hull in the object's frame, meters.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ConvexHull {
    pub points: Vec<DVec3>,
    pub triangles: Vec<[u32; 3]>,
}

impl ConvexHull {
    /// Enclosed volume, m^3.
    pub fn volume_m3(&self) -> f64 {
        // About a corner: far from the origin of the frame, the tetrahedra would be large and cancel.
        let origin = self.points.first().copied().unwrap_or(DVec3::ZERO);
        self.triangles
            .iter()
            .map(|t| {
                let [a, b, c] = t.map(|v| self.points[v as usize] - origin);
                a.dot(b.cross(c)) / 6.0
            })
            .sum()
    }
}
