//! Slight unevenness of surfaces in a room: clouds and smudges, since nothing real is of one brightness and gloss.
//!
//! It lies in the frame of the object, so that it moves with it. Noise on two slanted planes stands for noise in space.

use glam::{Vec2, Vec3A};

use crate::forward::noise::value_noise;

/// Factors on the color and the roughness of a material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceWear {
    pub color: f32,
    pub roughness: f32,
}

impl SurfaceWear {
    /// The wear of a new surface.
    pub const NONE: Self = Self { color: 1.0, roughness: 1.0 };

    /// At a point in the frame of its object, meters; `seed` is that of the material. Details below the size of a
    /// pixel are left out.
    pub fn at(p: Vec3A, pixel_size_m: f32, seed: u32) -> Self {
        let along = Vec2::new(p.x + 0.62 * p.z, p.y + 0.37 * p.z);
        let across = Vec2::new(p.x - 0.47 * p.z, p.y + 0.71 * p.z);
        let clouds = value_noise(28.0 * along, seed) - 0.5;
        let smudges = value_noise(75.0 * across, seed ^ 0x51) - 0.5;
        let kept = (FINE_M / (pixel_size_m + 1e-6) - 0.5).clamp(0.0, 1.0);
        let fine = if kept > 0.0 { kept * (value_noise(along / FINE_M, seed ^ 0xa2) - 0.5) } else { 0.0 };
        Self {
            color: 1.0 + 0.05 * clouds + 0.03 * fine,
            roughness: 1.0 + 0.12 * clouds + 0.18 * smudges + 0.1 * fine,
        }
    }
}

/// Size of the finest grain, meters.
pub const FINE_M: f32 = 0.0032;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wear_is_slight_and_one_on_average() {
        let worn = |k: usize| {
            let p = Vec3A::new((k % 40) as f32, (k / 40 % 40) as f32, (k / 1600) as f32) * 0.0071;
            SurfaceWear::at(p, 0.001, 7)
        };
        let count = 40 * 40 * 4;
        let mut sum = [0.0, 0.0];
        for wear in (0..count).map(worn) {
            assert!((wear.color - 1.0).abs() < 0.05 && (wear.roughness - 1.0).abs() < 0.21, "{wear:?}");
            sum = [sum[0] + wear.color / count as f32, sum[1] + wear.roughness / count as f32];
        }
        assert!((sum[0] - 1.0).abs() < 0.005 && (sum[1] - 1.0).abs() < 0.03, "{sum:?}");
    }
}
