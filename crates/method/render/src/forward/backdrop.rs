//! The color of rays that meet no object: a gradient with a floor for shadows, or floor and walls of a room.

pub mod furnishing;
pub mod sunspot;

use glam::{Vec2, Vec3, Vec3A};

use self::furnishing::{Furnishing, wall_of};
pub use self::sunspot::Sunspot;
use super::environment::Environment;
use super::floor_light::FloorLight;
use super::floor_pattern::floor_reflectance;
use super::noise::value_noise;
use super::room_light::{RoomLight, WALL_SHARE};
use crate::lighting::Background;
use crate::room::Room;

/// A ray in the world; its direction is one unit of depth long.
pub struct Ray {
    pub origin: Vec3A,
    pub direction: Vec3A,
}

/// Color of the backdrop along a ray, and the light on it.
pub struct BackdropPlace {
    /// Of the gradient, or the reflectance of floor or wall.
    color: Vec3,
    /// Absent where no light falls: beside the floor of a plain backdrop.
    pub receiver: Option<Receiver>,
}

/// A point of the backdrop on which light falls.
pub struct Receiver {
    pub point: Vec3A,
    pub normal: Vec3A,
    /// Light of the key where nothing shades it, and of all else.
    key: Vec3,
    ambient: Vec3,
}

/// Backdrop of an image.
pub struct Backdrop {
    pub background: Background,
    pub floor_light: Option<FloorLight>,
    /// Factor on the light of a receiver, and the limit of the product.
    pub per_light: Vec3,
    pub limit: Vec3,
    pub sunspot: Option<Sunspot>,
    pub furnishing: Option<Furnishing>,
}

/// Height of the skirting, and of the dark joint above it, meters.
const SKIRTING_M: f32 = 0.085;
const JOINT_M: f32 = 0.004;
/// Blur that a lens focused on the scene gives the backdrop, meters.
pub const DEFOCUS_M: f32 = 0.006;
/// Share of the key light on a wall outside the sunspot.
const BESIDE_SUNSPOT: f32 = 0.3;

impl Backdrop {
    pub fn new(background: Background, environment: &Environment, floor_light: Option<FloorLight>) -> Self {
        let exposure = environment.lighting.exposure;
        match &environment.room {
            Some(light) => Self {
                background,
                floor_light,
                per_light: Vec3::splat(exposure),
                limit: Vec3::INFINITY,
                sunspot: Some(Sunspot::new(&light.room, environment.toward_key)),
                furnishing: Some(Furnishing::of(&light.room)),
            },
            None => Self {
                background,
                floor_light,
                per_light: environment.per_open_floor(),
                limit: Vec3::ONE,
                sunspot: None,
                furnishing: None,
            },
        }
    }

    /// Backdrop along a ray at height `fraction` of the image (0 = top). `pixel_size_m` is a pixel's width by depth.
    pub fn place(
        &self,
        environment: &Environment,
        ray: &Ray,
        fraction: f32,
        pixel_size_m: impl Fn(f32) -> f32,
    ) -> BackdropPlace {
        match (&environment.room, &self.sunspot) {
            (Some(light), Some(sunspot)) => self.in_room(environment, light, sunspot, ray, pixel_size_m),
            _ => self.plain(environment, ray, fraction),
        }
    }

    /// Light from a place where this share of the key light reaches it.
    pub fn light(&self, place: &BackdropPlace, reaching: f32) -> Vec3 {
        self.tinted_light(place, Vec3::splat(reaching))
    }

    /// As [`Self::light`], with the share of each color.
    pub fn tinted_light(&self, place: &BackdropPlace, reaching: Vec3) -> Vec3 {
        let Some(Receiver { key, ambient, .. }) = place.receiver else { return place.color };
        place.color * ((key * reaching + ambient) * self.per_light).min(self.limit)
    }

    fn plain(&self, environment: &Environment, ray: &Ray, fraction: f32) -> BackdropPlace {
        let Background { top_color, bottom_color, floor, .. } = &self.background;
        let color = top_color.lerp(*bottom_color, fraction);
        let meeting = floor.and_then(|floor| {
            let t = (floor.z_m as f32 - ray.origin.z) / ray.direction.z;
            (t.is_finite() && t > 0.0).then(|| ray.origin + t * ray.direction)
        });
        let receiver = meeting.map(|point| {
            let lighting = &environment.lighting;
            let key = lighting.key_color * environment.toward_key.z.max(0.0);
            let ambient = self.floor_light.as_ref().map_or(lighting.sky_color, |light| light.at(point));
            Receiver { point, normal: Vec3A::Z, key, ambient }
        });
        BackdropPlace { color, receiver }
    }

