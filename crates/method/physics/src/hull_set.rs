//! The convex hulls of one body as one shape of the simulation.
//!
//! [`super::contacts`] computes contacts from the set. Bounding boxes and mass come from here. Ray casts, which the
//! simulation does not use, go to parry's compound shape. Object frame, meters.

use std::sync::Arc;

use glam::DVec3;
use rapier3d_f64::math::Pose as ParryPose;
use rapier3d_f64::parry::bounding_volume::{Aabb, BoundingSphere, BoundingVolume};
use rapier3d_f64::parry::mass_properties::MassProperties;
use rapier3d_f64::parry::query::{PointProjection, PointQuery, Ray, RayCast, RayIntersection};
use rapier3d_f64::parry::shape::{FeatureId, Shape, ShapeType, TypedShape};

use geometry::ConvexHull;
use geometry::contact_hull::ContactHull;
use geometry::contact_patch::{ContactPatch, contact_patch};

/// Hulls that move together.
#[derive(Clone)]
pub struct HullSet {
    pub hulls: Arc<[ContactHull]>,
    bounds: Aabb,
}

impl HullSet {
    pub fn new(hulls: &[ConvexHull]) -> Self {
        let hulls: Arc<[ContactHull]> = hulls.iter().map(ContactHull::new).collect();
        let (low, high) = hulls.iter().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), h| {
            (low.min(h.low), high.max(h.high))
        });
        Self { hulls, bounds: Aabb::new(low, high) }
    }

    /// Every contact patch with another set within `reach_m`, in this set's frame.
    pub fn patches(&self, other: &HullSet, self_from_other: &ParryPose, reach_m: f64) -> Vec<ContactPatch> {
        let near: Vec<(&ContactHull, Aabb)> = other
            .hulls
            .iter()
            .map(|hull| {
                (hull, Aabb::new(hull.low, hull.high).transform_by(self_from_other).loosened(reach_m))
            })
            .filter(|(_, bounds)| bounds.intersects(&self.bounds))
            .collect();
        let mut found = Vec::new();
        for part in self.hulls.iter() {
            let own = Aabb::new(part.low, part.high);
            for (hull, _) in near.iter().filter(|(_, bounds)| bounds.intersects(&own)) {
                found.extend(contact_patch(part, hull, self_from_other, reach_m, None));
            }
        }
        found
    }
}

impl Shape for HullSet {
    fn compute_local_aabb(&self) -> Aabb {
        self.bounds
    }

    fn compute_local_bounding_sphere(&self) -> BoundingSphere {
        let center = 0.5 * (self.bounds.mins + self.bounds.maxs);
        BoundingSphere::new(center, 0.5 * (self.bounds.maxs - self.bounds.mins).length())
    }

    fn clone_dyn(&self) -> Box<dyn Shape> {
        Box::new(self.clone())
    }

    fn scale_dyn(&self, _scale: DVec3, _subdivisions: u32) -> Option<Box<dyn Shape>> {
        None
    }

    /// The body brings its own mass.
    fn mass_properties(&self, _density: f64) -> MassProperties {
        MassProperties::default()
    }

    fn shape_type(&self) -> ShapeType {
        ShapeType::Custom
    }

    fn as_typed_shape(&self) -> TypedShape<'_> {
        TypedShape::Custom(self)
    }

    fn ccd_thickness(&self) -> f64 {
        (self.bounds.maxs - self.bounds.mins).min_element()
    }

    fn ccd_angular_thickness(&self) -> f64 {
        std::f64::consts::FRAC_PI_2
    }
}

// The simulation casts no rays and projects no points; the box answers for completeness.
impl RayCast for HullSet {
    fn cast_local_ray_and_get_normal(&self, ray: &Ray, longest: f64, solid: bool) -> Option<RayIntersection> {
        self.bounds.cast_local_ray_and_get_normal(ray, longest, solid)
    }
}

impl PointQuery for HullSet {
    fn project_local_point(&self, point: DVec3, solid: bool) -> PointProjection {
        self.bounds.project_local_point(point, solid)
    }

    fn project_local_point_and_get_feature(&self, point: DVec3) -> (PointProjection, FeatureId) {
        self.bounds.project_local_point_and_get_feature(point)
    }
}
