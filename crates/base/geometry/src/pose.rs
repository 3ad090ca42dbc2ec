//! Rigid transforms between frames.

use glam::{DQuat, DVec3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// `parent_from_child`: maps a point given in the child frame to the parent frame by
/// `rotation * point + translation_m`. Variables are named `world_from_object`, so that in a chain
/// `camera_from_world * world_from_object` equal names are adjacent.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(
    description = "A position and an orientation; meters, and a unit quaternion with the real part last."
)]
pub struct Pose {
    /// Origin of the child frame in the parent frame, meters.
    #[schemars(with = "[f64; 3]", inner(range(min = -1000.0, max = 1000.0)))]
    pub translation_m: DVec3,
    /// Unit quaternion, stored x, y, z, w.
    #[serde(rename = "rotation_xyzw")]
    #[schemars(with = "[f64; 4]", inner(range(min = -1.000001, max = 1.000001)))]
    pub rotation: DQuat,
}

impl Pose {
    /// The identity.
    pub const IDENTITY: Pose = Pose { translation_m: DVec3::ZERO, rotation: DQuat::IDENTITY };

    /// Pose of an upright object: rotated by `yaw_rad` about +z, its origin at `translation_m`.
    pub fn upright(translation_m: DVec3, yaw_rad: f64) -> Self {
        Self { translation_m, rotation: DQuat::from_rotation_z(yaw_rad) }
    }

    /// The point in the parent frame.
    pub fn transform_point(&self, point_in_child: DVec3) -> DVec3 {
        self.rotation * point_in_child + self.translation_m
    }

    /// The direction in the parent frame (no translation).
    pub fn transform_vector(&self, vector_in_child: DVec3) -> DVec3 {
        self.rotation * vector_in_child
    }

    /// `child_from_parent`.
    pub fn inverse(&self) -> Self {
        let rotation = self.rotation.conjugate();
        Self { translation_m: rotation * -self.translation_m, rotation }
    }

    /// Twist of the rotation about the parent's +z in (-pi, pi], or `None` within 10 degrees of the
    /// poses where +z points down and the yaw is undefined.
    pub fn yaw_rad(&self) -> Option<f64> {
        let tilt_rad = (self.rotation * DVec3::Z).angle_between(DVec3::Z);
        if tilt_rad > std::f64::consts::PI - 10_f64.to_radians() {
            return None;
        }
        let twist_rad = 2.0 * self.rotation.z.atan2(self.rotation.w);
        Some(wrap_angle_rad(twist_rad))
    }
}

impl std::ops::Mul for Pose {
    type Output = Pose;
    fn mul(self, b: Pose) -> Pose {
        Pose {
            translation_m: self.transform_point(b.translation_m),
            rotation: (self.rotation * b.rotation).normalize(),
        }
    }
}

/// The same angle in (-pi, pi].
pub fn wrap_angle_rad(angle_rad: f64) -> f64 {
    let turned = angle_rad.rem_euclid(std::f64::consts::TAU);
    if turned > std::f64::consts::PI { turned - std::f64::consts::TAU } else { turned }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn yaw_of_a_tilted_pose_is_its_twist() {
        let tilt = DQuat::from_axis_angle(DVec3::new(1.0, 2.0, 0.0).normalize(), 0.4);
        let pose = Pose { translation_m: DVec3::ZERO, rotation: tilt * DQuat::from_rotation_z(0.7) };
        assert!((pose.yaw_rad().expect("far from singular") - 0.7).abs() < 0.1);
        let over = Pose { translation_m: DVec3::ZERO, rotation: DQuat::from_rotation_x(3.1) };
        assert_eq!(over.yaw_rad(), None);
    }

    proptest! {
        #[test]
        fn inverse_undoes_the_pose(x in -1.0..1.0_f64, y in -1.0..1.0_f64, yaw in -3.0..3.0_f64, tilt in -1.5..1.5_f64) {
            let pose = Pose {
                translation_m: DVec3::new(x, y, x * y),
                rotation: DQuat::from_rotation_z(yaw) * DQuat::from_rotation_x(tilt),
            };
            let point = DVec3::new(0.3, -0.2, 0.9);
            let back = (pose.inverse() * pose).transform_point(point);
            prop_assert!((back - point).length() < 1e-12);
        }
    }
}
