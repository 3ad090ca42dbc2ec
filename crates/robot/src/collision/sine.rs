//! Sine and cosine of eight angles.

use std::f64::consts::PI;

use super::lanes::Lanes;

/// Adding and subtracting it rounds an `f32` below 2^22 to the nearest integer.
const ROUNDING_SHIFT: f32 = 12_582_912.0;
/// The upper bits of pi, so few that a small integer times it is exact.
const PI_UPPER: f32 = 3.140_625;
/// What is left of pi.
const PI_LOWER: f32 = (PI - PI_UPPER as f64) as f32;

/// Sine and cosine, each within 4e-7 for angles up to 30 rad.
///
/// The angle is reduced to a half turn around zero, where Taylor's polynomials of degree 11 and 12 are within 6e-8.
#[inline(always)]
pub fn sin_cos<L: Lanes>(angle_rad: L) -> (L, L) {
    let constant = |value: f32| angle_rad.like(value);
    let shift = constant(ROUNDING_SHIFT);
    let half_turns = (angle_rad * constant(1.0 / std::f32::consts::PI) + shift) - shift;
    let rest = (angle_rad - half_turns * constant(PI_UPPER)) - half_turns * constant(PI_LOWER);
    // The sign is -1 after an odd number of half turns: `odd` is then 1 or -1, else 0.
    let odd = half_turns - constant(2.0) * ((half_turns * constant(0.5) + shift) - shift);
    let sign = constant(1.0) - constant(2.0) * odd * odd;
    let square = rest * rest;
    let polynomial = |coefficients: [f32; 6]| {
        let [first, others @ ..] = coefficients;
        others.into_iter().fold(constant(first), |sum, next| sum * square + constant(next))
    };
    let sine = polynomial([-1.0 / 39_916_800.0, 1.0 / 362_880.0, -1.0 / 5040.0, 1.0 / 120.0, -1.0 / 6.0, 1.0]) * rest;
    let cosine = polynomial([1.0 / 479_001_600.0, -1.0 / 3_628_800.0, 1.0 / 40_320.0, -1.0 / 720.0, 1.0 / 24.0, -0.5]);
    (sign * sine, sign * (cosine * square + constant(1.0)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::collision::lanes::{Backend, LANE_COUNT, LaneTask};

    struct OfAngles([f32; LANE_COUNT]);

    impl LaneTask for OfAngles {
        type Output = ([f32; LANE_COUNT], [f32; LANE_COUNT]);

        #[inline(always)]
        fn run<L: Lanes>(self, token: L::Token) -> Self::Output {
            let (sine, cosine) = sin_cos(L::from_array(token, self.0));
            (sine.to_array(), cosine.to_array())
        }
    }

    #[test]
    fn sine_and_cosine_are_within_the_stated_error() {
        let mut worst = 0.0_f64;
        for step in 0..60_000 {
            let angles: [f32; LANE_COUNT] = std::array::from_fn(|k| (step * 8 + k) as f32 * 1.25e-4 - 30.0);
            let (sines, cosines) = Backend::fastest().run(OfAngles(angles));
            for ((angle, sine), cosine) in angles.into_iter().zip(sines).zip(cosines) {
                let (true_sine, true_cosine) = f64::from(angle).sin_cos();
                worst = worst.max((f64::from(sine) - true_sine).abs()).max((f64::from(cosine) - true_cosine).abs());
            }
        }
        assert!(worst < 4e-7, "{worst:e}");
    }
}
