//! Lighting of an image, prepared: the key light with its shadow map, the sky, and the surroundings mirrored by shiny
//! surfaces.

use std::ops::Range;

use glam::{Vec3, Vec3A};

use super::light_map::LightMap;
use super::room_light::RoomLight;
use super::scene_buffers::SceneBuffers;
use super::sky::{Sky, SkyShare};
use super::tone_curve::ToneCurve;
use crate::Lighting;
use crate::room::{Room, luminance};

/// Light arriving at points of the scene.
pub struct Environment<'a> {
    pub lighting: Lighting,
    pub toward_key: Vec3A,
    pub sky: &'a Sky,
    /// Directions toward two soft boxes beside the key light, which give metal and glaze their highlights.
    pub side_box: Vec3A,
    pub rim_box: Vec3A,
    pub key_map: Option<LightMap>,
    /// The shadows of objects that move, where they are not in `key_map`.
    pub moving_map: Option<LightMap>,
    /// Light of the room, in place of that of sky and ground.
    pub room: Option<RoomLight>,
}

/// Smallest cosine of sky directions that count in a room. Nearer to the surface, the texels of the maps are too wide:
/// facets of a round body would shade each other.
pub const MIN_SKY_COSINE: f32 = 0.13;

/// Albedo of floors, which are not known here, for the light between them and what stands on them.
const FLOOR_ALBEDO: f32 = 0.35;

/// Ambient light at a surface point, shared by its neighborhood.
#[derive(Clone, Copy, Debug)]
pub struct Ambient {
    pub seen: SkyShare,
    /// Nothing outside of rooms.
    pub below: Below,
}

/// A place of tabletop or floor that a surface point faces.
#[derive(Clone, Copy, Debug)]
pub struct Below {
    /// Radiance if nothing shades it.
    pub light: Vec3,
    /// Share of the sky's light that arrives there, 0..1.
    pub open: f32,
}

impl Below {
    /// Of a point that faces neither.
    pub const NOTHING: Self = Self { light: Vec3::ZERO, open: 1.0 };
}

impl<'a> Environment<'a> {
    pub fn new(scene_buffers: &SceneBuffers, sky: &'a Sky, lighting: Lighting, shadow_map_px: u32) -> Self {
        Self::of_part(scene_buffers, &scene_buffers.all(), sky, lighting, shadow_map_px)
    }

    /// As [`Self::new`], with the shadows that consecutive objects cast.
    pub fn of_part(
        scene_buffers: &SceneBuffers,
        casters: &Range<usize>,
        sky: &'a Sky,
        lighting: Lighting,
        shadow_map_px: u32,
    ) -> Self {
        let key_map = shadows_of(scene_buffers, casters, &lighting, shadow_map_px, f64::INFINITY);
        let key = Vec3A::from(lighting.toward_key.as_vec3());
        let side_box = Vec3A::new(-key.y, key.x, 0.35).normalize_or_zero();
        let rim_box = Vec3A::new(-key.x, -key.y, 0.6).normalize_or_zero();
        Self { lighting, toward_key: key, sky, side_box, rim_box, key_map, moving_map: None, room: None }
    }

    /// The same light in a room.
    pub fn in_room(mut self, room: Option<Room>) -> Self {
        self.room = room.map(|room| RoomLight::new(room, &self.lighting));
        self
    }

    /// Curve from light to image.
    pub fn tone_curve(&self) -> ToneCurve {
        if self.room.is_some() { ToneCurve::Photographic } else { ToneCurve::Knee }
    }

    /// Ambient light at a surface point; `flat_normal` is that of its triangle. Without the directions nearest to the
    /// surface, the smooth normal does not leak light through the flat face.
    pub fn ambient(&self, point: Vec3A, flat_normal: Vec3A, normal: Vec3A) -> Ambient {
        match &self.room {
            Some(room) => Ambient {
                seen: self.sky.seen_from(point, normal, MIN_SKY_COSINE),
                below: room.below(self.sky, point, normal),
            },
            None => Ambient { seen: self.sky.seen_from(point, flat_normal, 0.0), below: Below::NOTHING },
        }
    }

    /// Reciprocal of the light on an unshadowed floor.
    pub fn per_open_floor(&self) -> Vec3 {
        let open = self.lighting.key_color * self.toward_key.z.max(0.0) + self.lighting.sky_color;
        open.max(Vec3::splat(1e-3)).recip()
    }

    /// Share of the key light that reaches a surface point, by color.
    pub fn key_visibility(&self, point: Vec3A, normal: Vec3A, turn: f32) -> Vec3 {
        let past_still = self.past_still(point, normal, turn);
        if past_still == Vec3::ZERO { past_still } else { past_still * self.past_moving(point, normal, turn) }
    }

    /// Share of the key light that passes the objects of `key_map`, by color.
    pub fn past_still(&self, point: Vec3A, normal: Vec3A, turn: f32) -> Vec3 {
        let Some(map) = &self.key_map else { return Vec3::ONE };
        let past_opaque = map.soft_visibility(point, normal, turn);
        if past_opaque == 0.0 { Vec3::ZERO } else { past_opaque * map.through_glass(point, normal) }
    }

    /// Share of the key light that passes the objects that move.
    pub fn past_moving(&self, point: Vec3A, normal: Vec3A, turn: f32) -> f32 {
        let Some(map) = &self.moving_map else { return 1.0 };
        let past_opaque = map.soft_visibility(point, normal, turn);
        if past_opaque == 0.0 { 0.0 } else { past_opaque * luminance(map.through_glass(point, normal)) }
    }

    /// Ambient light that a white matte floor reflects.
    pub fn on_floor(&self, seen: SkyShare) -> Vec3 {
        match &self.room {
            Some(room) => {
                let around = Ambient { seen, below: Below::NOTHING };
                room.diffuse(Vec3A::Z, &around).between(Vec3::splat(FLOOR_ALBEDO))
            }
            None => self.diffuse(Vec3A::Z, seen),
        }
    }

    /// Light that a white matte surface of that normal reflects from sky and ground.
    pub fn diffuse(&self, normal: Vec3A, seen: SkyShare) -> Vec3 {
        let up = 0.5 + 0.5 * normal.z;
        self.lighting.sky_color * (up * (0.12 + 0.88 * seen.arriving))
            + self.lighting.ground_color * ((1.0 - up) * (0.35 + 0.65 * seen.open))
    }

    /// Light from that direction, blurred by `roughness`: ceiling, walls, floor and soft boxes.
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
        let sharp = 1.0 / (0.06 + 0.9 * roughness * roughness);
        let lamp = |toward: Vec3A, size: f32| {
            let near = (direction.dot(toward) - 1.0) * sharp / size;
            (0.4 * sharp.sqrt() * near.exp()).min(1.0)
        };
        base + self.lighting.key_color * (0.9 * lamp(self.side_box, 1.5) + 0.7 * lamp(self.rim_box, 1.0))
    }
}

/// The key light's map of the shadows that consecutive objects cast: [`LightMap::of_part`].
pub fn shadows_of(
    scene_buffers: &SceneBuffers,
    casters: &Range<usize>,
    lighting: &Lighting,
    shadow_map_px: u32,
    max_texels_per_m: f64,
) -> Option<LightMap> {
    let (side_px, radius_rad) = (shadow_map_px.min(4096), lighting.key_radius_rad);
    LightMap::of_part(scene_buffers, casters, lighting.toward_key, side_px, max_texels_per_m, radius_rad)
}
