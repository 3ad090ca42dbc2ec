//! The key light as a disk at infinity, or as a point if it has no radius.

use std::f32::consts::{PI, TAU};

use glam::{Vec2, Vec3, Vec3A};

use crate::Lighting;

/// Angular radius below which no ray is expected to meet the disk by chance, radians.
const POINT_RAD: f64 = 1e-4;

/// Directions from which the key light comes.
pub struct KeyLight {
    pub toward: Vec3A,
    right: Vec3A,
    up: Vec3A,
    /// One less the cosine of the radius; zero for a point.
    height: f32,
    /// Light that a white matte surface which faces the key reflects.
    color: Vec3,
}

/// A direction toward a light.
pub struct LightSample {
    pub direction: Vec3A,
    /// Radiance over the density of the direction.
    pub weight: Vec3,
    /// Probability per solid angle; `None` for a light that no ray meets by chance.
    pub density: Option<f32>,
}

impl KeyLight {
    pub fn new(lighting: &Lighting) -> Self {
        let toward = Vec3A::from(lighting.toward_key.as_vec3()).normalize_or(Vec3A::Z);
        let (right, up) = toward.any_orthonormal_pair();
        let radius_rad = lighting.key_radius_rad.clamp(0.0, 1.5);
        let height = if radius_rad < POINT_RAD { 0.0 } else { 2.0 * (0.5 * radius_rad).sin().powi(2) };
        Self { toward, right, up, height: height as f32, color: lighting.key_color }
    }

    /// Whether there is any.
    pub fn shines(&self) -> bool {
        self.color.max_element() > 0.0
    }

    fn solid_angle(&self) -> f32 {
        TAU * self.height
    }

    /// Radiance of the disk, whose irradiance on a surface that faces it is pi times the color.
    fn radiance(&self) -> Vec3 {
        let cosine = 1.0 - self.height;
        self.color / (1.0 - cosine * cosine).max(1e-12)
    }

    /// A direction, uniform over the disk.
    pub fn sample(&self, u: Vec2) -> LightSample {
        if self.height == 0.0 {
            return LightSample { direction: self.toward, weight: PI * self.color, density: None };
        }
        let drop = u.x * self.height;
        let radius = (drop * (2.0 - drop)).sqrt();
        let (sin, cos) = (TAU * u.y).sin_cos();
        let direction = self.toward * (1.0 - drop) + radius * (cos * self.right + sin * self.up);
        let density = 1.0 / self.solid_angle();
        LightSample {
            direction: direction.normalize(),
            weight: self.radiance() * self.solid_angle(),
            density: Some(density),
        }
    }

    /// Radiance from a direction and the density with which it is sampled; `None` beside the disk.
    pub fn met(&self, direction: Vec3A) -> Option<(Vec3, f32)> {
        // The chord, since cosines of a narrow disk differ by rounding alone.
        let is_within = self.height > 0.0 && (direction - self.toward).length_squared() <= 2.0 * self.height;
        is_within.then(|| (self.radiance(), 1.0 / self.solid_angle()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_are_on_the_disk_and_carry_its_irradiance() {
        for key_radius_rad in [0.0, 0.01, 0.106, 0.4] {
            let lighting = Lighting { key_radius_rad, ..Lighting::studio(0.3, 0.9, 0.0) };
            let key = KeyLight::new(&lighting);
            let mut irradiance = Vec3::ZERO;
            for k in 0..1024 {
                let u = (Vec2::new((k % 32) as f32, (k / 32) as f32) + 0.5) / 32.0;
                let sample = key.sample(u);
                irradiance += sample.weight * sample.direction.dot(key.toward) / 1024.0;
                assert_eq!(key.met(sample.direction).is_some(), sample.density.is_some());
            }
            assert!(irradiance.abs_diff_eq(PI * lighting.key_color, 1e-3), "{key_radius_rad}: {irradiance}");
            assert!(key.met((key.toward + 0.6 * key.right).normalize()).is_none());
        }
    }
}
