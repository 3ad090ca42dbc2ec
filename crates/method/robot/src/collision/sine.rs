//! Sine and cosine of eight angles.

use std::f64::consts::PI;

use super::lanes::Lanes;

/// Adding and subtracting it rounds an `f32` below 2^22 to the nearest integer.
const ROUNDING_SHIFT: f32 = 12_582_912.0;
/// The upper bits of pi, so few that a small integer times it is exact.
const PI_UPPER: f32 = 3.140_625;
/// Remainder of pi after its upper bits.
const PI_LOWER: f32 = (PI - PI_UPPER as f64) as f32;

/// Sine and cosine, each within 4e-7 for angles up to 30 rad.
///
/// The angle is reduced to a half turn around zero, where Taylor's polynomials of degree 11 and 12 are within 6e-8.
#[inline(always)]
pub fn sin_cos<L: Lanes>(angle_rad: L) -> (L, L) {
    let shift = angle_rad.like(ROUNDING_SHIFT);
    let (one, two) = (angle_rad.like(1.0), angle_rad.like(2.0));
    let half_turns = (angle_rad * angle_rad.like(1.0 / std::f32::consts::PI) + shift) - shift;
    let rest = (angle_rad - half_turns * angle_rad.like(PI_UPPER)) - half_turns * angle_rad.like(PI_LOWER);
    // The sign is -1 after an odd number of half turns: `odd` is then 1 or -1, else 0.
    let odd = half_turns - two * ((half_turns * angle_rad.like(0.5) + shift) - shift);
    let sign = one - two * odd * odd;
    let square = rest * rest;
    let sine = polynomial(square, SINE) * rest;
    let cosine = polynomial(square, COSINE) * square + one;
    (sign * sine, sign * cosine)
}

/// Coefficients of x^11, x^9, ..., x.
const SINE: [f32; 6] = [-1.0 / 39_916_800.0, 1.0 / 362_880.0, -1.0 / 5040.0, 1.0 / 120.0, -1.0 / 6.0, 1.0];
/// Coefficients of x^12, x^10, ..., x^2.
const COSINE: [f32; 6] =
    [1.0 / 479_001_600.0, -1.0 / 3_628_800.0, 1.0 / 40_320.0, -1.0 / 720.0, 1.0 / 24.0, -0.5];

/// The polynomial with these coefficients, from the highest power to the constant.
#[inline(always)]
fn polynomial<L: Lanes>(x: L, coefficients: [f32; 6]) -> L {
    let mut sum = x.like(coefficients[0]);
    for coefficient in &coefficients[1..] {
        sum = sum * x + x.like(*coefficient);
    }
    sum
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
                worst = worst
                    .max((f64::from(sine) - true_sine).abs())
                    .max((f64::from(cosine) - true_cosine).abs());
            }
        }
        assert!(worst < 4e-7, "{worst:e}");
    }
}
