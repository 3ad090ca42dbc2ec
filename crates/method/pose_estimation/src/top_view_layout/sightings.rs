//! Registration of the top view with the positions seen by the reference camera.
//!
//! The center of the table's box defines the world's origin, and an error of a percent in the box of a large table
//! moves every object by a centimeter. Each object has a second measurement: the intersection of its viewing ray with
//! its supporting plane. Scale and origin of the top view minimize the distance between the boxes and these positions,
//! weighted by the accuracy of the camera:
//!
//! `min  sum_i rho(|alpha / kappa q_i + t - c_i| / s) + (ln alpha - ln alpha_0)^2 / 2 e^2 + |t / o|^2 / 2 + (ln
//! kappa)^2 / 2 k^2`
//!
//! with `q_i` a box's center in pixels from the table's, `c_i` the position by the camera, `rho` Huber's loss (1964, k
//! = 1.5), `s` the scatter measured by the median, `e` and `o` the standard errors of the boxes, and `k` that of the
//! camera's own scale (its distance, too, comes from estimated sizes). Positions are compared in the camera's meters:
//! in the boxes' own, shrinking the layout would improve the agreement. Gauss-Newton with reweighting; four unknowns.
//! Beyond the paper, which uses boxes only. Requires three objects, since fewer do not determine the scatter of the
//! two views.

use glam::{DMat4, DVec2, DVec4};
use serde::{Deserialize, Serialize};

/// One object in both views.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sighting {
    /// Center of its box, pixels from the center of the table's box, x to the right, y up the image.
    pub offset_px: DVec2,
    /// Center of its footprint by the reference camera, world, meters.
    pub seen_m: DVec2,
}

/// The estimate of the boxes alone, with its standard deviations.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ByBoxes {
    /// `ln` of meters per pixel.
    pub log_alpha: f64,
    pub log_alpha_error: f64,
    /// Of the center of the table's box, meters.
    pub origin_error_m: DVec2,
}

/// The estimate from both views.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Registration {
    pub log_alpha: f64,
    /// Standard error of `log_alpha`.
    pub log_alpha_error: f64,
    /// World position of the center of the table's box.
    pub origin_m: DVec2,
    /// Standard deviation, in each direction, of an object's places by the two views.
    pub scatter_m: f64,
}

const HUBER_K: f64 = 1.5;
/// Median length of a vector whose two components have standard deviation 1 (Rayleigh): the root of `2 ln 2`.
const MEDIAN_LENGTH: f64 = 1.177_4;
/// Lower bound on the scatter of the two views, meters.
const MIN_SCATTER_M: f64 = 0.0005;
const MIN_SIGHTINGS: usize = 3;
const ROUNDS: usize = 20;

