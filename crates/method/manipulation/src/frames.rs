//! Poses of the three libraries of linear algebra that meet here.

use geometry::{DQuat, DVec3, Pose};
use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion, Vector3};

/// The pose of `nalgebra` as one of `geometry`.
pub fn to_pose(pose: &Isometry3<f64>) -> Pose {
    let q = pose.rotation.quaternion();
    Pose {
        translation_m: to_vector(&pose.translation.vector),
        rotation: DQuat::from_xyzw(q.i, q.j, q.k, q.w),
    }
}

/// The pose of `geometry` as one of `nalgebra`.
pub fn to_isometry(pose: &Pose) -> Isometry3<f64> {
    let DQuat { x, y, z, w } = pose.rotation;
    let rotation = UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z));
    Isometry3::from_parts(Translation3::from(from_vector(pose.translation_m)), rotation)
}

/// The vector of `nalgebra` as one of `glam`.
pub fn to_vector(vector: &Vector3<f64>) -> DVec3 {
    DVec3::new(vector.x, vector.y, vector.z)
}

/// The vector of `glam` as one of `nalgebra`.
pub fn from_vector(vector: DVec3) -> Vector3<f64> {
    Vector3::new(vector.x, vector.y, vector.z)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn poses_move_points_alike() {
        let pose = Pose {
            translation_m: DVec3::new(0.1, -0.2, 0.3),
            rotation: DQuat::from_rotation_z(0.4) * DQuat::from_rotation_x(1.1),
        };
        let point = DVec3::new(0.5, 0.6, -0.7);
        let moved = to_isometry(&pose) * nalgebra::Point3::from(from_vector(point));
        assert!((to_vector(&moved.coords) - pose.transform_point(point)).length() < 1e-12);
        let back = to_pose(&to_isometry(&pose));
        assert!((back.transform_point(point) - pose.transform_point(point)).length() < 1e-12);
    }
}
