//! The primitives that links consist of: boxes, cylinders, capsules and spheres, with volume and inertia.

use nalgebra::{Isometry3, Matrix3, Point3, Rotation3, Translation3, UnitQuaternion, Vector3};

/// A primitive about the origin of its own frame; cylinders and capsules lie along z.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Primitive {
    Box {
        half_size_m: Vector3<f64>,
    },
    Cylinder {
        radius_m: f64,
        half_length_m: f64,
    },
    /// `half_length_m` is half the distance between the centers of the round ends.
    Capsule {
        radius_m: f64,
        half_length_m: f64,
    },
    Sphere {
        radius_m: f64,
    },
}

/// Use of a shape.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ShapeRole {
    /// Rendering and collision.
    Both,
    Visual,
    Collision,
}

/// A primitive that is fixed to a link.
#[derive(Clone, Debug, PartialEq)]
pub struct Shape {
    pub primitive: Primitive,
    pub link_from_shape: Isometry3<f64>,
    /// The index of its material in `Robot::materials`.
    pub material: usize,
    pub role: ShapeRole,
    /// Whether it is where a finger touches what it holds.
    pub is_pad: bool,
}

impl Shape {
    pub fn collides(&self) -> bool {
        self.role != ShapeRole::Visual
    }

    pub fn is_visible(&self) -> bool {
        self.role != ShapeRole::Collision
    }
}

impl Primitive {
    /// Computes the volume in cubic meters.
    pub fn volume_m3(&self) -> f64 {
        use std::f64::consts::PI;
        match *self {
            Self::Box { half_size_m: h } => 8.0 * h.x * h.y * h.z,
            Self::Cylinder { radius_m: r, half_length_m: l } => PI * r * r * 2.0 * l,
            Self::Capsule { radius_m: r, half_length_m: l } => PI * r * r * (2.0 * l + 4.0 / 3.0 * r),
            Self::Sphere { radius_m: r } => 4.0 / 3.0 * PI * r.powi(3),
        }
    }

    /// Computes the second moments of the volume about the center, divided by the volume: the diagonal of the inertia
    /// tensor of one kilogram, in square meters. The axes of the primitive are principal axes.
    pub fn inertia_per_kg_m2(&self) -> Vector3<f64> {
        let round = |along: f64, across: f64| Vector3::new(across, across, along);
        match *self {
            Self::Box { half_size_m: h } => {
                let s = h.component_mul(&h);
                Vector3::new(s.y + s.z, s.x + s.z, s.x + s.y) / 3.0
            }
            Self::Cylinder { radius_m: r, half_length_m: l } => {
                round(0.5 * r * r, 0.25 * r * r + l * l / 3.0)
            }
            Self::Capsule { radius_m: r, half_length_m: l } => {
                let (tube, ball) = (2.0 * l, 4.0 / 3.0 * r);
                let (tube, ball) = (tube / (tube + ball), ball / (tube + ball));
                let tube_across = 0.25 * r * r + l * l / 3.0;
                // Each end is half a ball, whose center of mass is 3/8 of the radius beyond the end of the tube.
                let ball_across = 0.4 * r * r + l * l + 0.75 * l * r;
                round(tube * 0.5 * r * r + ball * 0.4 * r * r, tube * tube_across + ball * ball_across)
            }
            Self::Sphere { radius_m: r } => Vector3::repeat(0.4 * r * r),
        }
    }

    /// Computes the distance from `point` to the surface in meters, negative inside; exact for all four.
    pub fn signed_distance_m(&self, point: &Point3<f64>) -> f64 {
        let beyond = |excess: &[f64]| {
            let outside = excess.iter().map(|e| e.max(0.0).powi(2)).sum::<f64>().sqrt();
            outside + excess.iter().copied().fold(f64::NEG_INFINITY, f64::max).min(0.0)
        };
        let radial = point.x.hypot(point.y);
        match *self {
            Self::Box { half_size_m: h } => {
                let excess = point.coords.abs() - h;
                beyond(excess.as_slice())
            }
            Self::Cylinder { radius_m, half_length_m } => {
                beyond(&[radial - radius_m, point.z.abs() - half_length_m])
            }
            Self::Capsule { radius_m, half_length_m } => {
                radial.hypot((point.z.abs() - half_length_m).max(0.0)) - radius_m
            }
            Self::Sphere { radius_m } => point.coords.norm() - radius_m,
        }
    }

    /// Computes half the size of the smallest box along the primitive's axes that encloses it.
    pub fn half_extents_m(&self) -> Vector3<f64> {
        match *self {
            Self::Box { half_size_m } => half_size_m,
            Self::Cylinder { radius_m: r, half_length_m: l } => Vector3::new(r, r, l),
            Self::Capsule { radius_m: r, half_length_m: l } => Vector3::new(r, r, l + r),
            Self::Sphere { radius_m } => Vector3::repeat(radius_m),
        }
    }
}

/// Computes the frame of a cylinder or capsule from the ends of its axis, and half its length.
///
/// Where the axis is parallel to an axis of the link, so are the other two: files stay readable.
pub(super) fn frame_along(from: Vector3<f64>, to: Vector3<f64>) -> (Isometry3<f64>, f64) {
    let along = to - from;
    let turn = UnitQuaternion::rotation_between(&Vector3::z(), &along)
        .unwrap_or_else(|| UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI));
    (Isometry3::from_parts(Translation3::from((from + to) / 2.0), turn), along.norm() / 2.0)
}

/// Computes the center of mass and the inertia tensor about it of solids of one density that together weigh `mass_kg`.
/// Where solids overlap, the overlap counts twice. `None` where nothing has a volume.
pub(super) fn solid_inertia<'a>(
    shapes: impl Iterator<Item = &'a Shape> + Clone,
    mass_kg: f64,
) -> Option<(Vector3<f64>, Matrix3<f64>)> {
    let volume: f64 = shapes.clone().map(|shape| shape.primitive.volume_m3()).sum();
    if volume <= 0.0 {
        return None;
    }
    let mass = |shape: &Shape| mass_kg * shape.primitive.volume_m3() / volume;
    let center: Vector3<f64> =
        shapes.clone().map(|s| s.link_from_shape.translation.vector * (mass(s) / mass_kg)).sum();
    let tensor = shapes.map(|shape| {
        let turn: Rotation3<f64> = shape.link_from_shape.rotation.to_rotation_matrix();
        let own = Matrix3::from_diagonal(&shape.primitive.inertia_per_kg_m2());
        let arm = shape.link_from_shape.translation.vector - center;
        let moved = Matrix3::identity() * arm.norm_squared() - arm * arm.transpose();
        (turn.matrix() * own * turn.matrix().transpose() + moved) * mass(shape)
    });
    Some((center, tensor.sum()))
}

#[cfg(test)]
mod tests;
