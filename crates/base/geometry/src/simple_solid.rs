//! Boxes, cylinders, spheres and capsules among convex hulls.
//!
//! Engines compute exact contacts of these shapes, and fast; contacts of their hulls creep, and stacks of them fall in
//! some versions. [`SimpleSolid::of_hull`] recognizes a hull whose corners lie on such a solid and whose facets are
//! nowhere far inside. [`SimpleSolid::rounding`] finds the box or cylinder whose edges a hull has rounded; its own hull
//! ([`SimpleSolid::hull`]) then takes the place of the rounded one, so that every engine has the same shape.
//!
//! Candidates come from the hull's largest facets; a candidate counts only if it passes the tests. Object frame,
//! meters.

mod candidates;

use std::f64::consts::{PI, TAU};

use glam::{DVec2, DVec3};

use self::candidates::{Facet, candidates, facets};
use crate::convex_hull::convex_hull;
use crate::{ConvexHull, Pose};

/// Largest distance of a hull's corner from the solid's surface, meters.
const ON_SURFACE_M: f64 = 2e-5;
/// The hull holds the solid made smaller by this share: a prism of 16 sides (1.9 percent inside its circle) is round,
/// at any size and length; one of 12 sides (3.4 percent) rests on its sides.
const FACET_SHARE: f64 = 0.02;
/// Maximum distance by which the solid may stick out of the hull's facets, meters.
const FACET_M: f64 = 1e-3;
/// Maximum distance by which a squared edge may stick out, as a share of the smallest radius or half side: an eighth of
/// a coin's thickness.
const EDGE_SHARE: f64 = 0.25;
/// The hull has at least this share of the solid's volume; corners of a polygon of 32 sides cost 0.6 percent.
const MIN_VOLUME_SHARE: f64 = 0.95;
/// A face counts where a facet of the hull covers this share of it: what is tapered has no such faces.
const MIN_FACE_SHARE: f64 = 0.6;
/// A cylinder's side counts where the hull touches it along this share of its length: rims rounded by a quarter of a
/// coin's thickness leave half; what is tapered or bulges touches along a ring.
const MIN_SIDE_SHARE: f64 = 0.4;
/// Largest cosine between a cylinder's axis and the normal of a facet of its side.
const ON_SIDE: f64 = 0.01;
/// Hulls of more triangles are not tested: roundings of simple solids have hundreds.
const MAX_TRIANGLES: usize = 4096;

/// A box, cylinder, sphere or capsule in the object's frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SimpleSolid {
    pub kind: SimpleSolidKind,
    /// The solid's center and axes; the axis of what is round is z.
    pub object_from_solid: Pose,
}

/// Kind and measures, meters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SimpleSolidKind {
    Box {
        half_m: DVec3,
    },
    Cylinder {
        radius_m: f64,
        half_length_m: f64,
    },
    Sphere {
        radius_m: f64,
    },
    /// The half length is that of the cylinder between the two half spheres.
    Capsule {
        radius_m: f64,
        half_length_m: f64,
    },
}

impl SimpleSolid {
    /// The solid whose corners and facets the hull has, within a fiftieth of a millimeter at its corners, and at its
    /// facets within 2 percent of each of its measures, at most 1 mm.
    pub fn of_hull(hull: &ConvexHull) -> Option<Self> {
        let facets = facets(hull);
        candidates(hull, &facets).into_iter().find(|solid| {
            hull.points.iter().all(|p| solid.distance_m(*p).abs() <= ON_SURFACE_M)
                && facets.iter().all(|facet| solid.is_reached_by(facet))
                && solid.is_filled_by(hull)
        })
    }

    /// The box or cylinder that the hull is but for rounded edges. The solid encloses the hull and sticks out of it by
    /// at most `excess_m` and a quarter of its smallest half measure; flat facets of the hull cover most of each of its
    /// faces, and a cylinder's side is round and touched along its length.
    pub fn rounding(hull: &ConvexHull, excess_m: f64) -> Option<Self> {
        if hull.triangles.len() > MAX_TRIANGLES {
            return None;
        }
        let facets = facets(hull);
        candidates(hull, &facets).into_iter().find(|solid| {
            let excess_m = excess_m.min(EDGE_SHARE * solid.half_size_m().min_element());
            let encloses = || hull.points.iter().all(|p| solid.distance_m(*p) <= ON_SURFACE_M);
            let touches = || {
                solid.faces().iter().all(|face| face.is_covered(&facets)) && solid.is_touched(hull, &facets)
            };
            matches!(solid.kind, SimpleSolidKind::Box { .. } | SimpleSolidKind::Cylinder { .. })
                && encloses()
                && touches()
                && solid.farthest_corner_m(&facets) <= excess_m
                && solid.is_filled_by(hull)
        })
    }

