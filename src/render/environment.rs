//! All the light of a picture, prepared: key light with its shadow map, sky with its occlusion maps, and
//! the surroundings that shiny surfaces mirror.

use glam::{Vec3, Vec3A};
use rayon::prelude::*;

use super::light_map::{LightMap, sky_directions};
use super::{Lighting, RenderObject, RenderSettings};

/// Light arriving at points of the scene.
pub struct Environment {
    pub lighting: Lighting,
    pub toward_key: Vec3A,
    key_map: Option<LightMap>,
    sky: Vec<(Vec3A, LightMap)>,
}

/// Sky light at a surface point.
#[derive(Clone, Copy)]
pub struct SkyLight {
    /// What a white matte surface reflects of it.
    pub diffuse: Vec3,
    /// Share of the sky that is open, 0..1.
    pub openness: f32,
}

impl Environment {
    pub fn new(objects: &[RenderObject], lighting: Lighting, settings: &RenderSettings) -> Self {
        let key_map = LightMap::new(
            objects,
            lighting.toward_key,
            settings.shadow_map_px.min(4096),
            lighting.key_radius_rad,
        );
        let sky = sky_directions(settings.sky_directions.min(64))
            .into_par_iter()
            .filter_map(|d| {
                let map = LightMap::new(objects, d.as_dvec3(), settings.sky_map_px.clamp(32, 1024), 0.0)?;
                Some((Vec3A::from(d), map))
            })
            .collect();
        Self { lighting, toward_key: Vec3A::from(lighting.toward_key.as_vec3()), key_map, sky }
    }

    /// Share of the key light that reaches a surface point.
    pub fn key_visibility(&self, point: Vec3A, normal: Vec3A, turn_rad: f32) -> f32 {
        self.key_map.as_ref().map_or(1.0, |map| {
            map.soft_visibility(point, normal, self.lighting.key_radius_rad as f32, turn_rad)
        })
    }

    /// Sky and ground light at a surface point.
    pub fn sky_light(&self, point: Vec3A, normal: Vec3A) -> SkyLight {
        let (mut lit, mut all, mut open) = (0.0_f32, 1e-4_f32, 0.0_f32);
        for (direction, map) in &self.sky {
            let share = map.openness(point, normal);
            let weight = normal.dot(*direction).max(0.0);
            lit += weight * share;
            all += weight;
            open += share;
        }
        let (covered, openness) =
            if self.sky.is_empty() { (1.0, 1.0) } else { (lit / all, open / self.sky.len() as f32) };
        let up = 0.5 + 0.5 * normal.z;
        let diffuse = self.lighting.sky_color * (up * (0.12 + 0.88 * covered))
            + self.lighting.ground_color * ((1.0 - up) * (0.35 + 0.65 * openness));
        SkyLight { diffuse, openness }
    }

    /// What a mirror sees in that direction, blurred by `roughness`: ceiling, walls, floor, and two soft
    /// boxes beside the key that give metal and glaze their highlights.
    pub fn mirrored(&self, direction: Vec3A, roughness: f32) -> Vec3 {
        let (sky, ground) = (self.lighting.sky_color, self.lighting.ground_color);
        let wall = 0.55 * sky + 0.25 * ground;
        let blend = |t: f32| {
            let width = 0.25 + 0.75 * roughness;
            ((t + width) / (2.0 * width)).clamp(0.0, 1.0)
        };
        let above = wall.lerp(1.35 * sky, direction.z.max(0.0));
        let below = (0.7 * wall).lerp(ground, (-2.0 * direction.z).clamp(0.0, 1.0));
        let base = below.lerp(above, blend(direction.z));
        let key = self.toward_key;
        let side = Vec3A::new(-key.y, key.x, 0.35).normalize_or_zero();
        let rim = Vec3A::new(-key.x, -key.y, 0.6).normalize_or_zero();
        let sharp = 1.0 / (0.06 + 0.9 * roughness * roughness);
        let lamp = |toward: Vec3A, size: f32| {
            let near = (direction.dot(toward) - 1.0) * sharp / size;
            (0.4 * sharp.sqrt() * near.exp()).min(1.0)
        };
        base + self.lighting.key_color * (0.9 * lamp(side, 1.5) + 0.7 * lamp(rim, 1.0))
    }
}