    fn in_room(
        &self,
        environment: &Environment,
        light: &RoomLight,
        sunspot: &Sunspot,
        ray: &Ray,
        pixel_size_m: impl Fn(f32) -> f32,
    ) -> BackdropPlace {
        let room = &light.room;
        let (depth, normal) = farthest(room, ray);
        let point = ray.origin + depth * ray.direction;
        let facing = -ray.direction.dot(normal) / ray.direction.length();
        let footprint_m = pixel_size_m(depth) / facing.max(0.06).sqrt() + DEFOCUS_M;
        let height = point.z - room.floor_z_m as f32;
        let in_plan = Vec2::new(point.x, point.y);
        let lighting = &environment.lighting;
        let mut key = lighting.key_color * environment.toward_key.dot(normal).max(0.0);
        let (color, ambient);
        if normal.z > 0.5 {
            color = floor_reflectance(room, in_plan, footprint_m);
            let open = self.floor_light.as_ref().map_or(Vec3::ONE, |light| light.at(point));
            let (low, high) = (room.low_m.as_vec2(), room.high_m.as_vec2());
            let to_wall = (in_plan - low).min(high - in_plan).min_element();
            ambient = open * corner_shade(to_wall);
        } else {
            key *= WALL_SHARE * (BESIDE_SUNSPOT + (1.0 - BESIDE_SUNSPOT) * sunspot.share(point));
            let at = Vec2::new(in_plan.dot(Vec2::new(normal.y, normal.x)), height);
            let bare = wall_reflectance(room, at, footprint_m);
            let furnishing = self.furnishing.as_ref();
            color =
                furnishing.map_or(bare, |furnishing| furnishing.over(wall_of(normal), at, footprint_m, bare));
            ambient = light.on_wall(normal) * corner_shade(height) * (0.92 + 0.08 * (height / 1.2).min(1.0));
        }
        BackdropPlace { color, receiver: Some(Receiver { point, normal, key, ambient }) }
    }
}

/// Depth at which a ray leaves the room, and the inward normal of floor or wall there.
fn farthest(room: &Room, ray: &Ray) -> (f32, Vec3A) {
    let (low, high) = (room.low_m.as_vec2(), room.high_m.as_vec2());
    let along = |to: f32, from: f32, direction: f32| {
        let t = (to - from) / direction;
        if t.is_finite() && t > 0.0 { t } else { f32::INFINITY }
    };
    let (o, d) = (ray.origin, ray.direction);
    let x = along(if d.x > 0.0 { high.x } else { low.x }, o.x, d.x);
    let y = along(if d.y > 0.0 { high.y } else { low.y }, o.y, d.y);
    let z = if d.z < 0.0 { along(room.floor_z_m as f32, o.z, d.z) } else { f32::INFINITY };
    if z <= x && z <= y {
        (z, Vec3A::Z)
    } else if x <= y {
        (x, Vec3A::new(-d.x.signum(), 0.0, 0.0))
    } else {
        (y, Vec3A::new(0.0, -d.y.signum(), 0.0))
    }
}

/// Share of ambient light that is left this far from the edge between floor and wall.
fn corner_shade(distance_m: f32) -> f32 {
    1.0 - 0.3 / (1.0 + 9.0 * distance_m.max(0.0))
}

/// Reflectance of a wall at a position along it and above the floor.
fn wall_reflectance(room: &Room, at: Vec2, footprint_m: f32) -> Vec3 {
    let decor = &room.decor;
    let above = at.y - SKIRTING_M;
    let blur = 0.5 * footprint_m;
    let skirting = (0.5 - above / (2.0 * blur)).clamp(0.0, 1.0);
    let joint = (1.0 - (above - 0.5 * JOINT_M).abs() / (0.5 * JOINT_M + blur)).max(0.0)
        * (JOINT_M / (JOINT_M + 2.0 * blur));
    let plaster = 0.97 + 0.06 * value_noise(1.7 * at, room.seed);
    (plaster * decor.wall_color).lerp(decor.skirting_color, skirting) * (1.0 - 0.5 * joint)
}
