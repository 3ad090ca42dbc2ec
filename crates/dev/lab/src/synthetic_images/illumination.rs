//! Illumination of an image: number, softness, warmth and brightness of the key lights.

use std::f64::consts::PI;

use glam::Vec3;

use super::sampling::{chance, uniform};
use render::{Lighting, Room};
use runtime::seed::Rng;

/// Light setups whose renderings are averaged.
pub(super) struct Illumination {
    pub lightings: Vec<Lighting>,
    /// Factors on the strength of sunlight and on the exposure in a room of the renderer.
    sun: f32,
    room_exposure: f32,
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
        let (sun, room_exposure) = (uniform(rng, 0.15, 1.3) as f32, uniform(rng, 0.75, 1.35) as f32);
        Self { lightings, sun, room_exposure }
    }

    /// Light of the same directions in a room, one per setup.
    pub(super) fn in_room(&self, room: &Room) -> Vec<Lighting> {
        let lit = |studio: &Lighting| {
            let daylight = Lighting { toward_key: studio.toward_key, ..Lighting::daylight(0.0, 1.0) };
            let dimmed = Lighting {
                key_color: self.sun * daylight.key_color,
                key_radius_rad: studio.key_radius_rad,
                ..daylight
            };
            let exposed = dimmed.exposed_for(room);
            Lighting { exposure: self.room_exposure * exposed.exposure, ..exposed }
        };
        self.lightings.iter().map(lit).collect()
    }
}
