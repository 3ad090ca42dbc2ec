//! Numbers as text: the shortest decimals that parse to the same value, and poses in the forms of the formats.

use nalgebra::{Isometry3, Quaternion, UnitQuaternion};

/// The numbers with spaces between them, without "-0".
pub(super) fn spaced(values: &[f64]) -> String {
    joined(values, " ")
}

/// The numbers as a tuple of USD.
pub(super) fn tuple(values: &[f64]) -> String {
    format!("({})", joined(values, ", "))
}

fn joined(values: &[f64], between: &str) -> String {
    values.iter().map(|value| (value + 0.0).to_string()).collect::<Vec<_>>().join(between)
}

pub(super) fn xyz(pose: &Isometry3<f64>) -> [f64; 3] {
    pose.translation.vector.into()
}

/// Turns about the fixed axes x, y and z, in this order, in radians.
pub(super) fn rpy(pose: &Isometry3<f64>) -> [f64; 3] {
    let (roll, pitch, yaw) = pose.rotation.euler_angles();
    [roll, pitch, yaw]
}

/// The quaternion with its real part first, which is not negative.
pub(super) fn wxyz(rotation: &UnitQuaternion<f64>) -> [f64; 4] {
    let Quaternion { coords } = rotation.quaternion();
    let sign = if coords.w < 0.0 { -1.0 } else { 1.0 };
    [coords.w, coords.x, coords.y, coords.z].map(|c| sign * c)
}

#[cfg(test)]
mod tests {
    use nalgebra::{Isometry3, UnitQuaternion, Vector3};

    use super::*;

    #[test]
    fn numbers_parse_to_the_same_value_and_have_no_negative_zero() {
        assert_eq!(spaced(&[0.1, -0.0, 2.0]), "0.1 0 2");
        assert_eq!(tuple(&[1.5, -2.0]), "(1.5, -2)");
        let third = 1.0 / 3.0;
        assert_eq!(spaced(&[third]).parse(), Ok(third));
    }

    #[test]
    fn poses_take_the_forms_of_the_formats() {
        let turn = UnitQuaternion::from_euler_angles(0.1, -0.2, 0.3);
        let pose = Isometry3::from_parts(Vector3::new(1.0, 2.0, 3.0).into(), turn);
        assert_eq!(xyz(&pose), [1.0, 2.0, 3.0]);
        for (computed, expected) in rpy(&pose).iter().zip([0.1, -0.2, 0.3]) {
            assert!((computed - expected).abs() < 1e-12);
        }
        let quarter = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), -std::f64::consts::FRAC_PI_2);
        let half = std::f64::consts::FRAC_1_SQRT_2;
        for (computed, expected) in wxyz(&quarter).iter().zip([half, 0.0, 0.0, -half]) {
            assert!((computed - expected).abs() < 1e-12);
        }
    }
}
