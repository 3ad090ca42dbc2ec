//! Light in a room, prepared for one image: from windows, walls and ceiling, and from what lies below a point.
//!
//! Light that the tabletop or the floor throws back at an object is that of one place: where a ray between the normal
//! and straight down arrives. The sky's occlusion there tells how much light it has to give (one bounce). Where neither
//! that place nor the point sees much of the sky, as in a pot, surfaces like the point's own lie in between.

use glam::{Vec2, Vec3, Vec3A};

use super::environment::{Ambient, Below, MIN_SKY_COSINE};
use super::environment_map::{EnvironmentMap, FURNISHED_ROOM, Shares};
use super::partly_open::{PartlyOpen, arriving};
use super::shade::Surface;
use super::sky::Sky;
use crate::room::luminance;
use crate::{Lighting, Room};

/// Light of a room on points of the scene. Radiances are in the units of reflected light: 1 is a white surface in full
/// light.
pub struct RoomLight {
    pub room: Room,
    pub map: &'static EnvironmentMap,
    /// Horizontal unit direction toward the largest window.
    pub toward_window: Vec2,
    pub window: Vec3,
    pub wall: Vec3,
    pub ceiling: Vec3,
    /// Light from above on a level surface that nothing shades.
    pub open_sky: Vec3,
    /// Of floor and tabletop where nothing shades them.
    pub open_floor: Vec3,
    pub open_tabletop: Vec3,
    /// The tabletop as mirrors show it.
    pub mirrored_tabletop: Vec3,
}

/// Radiance of windows, and of a white wall and ceiling.
const WINDOW: Vec3 = Vec3::new(4.4, 4.6, 4.8);
const WHITE_WALL: f32 = 0.5;
const CEILING: Vec3 = Vec3::new(0.55, 0.545, 0.53);
/// Light on the floor around the scene, as a share of that on the tabletop.
const FLOOR_SHARE: f32 = 0.7;
/// Light on walls, as a share of that in the center of the room: the backdrop stays behind the subject.
pub const WALL_SHARE: f32 = 0.85;
/// Radiance of a tabletop that is exposed as it is; darker ones are exposed longer, lighter ones shorter.
const EXPOSED_AS_IS: f32 = 0.2;
/// Share of a difference in brightness, in stops, that exposure makes up for.
const COMPENSATED: f32 = 0.35;
/// Share of the tabletop's saturation that mirrors show: its own sheen, which is white, is part of what they mirror.
const MIRRORED_SATURATION: f32 = 0.6;

/// Strength by which the outline of glass bends light, and its roughness.
pub const BEND: f32 = 1.1;
pub const RIM_BLUR: f32 = 0.15;

impl RoomLight {
    pub fn new(room: Room, lighting: &Lighting) -> Self {
        let key = lighting.toward_key.as_vec3();
        let map = &*FURNISHED_ROOM;
        let mut light = Self {
            room,
            map,
            toward_window: key.truncate().normalize_or(Vec2::X),
            window: WINDOW,
            wall: WHITE_WALL * room.decor.wall_color,
            ceiling: CEILING,
            open_sky: Vec3::ZERO,
            open_floor: Vec3::ZERO,
            open_tabletop: Vec3::ZERO,
            mirrored_tabletop: Vec3::ZERO,
        };
        light.open_sky = light.above(map.diffuse(Vec3::Z));
        let open = lighting.key_color * key.z.max(0.0) + light.open_sky;
        light.open_floor = FLOOR_SHARE * open * room.decor.floor_color();
        light.open_tabletop = open * room.tabletop.color;
        let gray = Vec3::splat(luminance(light.open_tabletop));
        light.mirrored_tabletop = gray.lerp(light.open_tabletop, MIRRORED_SATURATION);
        light
    }

    /// Factor on light that exposes the tabletop well: the darker it is, the longer.
    pub fn exposure(&self) -> f32 {
        (EXPOSED_AS_IS / luminance(self.open_tabletop).max(0.01)).powf(COMPENSATED).clamp(0.55, 1.3)
    }

    /// Radiance of what is above the horizon.
    fn above(&self, shares: Shares) -> Vec3 {
        self.window * shares.x + self.wall * shares.y + self.ceiling * shares.z
    }

    /// A direction of the world in the frame of the map.
    fn in_map(&self, d: Vec3A) -> Vec3 {
        let w = self.toward_window;
        Vec3::new(d.x * w.x + d.y * w.y, d.y * w.x - d.x * w.y, d.z)
    }

