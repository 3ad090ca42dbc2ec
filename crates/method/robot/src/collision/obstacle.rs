//! Solids that an arm must not touch, with their exact distances.

use nalgebra::{Isometry3, Point3, Vector3};

use super::polyhedron::ConvexPolyhedron;

/// A solid at a fixed place.
#[derive(Clone, Debug, PartialEq)]
pub struct Obstacle {
    solid: Solid,
    base_from_solid: Isometry3<f64>,
    /// The least and greatest corner of the axis-aligned box around it, in the frame of the base.
    bounds_m: (Vector3<f64>, Vector3<f64>),
}

/// A solid in its own frame: the origin is at its center, and a cylinder or capsule is along z.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Solid {
    Sphere { radius_m: f64 },
    Cuboid { half_extents_m: Vector3<f64> },
    Cylinder { radius_m: f64, half_length_m: f64 },
    Capsule { radius_m: f64, half_length_m: f64 },
    Hull(ConvexPolyhedron),
}

/// A solid with a length or a place that it cannot have.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("the {what} of an obstacle is {value}; it must be {must_be}")]
pub struct ObstacleError {
    what: &'static str,
    value: String,
    must_be: &'static str,
}

impl Obstacle {
    pub fn sphere(center_m: Point3<f64>, radius_m: f64) -> Result<Self, ObstacleError> {
        length("radius", radius_m)?;
        Self::placed(Solid::Sphere { radius_m }, Isometry3::translation(center_m.x, center_m.y, center_m.z))
    }

    /// A box from half its edges.
    pub fn cuboid(
        base_from_solid: Isometry3<f64>,
        half_extents_m: Vector3<f64>,
    ) -> Result<Self, ObstacleError> {
        half_extents_m.iter().try_for_each(|&half_m| length("half extent", half_m))?;
        Self::placed(Solid::Cuboid { half_extents_m }, base_from_solid)
    }

    /// A cylinder along z of its own frame.
    pub fn cylinder(
        base_from_solid: Isometry3<f64>,
        radius_m: f64,
        half_length_m: f64,
    ) -> Result<Self, ObstacleError> {
        length("radius", radius_m)?;
        length("half length", half_length_m)?;
        Self::placed(Solid::Cylinder { radius_m, half_length_m }, base_from_solid)
    }

    /// All points within `radius_m` of a segment along z of its own frame, `half_length_m` each way from its origin.
    pub fn capsule(
        base_from_solid: Isometry3<f64>,
        radius_m: f64,
        half_length_m: f64,
    ) -> Result<Self, ObstacleError> {
        length("radius", radius_m)?;
        length("half length", half_length_m)?;
        Self::placed(Solid::Capsule { radius_m, half_length_m }, base_from_solid)
    }

    pub fn hull(base_from_solid: Isometry3<f64>, hull: ConvexPolyhedron) -> Result<Self, ObstacleError> {
        Self::placed(Solid::Hull(hull), base_from_solid)
    }

    fn placed(solid: Solid, base_from_solid: Isometry3<f64>) -> Result<Self, ObstacleError> {
        let finite = base_from_solid.to_homogeneous().iter().all(|entry| entry.is_finite());
        if !finite {
            let value = base_from_solid.to_string();
            return Err(ObstacleError { what: "place", value, must_be: "finite" });
        }
        let bounds_m = solid.bounds_m(&base_from_solid);
        Ok(Self { solid, base_from_solid, bounds_m })
    }

    pub(super) fn solid(&self) -> &Solid {
        &self.solid
    }

    pub fn base_from_solid(&self) -> &Isometry3<f64> {
        &self.base_from_solid
    }

    /// The distance from a point of the base's frame to the surface, negative inside.
    pub fn signed_distance_m(&self, point_in_base: &Point3<f64>) -> f64 {
        let point = self.base_from_solid.inverse_transform_point(point_in_base);
        let outside_and_inside = |excess_m: &[f64]| {
            let outside_m = excess_m.iter().map(|e| e.max(0.0).powi(2)).sum::<f64>().sqrt();
            outside_m + excess_m.iter().copied().fold(f64::NEG_INFINITY, f64::max).min(0.0)
        };
        match &self.solid {
            Solid::Sphere { radius_m } => point.coords.norm() - radius_m,
            Solid::Cuboid { half_extents_m } => {
                outside_and_inside((point.coords.abs() - half_extents_m).as_slice())
            }
            Solid::Cylinder { radius_m, half_length_m } => {
                outside_and_inside(&[point.x.hypot(point.y) - radius_m, point.z.abs() - half_length_m])
            }
            Solid::Capsule { radius_m, half_length_m } => {
                let along_m = point.z.clamp(-half_length_m, *half_length_m);
                (point.coords - Vector3::z() * along_m).norm() - radius_m
            }
            Solid::Hull(hull) => hull.signed_distance_m(&point),
        }
    }

