//! Illumination of an image: number, softness, warmth and brightness of the key lights.

use std::f64::consts::PI;

use glam::Vec3;

use super::sampling::{chance, uniform};
use render::Lighting;
use runtime::seed::Rng;

/// Light setups whose renderings are averaged.
pub(super) struct Illumination {
    pub lightings: Vec<Lighting>,
}

impl Illumination {
    pub(super) fn draw(rng: &mut Rng) -> Self {
        let count = if chance(rng, 0.12) { 2 } else { 1 };
        // Even light with faint shadows, as in product images, or a plain key light.
        let even = chance(rng, 0.45);
        let exposure = if chance(rng, 0.4) { uniform(rng, 1.15, 1.8) } else { uniform(rng, 0.8, 1.2) } as f32;
        let warmth = uniform(rng, -0.1, 0.12) as f32;
        let lightings = (0..count)
            .map(|_| {
                let azimuth = if chance(rng, 0.7) { uniform(rng, -1.6, 1.6) } else { uniform(rng, -PI, PI) };
                let softness = if even { uniform(rng, 0.6, 1.0) } else { uniform(rng, 0.0, 1.0) };
                let studio = Lighting::studio(azimuth, uniform(rng, 0.45, 1.4), softness);
                let key = if even { uniform(rng, 0.25, 0.5) } else { uniform(rng, 0.5, 1.0) } as f32;
                let sky = (if even { uniform(rng, 0.55, 0.8) } else { uniform(rng, 0.2, 0.6) }) as f32;
                let tint = Vec3::new(1.0 + warmth, 1.0, 1.0 - warmth);
                Lighting {
                    key_color: key * tint,
                    sky_color: sky * (2.0 * Vec3::ONE - tint),
                    ground_color: Vec3::splat(uniform(rng, 0.12, 0.45) as f32),
                    exposure,
                    ..studio
                }
            })
            .collect();
        Self { lightings }
    }
}
