//! Rotational symmetry of a loss curve.
//!
//! A flat curve belongs to a body of revolution; a curve that repeats every 360/n degrees belongs to a body of that
//! symmetry. Both are statements about the outline from this one camera. Because the camera is a perspective one, only
//! bodies with the symmetry give such curves, to within noise.

use std::f64::consts::TAU;

use super::YawSettings;
use geometry::pose::wrap_angle_rad;

/// 0 = any angle, n = every 360/n degrees, 1 = none. `curve` covers a turn evenly.
pub fn order_of(curve: &[(f64, f64)], settings: &YawSettings) -> u32 {
    let losses: Vec<f64> = curve.iter().map(|c| c.1).collect();
    let (low, high) =
        losses.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), &v| (l.min(v), h.max(v)));
    let spread = high - low;
    if !spread.is_finite() || spread < settings.flat_spread {
        return 0;
    }
    periodic_order(curve, settings.periodic_share)
}

/// Highest order at which the closed curve repeats to within `share` of its spread (root mean square);
/// 1 if it does not.
pub fn periodic_order(curve: &[(f64, f64)], share: f64) -> u32 {
    let losses: Vec<f64> = curve.iter().map(|c| c.1).collect();
    let (low, high) = range(&losses);
    let spread = high - low;
    let n = losses.len() as f64;
    let deviation = |order: u32| {
        // Not a whole number of samples for every order, so the curve is interpolated.
        let shift = n / f64::from(order);
        let total: f64 = (0..losses.len())
            .map(|k| {
                let at = k as f64 + shift;
                let (left, t) = (at.floor(), at.fract());
                let value = |j: f64| losses[j as usize % losses.len()];
                let shifted = value(left) * (1.0 - t) + value(left + 1.0) * t;
                (shifted - losses[k]).powi(2)
            })
            .sum();
        (total / n).sqrt() / spread
    };
    // Highest first: a curve of order 12 also repeats with 6, 4, 3 and 2.
    [12, 10, 8, 6, 5, 4, 3, 2].into_iter().find(|&order| deviation(order) < share).unwrap_or(1)
}

fn range(values: &[f64]) -> (f64, f64) {
    values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), &v| (l.min(v), h.max(v)))
}

/// The equivalent yaw within half a period of 0; 0 where any angle does.
pub fn representative(yaw_rad: f64, symmetry_order: u32) -> f64 {
    if symmetry_order == 0 {
        return 0.0;
    }
    let order = f64::from(symmetry_order);
    wrap_angle_rad(yaw_rad * order).clamp(-0.5 * TAU, 0.5 * TAU) / order
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn representative_yaw_is_equivalent_and_near_zero() {
        for order in 1..7_u32 {
            for k in 0..50 {
                let yaw_rad = -7.0 + 0.3 * f64::from(k);
                let r = representative(yaw_rad, order);
                let period = TAU / f64::from(order);
                assert!(r.abs() <= 0.5 * period + 1e-9);
                let turns = (yaw_rad - r) / period;
                assert!((turns - turns.round()).abs() < 1e-9);
            }
        }
        assert_eq!(representative(1.3, 0), 0.0);
    }
}