    /// Light that a white matte surface of that normal reflects.
    pub fn diffuse(&self, normal: Vec3A, around: &Ambient) -> PartlyOpen {
        let shares = self.map.diffuse(self.in_map(normal));
        self.partly_open(shares, around.below.light, around)
    }

    /// Light that a surface point mirrors from a direction, blurred by `roughness`.
    pub fn mirrored(&self, point: Vec3A, direction: Vec3A, roughness: f32, around: &Ambient) -> PartlyOpen {
        let shares = self.map.mirrored(self.in_map(direction), roughness);
        if shares.w <= 0.0 {
            return self.partly_open(shares, Vec3::ZERO, around);
        }
        let on_tabletop = self.share_on_tabletop(point, direction, roughness);
        self.partly_open(shares, around.below.light.lerp(self.mirrored_tabletop, on_tabletop), around)
    }

    /// Light in these shares where what lies below has this radiance if nothing shades it.
    fn partly_open(&self, shares: Shares, below: Vec3, around: &Ambient) -> PartlyOpen {
        let enclosed = (1.0 - around.below.open) * (1.0 - around.seen.arriving);
        PartlyOpen {
            far: self.above(shares) + shares.w * enclosed * self.open_sky,
            arriving: arriving(around.seen),
            near: shares.w * (1.0 - enclosed) * below,
            near_open: around.below.open,
        }
    }

    /// Light that the thick outline of glass shows: that from a direction beyond its axis, since a rod of glass is a
    /// lens.
    pub fn refracted(&self, s: &Surface, ambient: &Ambient) -> Vec3 {
        let direction = (-s.toward_eye - BEND * s.normal).normalize_or(-s.normal);
        self.mirrored(s.point, direction, RIM_BLUR, ambient).between(Vec3::ONE)
    }

    /// Light that a wall of that inward normal reflects where nothing is near.
    pub fn on_wall(&self, normal: Vec3A) -> Vec3 {
        let shares = self.map.diffuse(self.in_map(normal));
        WALL_SHARE * (self.above(shares) + shares.w * self.open_floor)
    }

    /// Share of a ray, widened by `roughness`, that meets the tabletop.
    fn share_on_tabletop(&self, point: Vec3A, direction: Vec3A, roughness: f32) -> f32 {
        let tabletop = &self.room.tabletop;
        let height = point.z - tabletop.z_m as f32;
        if height < -0.01 {
            return 0.0;
        }
        let length = height.max(0.0) / (-direction.z).max(0.1);
        let at = Vec2::new(point.x, point.y) + length * Vec2::new(direction.x, direction.y);
        let (low, high) = (tabletop.low_m.as_vec2(), tabletop.high_m.as_vec2());
        let outside = (low - at).max(at - high).max_element();
        (0.5 - outside / (0.02 + roughness * length)).clamp(0.0, 1.0)
    }

    /// Place below a surface point, in the direction that its normal and straight down enclose.
    pub fn below(&self, sky: &Sky, point: Vec3A, normal: Vec3A) -> Below {
        /// Above this height of the normal nothing below is seen.
        const LEVEL: f32 = 0.98;
        if normal.z > LEVEL {
            return Below::NOTHING;
        }
        let toward = Vec3A::new(normal.x, normal.y, normal.z - 1.0).normalize_or(Vec3A::NEG_Z);
        let tabletop = &self.room.tabletop;
        let mut at = met(point, toward, tabletop.z_m as f32);
        let (low, high) = (tabletop.low_m.as_vec2(), tabletop.high_m.as_vec2());
        let over = Vec2::new(at.x, at.y);
        let on_tabletop =
            point.z > tabletop.z_m as f32 - 0.002 && over.cmpge(low).all() && over.cmple(high).all();
        if !on_tabletop {
            at = met(point, toward, self.room.floor_z_m as f32);
        }
        let light = if on_tabletop { self.open_tabletop } else { self.open_floor };
        let open = sky.seen_from(at, Vec3A::Z, MIN_SKY_COSINE).arriving;
        Below { light, open }
    }
}

/// Point at which a descending ray meets a height; its start if that lies below.
fn met(point: Vec3A, toward: Vec3A, z_m: f32) -> Vec3A {
    let length = (point.z - z_m).max(0.0) / (-toward.z).max(0.05);
    (point + length * toward).with_z(z_m)
}
