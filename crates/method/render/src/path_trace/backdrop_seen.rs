//! End of a ray that meets no object: the backdrop for the eye, the room for light on its way.
//!
//! The eye sees the backdrop of the forward renderer with its floor and near walls. Rays prepare shadows and ambient
//! light on the floor, which is a matte plane, as they do on objects. On walls the ambient light is the forward
//! renderer's, less what objects hide. Light on its way sees the same floor, and above the horizon the room that lights
//! the forward renderer; beyond [`NEAR_FLOOR_M`] from the scene the floor has its mean color and light.

use glam::{Vec2, Vec3, Vec3A};

use super::walk::EyeRay;
use crate::forward::backdrop::{Backdrop, Ray};
use crate::forward::environment::Environment;
use crate::forward::room_light::WALL_SHARE;
use crate::forward::scene_buffers::SceneBuffers;
use crate::forward::sky::OPEN_SKY;
use crate::{Background, Lighting};

/// Distance beyond the floor plan up to which light on its way sees the floor's pattern and shadows, meters.
const NEAR_FLOOR_M: f32 = 2.0;

/// The backdrop with its light.
pub struct BackdropSeen {
    /// With an exposure of one.
    pub environment: Environment<'static>,
    backdrop: Backdrop,
    /// The eye's exposure.
    exposure: f32,
}

/// End of a ray that meets no object.
pub enum BackdropHit {
    /// Radiance that nothing shades.
    Light(Vec3),
    /// The sky's, or the key light.
    Sky,
    /// A matte surface.
    Matte {
        point: Vec3A,
        normal: Vec3A,
        /// Light of the key that it reflects where nothing is in the way.
        key: Vec3,
        /// Reflectance for all other light.
        ambient: Vec3,
        /// Radiance of a direction in which there is no object, if it is the same for all.
        open: Option<Vec3>,
    },
}

impl BackdropSeen {
    pub fn new(scene_buffers: &SceneBuffers, lighting: Lighting, background: Background) -> Self {
        let exposure = lighting.exposure;
        let lighting = Lighting { exposure: 1.0, ..lighting };
        // No map of shadows: rays find them.
        let environment = Environment::new(scene_buffers, &OPEN_SKY, lighting, 0).in_room(background.room);
        let backdrop = Backdrop::new(background, &environment, None);
        Self { environment, backdrop, exposure }
    }

    pub fn is_room(&self) -> bool {
        self.environment.room.is_some()
    }

    /// The backdrop that the eye sees, past glass if there is some.
    pub fn ahead(&self, ray: &Ray, eye: &EyeRay) -> BackdropHit {
        // Half a pixel: the samples of a pixel average it, too.
        let [constant, per_depth] = eye.pixel_size_m;
        let footprint_m = |depth: f32| 0.5 * (constant + per_depth * depth);
        let place = self.backdrop.place(&self.environment, ray, eye.fraction, footprint_m);
        let Some(receiver) = &place.receiver else {
            return BackdropHit::Light(self.backdrop.light(&place, 1.0) / self.exposure_of_plain());
        };
        let (point, normal) = (receiver.point, receiver.normal);
        let unlit = self.backdrop.light(&place, 0.0);
        let key = self.backdrop.light(&place, 1.0) - unlit;
        let Some(room) = &self.environment.room else {
            let lighting = &self.environment.lighting;
            let per_light =
                self.backdrop.light(&place, 1.0) * self.backdrop.per_light / self.exposure_of_plain();
            let key = lighting.key_color * self.environment.toward_key.z.max(0.0);
            return BackdropHit::Matte {
                point,
                normal,
                key: per_light * key,
                ambient: per_light,
                open: None,
            };
        };
        if normal.z > 0.5 {
            return BackdropHit::Matte { point, normal, key, ambient: unlit, open: None };
        }
        let open = room.on_wall(normal);
        let ambient = WALL_SHARE * unlit / open.max(Vec3::splat(1e-4));
        BackdropHit::Matte { point, normal, key, ambient, open: Some(open / WALL_SHARE) }
    }

    /// The surroundings that light on its way meets.
    pub fn around(&self, origin: Vec3A, direction: Vec3A) -> BackdropHit {
        let Some(light) = &self.environment.room else { return BackdropHit::Sky };
        if direction.z >= 0.0 {
            return BackdropHit::Sky;
        }
        let room = &light.room;
        let distance = (room.floor_z_m as f32 - origin.z) / direction.z;
        let point = origin + distance * direction;
        let at = Vec2::new(point.x, point.y);
        let (low, high) = (room.low_m.as_vec2() - NEAR_FLOOR_M, room.high_m.as_vec2() + NEAR_FLOOR_M);
        if distance <= 0.0 || !(at.cmpge(low).all() && at.cmple(high).all()) {
            return BackdropHit::Light(light.open_floor);
        }
        let down = Ray { origin: point + 0.1 * Vec3A::Z, direction: Vec3A::NEG_Z };
        let place = self.backdrop.place(&self.environment, &down, 0.5, |_| 0.0);
        let ambient = self.backdrop.light(&place, 0.0);
        let key = self.backdrop.light(&place, 1.0) - ambient;
        BackdropHit::Matte { point, normal: Vec3A::Z, key, ambient, open: None }
    }

    /// Divisor of what is not to be exposed: a plain backdrop keeps its colors.
    fn exposure_of_plain(&self) -> f32 {
        if self.is_room() { 1.0 } else { self.exposure }
    }
}
