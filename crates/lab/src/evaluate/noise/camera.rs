//! A camera whose angles are misjudged.

use rand::RngExt;

use super::Noise;
use geometry::Camera;
use runtime::seed::child_rng;

/// The camera turned about the world's origin (the middle of the table top): about +z by the error of the azimuth,
/// about its own rightward axis by that of the elevation. It keeps its distance and its intrinsics.
pub fn misjudged(camera: &Camera, noise: &Noise, seed: u64) -> Camera {
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
    fn errors_stay_within_their_amplitudes_and_the_middle_of_the_table_stays_in_place() {
        let camera = Camera::orbit(960, 720, 0.61, DVec3::ZERO, 0.2, 0.8, 1.6);
        for seed in 0..50 {
            let off = misjudged(&camera, &Noise::NOISY, seed);
            assert!((off.elevation_rad() - 0.8).abs() <= Noise::NOISY.elevation_rad + 1e-9);
            assert!((off.azimuth_rad() - 0.2).abs() <= Noise::NOISY.azimuth_rad + 1e-9);
            let (pixel, _) = off.project(DVec3::ZERO).expect("in front");
            assert!((pixel - glam::DVec2::new(480.0, 360.0)).length() < 1e-6);
        }
    }
}
