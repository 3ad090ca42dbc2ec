//! Light and backdrop of an image. All colors here are linear light; 1 is white paper in full light.

use glam::{DVec3, Vec3};

use crate::forward::room_light::RoomLight;
use crate::room::Room;

/// One soft key light, a sky and a ground, all at infinity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lighting {
    /// Unit, from the scene toward the light, in the world.
    pub toward_key: DVec3,
    /// Light a surface that faces the key receives from it (1 = a white surface becomes 1).
    pub key_color: Vec3,
    /// Half the angle under which the light is seen, radians, 0..0.5; 0 = hard shadows.
    pub key_radius_rad: f64,
    /// Light from straight above and from straight below; in between they mix by the normal.
    pub sky_color: Vec3,
    pub ground_color: Vec3,
    /// Multiplies everything before tone mapping; 1 = as is.
    pub exposure: f32,
}

impl Lighting {
    /// A studio: one warm soft box, a cool ceiling, a light floor. The key stands at `azimuth_rad`
    /// (0 = at the front edge, pi/2 = at +x, as cameras count) and `elevation_rad` above the horizon;
    /// `softness` 0 = a bare bulb, 1 = a large soft box.
    pub fn studio(azimuth_rad: f64, elevation_rad: f64, softness: f64) -> Self {
        let toward_key = DVec3::new(
            azimuth_rad.sin() * elevation_rad.cos(),
            -azimuth_rad.cos() * elevation_rad.cos(),
            elevation_rad.sin(),
        );
        Self {
            toward_key,
            key_color: Vec3::new(0.66, 0.64, 0.60),
            key_radius_rad: 0.01 + 0.16 * softness.clamp(0.0, 1.0),
            sky_color: Vec3::new(0.52, 0.54, 0.57),
            ground_color: Vec3::new(0.24, 0.235, 0.23),
            exposure: 1.0,
        }
    }

    /// Sunlight through a window of a [`Room`], from where [`Self::studio`] has its soft box.
    pub fn daylight(azimuth_rad: f64, elevation_rad: f64) -> Self {
        let studio = Self::studio(azimuth_rad, elevation_rad, 0.28);
        Self { key_color: Vec3::new(1.12, 1.06, 0.96), ..studio }
    }

    /// The same light with the exposure that the tabletop of a room needs.
    pub fn exposed_for(self, room: &Room) -> Self {
        Self { exposure: RoomLight::new(*room, &self).exposure(), ..self }
    }
}

/// Background: a vertical gradient, and optionally a floor that blends into it; or a room.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Background {
    /// At the top and at the bottom edge of the image, linear light.
    pub top_color: Vec3,
    pub bottom_color: Vec3,
    /// A floor that shows shadows.
    pub floor: Option<Floor>,
    /// A room instead of gradient and floor. It lights the scene, too, in place of [`Lighting::sky_color`] and
    /// [`Lighting::ground_color`].
    pub room: Option<Room>,
}

/// A horizontal plane in the backdrop's color that only receives shadows: it has no depth, no normal and id 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Floor {
    /// World height, meters.
    pub z_m: f64,
}

impl Background {
    /// A plain light backdrop without a floor.
    pub fn light() -> Self {
        Self {
            top_color: Vec3::new(0.80, 0.81, 0.83),
            bottom_color: Vec3::new(0.66, 0.66, 0.665),
            floor: None,
            room: None,
        }
    }

    /// A plain light backdrop on whose floor the scene throws its shadow.
    pub fn light_with_floor(z_m: f64) -> Self {
        Self { floor: Some(Floor { z_m }), ..Self::light() }
    }

    /// A room around the scene.
    pub fn in_room(room: Room) -> Self {
        Self { room: Some(room), ..Self::light() }
    }

    /// World height of the floor, if there is one, meters.
    pub(crate) fn floor_z_m(&self) -> Option<f64> {
        self.room.map(|room| room.floor_z_m).or(self.floor.map(|floor| floor.z_m))
    }
}