    /// Half extents along its own axes, meters.
    pub fn half_size_m(&self) -> DVec3 {
        match self.kind {
            SimpleSolidKind::Box { half_m } => half_m,
            SimpleSolidKind::Cylinder { radius_m, half_length_m } => {
                DVec3::new(radius_m, radius_m, half_length_m)
            }
            SimpleSolidKind::Sphere { radius_m } => DVec3::splat(radius_m),
            SimpleSolidKind::Capsule { radius_m, half_length_m } => {
                DVec3::new(radius_m, radius_m, radius_m + half_length_m)
            }
        }
    }

    /// Whether a facet of the hull is nowhere inside the solid made smaller about its center.
    fn is_reached_by(&self, facet: &Facet) -> bool {
        let reach_m = self.reach_m(facet.normal);
        let from_center_m = reach_m - facet.normal.dot(self.object_from_solid.translation_m);
        reach_m - facet.offset_m <= (FACET_SHARE * from_center_m).min(FACET_M)
    }

    /// Whether the hull's volume is nearly the solid's.
    fn is_filled_by(&self, hull: &ConvexHull) -> bool {
        hull.volume_m3() >= MIN_VOLUME_SHARE * self.volume_m3()
    }

    pub fn volume_m3(&self) -> f64 {
        match self.kind {
            SimpleSolidKind::Box { half_m } => 8.0 * half_m.element_product(),
            SimpleSolidKind::Cylinder { radius_m, half_length_m } => {
                TAU * radius_m * radius_m * half_length_m
            }
            SimpleSolidKind::Sphere { radius_m } => 4.0 / 3.0 * PI * radius_m.powi(3),
            SimpleSolidKind::Capsule { radius_m, half_length_m } => {
                TAU * radius_m * radius_m * half_length_m + 4.0 / 3.0 * PI * radius_m.powi(3)
            }
        }
    }

    /// Largest coordinate along a unit direction of the object's frame.
    fn reach_m(&self, direction: DVec3) -> f64 {
        let own = self.object_from_solid.rotation.inverse() * direction;
        let across = own.truncate().length();
        let reach_m = match self.kind {
            SimpleSolidKind::Box { half_m } => own.abs().dot(half_m),
            SimpleSolidKind::Cylinder { radius_m, half_length_m } => {
                across * radius_m + own.z.abs() * half_length_m
            }
            SimpleSolidKind::Sphere { radius_m } => radius_m,
            SimpleSolidKind::Capsule { radius_m, half_length_m } => radius_m + own.z.abs() * half_length_m,
        };
        reach_m + direction.dot(self.object_from_solid.translation_m)
    }

    /// Distance of a point of the object's frame above the surface; negative inside (then a bound of the depth).
    fn distance_m(&self, point: DVec3) -> f64 {
        let own = self.object_from_solid.inverse().transform_point(point);
        match self.kind {
            SimpleSolidKind::Box { half_m } => {
                let above = own.abs() - half_m;
                above.max(DVec3::ZERO).length() + above.max_element().min(0.0)
            }
            SimpleSolidKind::Cylinder { radius_m, half_length_m } => {
                let above = DVec2::new(own.truncate().length() - radius_m, own.z.abs() - half_length_m);
                above.max(DVec2::ZERO).length() + above.max_element().min(0.0)
            }
            SimpleSolidKind::Sphere { radius_m } => own.length() - radius_m,
            SimpleSolidKind::Capsule { radius_m, half_length_m } => {
                let along = own.z.clamp(-half_length_m, half_length_m);
                own.distance(along * DVec3::Z) - radius_m
            }
        }
    }