    /// The least and greatest corner of the axis-aligned box around it, in the frame of the base.
    pub fn bounds_m(&self) -> (Vector3<f64>, Vector3<f64>) {
        self.bounds_m
    }

    /// A bound below [`Self::signed_distance_m`] from a box: the distance to the box around the solid, or minus
    /// infinity within that box.
    pub fn min_distance_m(&self, point_in_base: &Point3<f64>) -> f64 {
        let (low, high) = &self.bounds_m;
        let outside = (low - point_in_base.coords).sup(&(point_in_base.coords - high)).sup(&Vector3::zeros());
        let distance_m = outside.norm();
        if distance_m > 0.0 { distance_m } else { f64::NEG_INFINITY }
    }
}

impl Solid {
    /// The least and greatest corner of the axis-aligned box around a solid at a pose, in the frame of that pose.
    fn bounds_m(&self, pose: &Isometry3<f64>) -> (Vector3<f64>, Vector3<f64>) {
        let center = pose.translation.vector;
        let rotation = pose.rotation.to_rotation_matrix();
        let reach: Vector3<f64> = match self {
            Self::Sphere { radius_m } => Vector3::repeat(*radius_m),
            Self::Cuboid { half_extents_m } => rotation.matrix().abs() * half_extents_m,
            Self::Cylinder { radius_m, half_length_m } => {
                let axis = rotation * Vector3::z();
                axis.map(|along| {
                    along.abs() * half_length_m + radius_m * (1.0 - along * along).max(0.0).sqrt()
                })
            }
            Self::Capsule { radius_m, half_length_m } => {
                (rotation * Vector3::z()).abs() * *half_length_m + Vector3::repeat(*radius_m)
            }
            Self::Hull(hull) => {
                let placed = || hull.points_m().iter().map(|point| (pose * point).coords);
                let low = placed().fold(Vector3::repeat(f64::INFINITY), |low, point| low.inf(&point));
                let high = placed().fold(Vector3::repeat(f64::NEG_INFINITY), |high, point| high.sup(&point));
                return (low, high);
            }
        };
        (center - reach, center + reach)
    }
}

/// Refuses what is not a length above zero.
fn length(what: &'static str, length_m: f64) -> Result<(), ObstacleError> {
    if length_m > 0.0 && length_m.is_finite() {
        Ok(())
    } else {
        Err(ObstacleError { what, value: format!("{length_m} m"), must_be: "finite and greater than 0" })
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_2;

    use super::*;

    /// A pose that puts z of the solid along y of the base, one meter up.
    fn lying() -> Isometry3<f64> {
        Isometry3::new(Vector3::new(0.0, 0.0, 1.0), Vector3::new(-FRAC_PI_2, 0.0, 0.0))
    }

    #[test]
    fn distances_to_each_solid() {
        let cuboid = Obstacle::cuboid(lying(), Vector3::new(0.1, 0.2, 0.3)).expect("a box");
        let cylinder = Obstacle::cylinder(lying(), 0.1, 0.3).expect("a cylinder");
        let capsule = Obstacle::capsule(lying(), 0.1, 0.3).expect("a capsule");
        let sphere = Obstacle::sphere(Point3::new(0.0, 0.0, 1.0), 0.1).expect("a sphere");
        for (solid, point, expected_m) in [
            (&cuboid, [0.4, 0.7, 1.2], 0.5),
            (&cuboid, [0.05, 0.0, 1.0], -0.05),
            (&cylinder, [0.4, 0.7, 1.0], 0.5),
            (&cylinder, [0.0, 0.28, 1.0], -0.02),
            (&capsule, [0.3, 0.7, 1.0], 0.4),
            (&capsule, [0.0, 0.0, 1.05], -0.05),
            (&sphere, [0.3, 0.4, 1.0], 0.4),
        ] {
            let distance_m = solid.signed_distance_m(&Point3::from(point));
            assert!(
                (distance_m - expected_m).abs() < 1e-12,
                "{solid:?} {point:?}: {distance_m}, not {expected_m}"
            );
        }
    }

    #[test]
    fn bounds_enclose_and_touch() {
        let cylinder = Obstacle::cylinder(lying(), 0.1, 0.3).expect("a cylinder");
        let (low, high) = cylinder.bounds_m();
        assert!((low - Vector3::new(-0.1, -0.3, 0.9)).norm() < 1e-9, "{low}");
        assert!((high - Vector3::new(0.1, 0.3, 1.1)).norm() < 1e-9, "{high}");
    }

    #[test]
    fn lengths_that_no_solid_has_are_refused() {
        for radius_m in [0.0, -0.1, f64::NAN, f64::INFINITY] {
            assert!(Obstacle::sphere(Point3::origin(), radius_m).is_err());
        }
        assert!(Obstacle::sphere(Point3::new(f64::NAN, 0.0, 0.0), 0.1).is_err());
    }
}
