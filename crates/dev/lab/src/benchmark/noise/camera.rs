//! Perturbation of the camera angles.

use rand::RngExt;

use super::Noise;
use geometry::Camera;
use runtime::seed::child_rng;

/// The camera rotated about the world origin (center of the table top): about +z by the azimuth error, and about
/// its own rightward axis by the elevation error. Distance and intrinsics are unchanged.
pub fn perturb(camera: &Camera, noise: &Noise, seed: u64) -> Camera {
    let mut rng = child_rng(seed, "camera noise");
    let azimuth_rad = noise.azimuth_rad * rng.random_range(-1.0..1.0);
    let elevation_rad = noise.elevation_rad * rng.random_range(-1.0..1.0);
    camera.orbited(azimuth_rad, elevation_rad)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    #[test]
    fn perturb_stays_within_amplitudes_and_keeps_table_center() {
        let camera = Camera::orbit(960, 720, 0.61, DVec3::ZERO, 0.2, 0.8, 1.6);
        for seed in 0..50 {
            let off = perturb(&camera, &Noise::NOISY, seed);
            assert!((off.elevation_rad() - 0.8).abs() <= Noise::NOISY.elevation_rad + 1e-9);
            assert!((off.azimuth_rad() - 0.2).abs() <= Noise::NOISY.azimuth_rad + 1e-9);
            let (pixel, _) = off.project(DVec3::ZERO).expect("in front");
            assert!((pixel - glam::DVec2::new(480.0, 360.0)).length() < 1e-6);
        }
    }
}