    /// The flat faces, in the object's frame.
    fn faces(&self) -> Vec<Face> {
        let axes = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| self.object_from_solid.rotation * axis);
        let both = |axis: DVec3, area_m2: f64| {
            [axis, -axis].map(|normal| Face { normal, offset_m: self.reach_m(normal), area_m2 })
        };
        match self.kind {
            SimpleSolidKind::Box { half_m: h } => [
                both(axes[0], 4.0 * h.y * h.z),
                both(axes[1], 4.0 * h.z * h.x),
                both(axes[2], 4.0 * h.x * h.y),
            ]
            .concat(),
            SimpleSolidKind::Cylinder { radius_m, .. } => both(axes[2], PI * radius_m * radius_m).to_vec(),
            SimpleSolidKind::Sphere { .. } | SimpleSolidKind::Capsule { .. } => Vec::new(),
        }
    }

    /// Whether the hull is round and touches a cylinder's side along its length; true of every other solid.
    fn is_touched(&self, hull: &ConvexHull, facets: &[Facet]) -> bool {
        let SimpleSolidKind::Cylinder { radius_m, half_length_m } = self.kind else { return true };
        let axis = self.object_from_solid.rotation * DVec3::Z;
        let mut sides = facets.iter().filter(|facet| facet.normal.dot(axis).abs() < ON_SIDE);
        if !sides.all(|side| self.is_reached_by(side)) {
            return false;
        }
        let solid_from_object = self.object_from_solid.inverse();
        let touching = hull.points.iter().map(|p| solid_from_object.transform_point(*p));
        let touching = touching.filter(|p| p.truncate().length() >= radius_m - ON_SURFACE_M);
        let (low, high) =
            touching.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), p| (low.min(p.z), high.max(p.z)));
        high - low >= MIN_SIDE_SHARE * 2.0 * half_length_m
    }

    /// Distance by which the solid's own corners lie above the hull's facets.
    fn farthest_corner_m(&self, facets: &[Facet]) -> f64 {
        let above = |corner: &DVec3| {
            let heights = facets.iter().map(|facet| facet.normal.dot(*corner) - facet.offset_m);
            heights.fold(f64::NEG_INFINITY, f64::max)
        };
        self.corners(ROUND_SIDES).iter().map(above).fold(0.0, f64::max)
    }

    /// The hull of the box, or of the cylinder with `sides` sides, whose first corner the solid's x axis has.
    pub fn hull(&self, sides: usize) -> Option<ConvexHull> {
        convex_hull(&self.corners(sides), usize::MAX, 0.0)
    }

    /// Corners of a box or of a prism in a cylinder; none of what is round everywhere.
    fn corners(&self, sides: usize) -> Vec<DVec3> {
        let own: Vec<DVec3> = match self.kind {
            SimpleSolidKind::Box { half_m } => (0..8)
                .map(|k| {
                    half_m
                        * DVec3::from_array([0, 1, 2].map(|bit| if k >> bit & 1 == 0 { -1.0 } else { 1.0 }))
                })
                .collect(),
            SimpleSolidKind::Cylinder { radius_m, half_length_m } => (0..2 * sides)
                .map(|k| {
                    let (sin, cos) = (TAU * (k / 2) as f64 / sides as f64).sin_cos();
                    let z = if k % 2 == 0 { -half_length_m } else { half_length_m };
                    DVec3::new(radius_m * cos, radius_m * sin, z)
                })
                .collect(),
            SimpleSolidKind::Sphere { .. } | SimpleSolidKind::Capsule { .. } => Vec::new(),
        };
        own.into_iter().map(|p| self.object_from_solid.transform_point(p)).collect()
    }
}

/// Corners around a cylinder that are tested.
const ROUND_SIDES: usize = 32;

/// A flat face of a solid: the plane `normal . x = offset_m`.
#[derive(Clone, Copy)]
struct Face {
    normal: DVec3,
    offset_m: f64,
    area_m2: f64,
}

impl Face {
    /// Whether facets in its plane cover most of it.
    fn is_covered(&self, facets: &[Facet]) -> bool {
        let in_plane = |facet: &&Facet| {
            facet.normal.dot(self.normal) > 1.0 - 1e-6
                && (facet.offset_m - self.offset_m).abs() <= ON_SURFACE_M
        };
        facets.iter().filter(in_plane).map(|facet| facet.area_m2).sum::<f64>()
            >= MIN_FACE_SHARE * self.area_m2
    }
}

#[cfg(test)]
mod tests;