/// Scale and origin by both views; `None` where too few objects are in both. `camera_spread` is the standard
/// deviation of the logarithm of the camera's scale.
pub fn register(sightings: &[Sighting], boxes: &ByBoxes, camera_spread: f64) -> Option<Registration> {
    if sightings.len() < MIN_SIGHTINGS {
        return None;
    }
    let precision = |error: f64| 1.0 / error.max(1e-6).powi(2);
    // ln alpha less that of the boxes, ln kappa, t.
    let prior = DVec4::new(
        precision(boxes.log_alpha_error),
        precision(camera_spread),
        precision(boxes.origin_error_m.x),
        precision(boxes.origin_error_m.y),
    );
    let by_camera = |found: DVec4| (boxes.log_alpha + found.x - found.y).exp();
    let residual = |sighting: &Sighting, found: DVec4| {
        by_camera(found) * sighting.offset_px + DVec2::new(found.z, found.w) - sighting.seen_m
    };
    let start_shift = |of: fn(DVec2) -> f64| {
        -median(sightings.iter().map(|sighting| of(residual(sighting, DVec4::ZERO))).collect())
    };
    let mut found = DVec4::new(0.0, 0.0, start_shift(|r| r.x), start_shift(|r| r.y));
    let (mut information, mut scatter_m) = (DMat4::IDENTITY, MIN_SCATTER_M);
    for _ in 0..ROUNDS {
        let lengths = sightings.iter().map(|sighting| residual(sighting, found).length()).collect();
        scatter_m = (median(lengths) / MEDIAN_LENGTH).max(MIN_SCATTER_M);
        information = DMat4::from_diagonal(prior);
        let mut gradient = prior * found;
        for sighting in sightings {
            let r = residual(sighting, found);
            let (far, near) = (r.length(), HUBER_K * scatter_m);
            let weight = precision(scatter_m) * if far > near { near / far } else { 1.0 };
            let by_alpha = by_camera(found) * sighting.offset_px;
            let rows = [
                (DVec4::new(by_alpha.x, -by_alpha.x, 1.0, 0.0), r.x),
                (DVec4::new(by_alpha.y, -by_alpha.y, 0.0, 1.0), r.y),
            ];
            for (row, r) in rows {
                information += weight * DMat4::from_cols(row.x * row, row.y * row, row.z * row, row.w * row);
                gradient += weight * r * row;
            }
        }
        let step = information.inverse() * gradient;
        if !step.is_finite() {
            return None;
        }
        found -= step;
    }
    Some(Registration {
        log_alpha: boxes.log_alpha + found.x,
        log_alpha_error: information.inverse().x_axis.x.max(0.0).sqrt(),
        // t is in meters of the camera; kappa converts it to meters of the boxes.
        origin_m: found.y.exp() * DVec2::new(found.z, found.w),
        scatter_m,
    })
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    0.5 * (values[(values.len() - 1) / 2] + values[values.len() / 2])
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::RngExt;
    use runtime::seed::child_rng;

    const ALPHA: f64 = 0.002;

    /// Ten objects; boxes are read `shift_m` beside where the table's center truly is.
    fn sightings(shift_m: DVec2, noise_m: f64, seed: u64) -> Vec<Sighting> {
        let mut rng = child_rng(seed, "sightings");
        let mut draw = |reach: f64| rng.random_range(-reach..=reach);
        (0..10)
            .map(|_| {
                let at_m = DVec2::new(draw(0.5), draw(0.3));
                let seen_m = at_m + DVec2::new(draw(noise_m), draw(noise_m));
                Sighting { offset_px: (at_m - shift_m) / ALPHA, seen_m }
            })
            .collect()
    }

    fn boxes(log_alpha_off: f64) -> ByBoxes {
        let origin_error_m = DVec2::new(0.02, 0.01);
        ByBoxes { log_alpha: ALPHA.ln() + log_alpha_off, log_alpha_error: 0.04, origin_error_m }
    }

    #[test]
    fn register_recovers_origin_two_centimeters_off() {
        let shift_m = DVec2::new(0.02, -0.012);
        let found = register(&sightings(shift_m, 0.0, 1), &boxes(0.0), 0.05).expect("ten objects");
        assert!((found.origin_m - shift_m).length() < 5e-4, "{found:?}");
        assert!((found.log_alpha - ALPHA.ln()).abs() < 1e-3, "{found:?}");
    }

    #[test]
    fn register_weights_scale_by_accuracy() {
        let seen = sightings(DVec2::ZERO, 0.002, 2);
        let sure_camera = register(&seen, &boxes(0.1), 0.001).expect("ten objects");
        assert!((sure_camera.log_alpha - ALPHA.ln()).abs() < 0.02, "{sure_camera:?}");
        let doubtful_camera = register(&seen, &boxes(0.1), 10.0).expect("ten objects");
        assert!((doubtful_camera.log_alpha - ALPHA.ln() - 0.1).abs() < 0.02, "{doubtful_camera:?}");
    }

    #[test]
    fn register_is_robust_to_one_outlier() {
        for seed in 0..20 {
            let mut seen = sightings(DVec2::new(0.01, 0.0), 0.004, seed);
            seen[3].seen_m += DVec2::new(0.3, -0.4);
            let found = register(&seen, &boxes(0.02), 0.05).expect("ten objects");
            assert!((found.origin_m - DVec2::new(0.01, 0.0)).length() < 0.006, "{seed} {found:?}");
        }
        assert_eq!(register(&sightings(DVec2::ZERO, 0.0, 1)[..2], &boxes(0.0), 0.05), None);
    }
}
