//! Landscapes, the map of the earth, leaves, soil, boards.

use rand::RngExt;

use super::PrintOrder;
use super::continents::is_land;
use crate::texture::{Noise, draw_texture, wood_grain, wood_planks};
use geometry::Rgb;
use imaging::{Image, Texture};
use runtime::seed::Rng;

/// Sky with a sun, layers of mountains, and water.
pub(super) struct View {
    far: Noise,
    near: Noise,
    sky: Rgb,
    land: Rgb,
    /// Width by height of the image.
    aspect: f32,
}

impl View {
    /// A view of random colors in an image of this width by height.
    pub fn random(aspect: f32, rng: &mut Rng) -> Self {
        const COLORS: [(u32, u32); 4] = [
            (0x4f_9f_dc, 0x3c_7a_48),
            (0xe0_8a_5a, 0x5a_3f_66),
            (0x6f_b8_c8, 0x2f_5f_70),
            (0x5a_78_d0, 0x2f_6a_58),
        ];
        let (far, near) = (Noise::new(5, 2, rng), Noise::new(4, 2, rng));
        let (sky, land) = COLORS[rng.random_range(0..COLORS.len())];
        Self { far, near, sky: Rgb::hex(sky), land: Rgb::hex(land), aspect }
    }

    /// Colors of the sky and the land.
    pub fn colors(&self) -> (Rgb, Rgb) {
        (self.sky, self.land)
    }

    pub fn at(&self, u: f32, v: f32) -> Rgb {
        let ridge = 0.42 + 0.3 * self.far.at(u, 0.1) + 0.03 * self.near.at(3.0 * u, 0.3);
        let hill = 0.22 + 0.22 * self.near.at(u, 0.6);
        if v < 0.16 {
            self.sky.scaled(0.75 + 0.08 * (v * 160.0).sin())
        } else if v < hill {
            self.land.scaled(0.7 + 0.3 * (v - 0.16) / (hill - 0.16))
        } else if v < ridge {
            self.land.mix(self.sky, 0.55)
        } else {
            let sun = ((u - 0.72) * self.aspect).hypot(v - 0.78);
            let glow = Rgb([1.0, 0.95, 0.75]);
            let low = 0.75 * (1.0 - (v - 0.4) / 0.7).clamp(0.0, 1.0);
            if sun < 0.075 { glow } else { self.sky.mix(glow, low) }
        }
    }
}

/// A photograph of a landscape; 256 px.
pub(super) fn landscape(order: &mut PrintOrder) -> Texture {
    let view = View::random(1.0, order.rng);
    draw_texture(256, 256, |u, v| view.at(u, v))
}

/// A map of the earth with the sea in the ground's color, longitude along u and latitude along v; 512 x 256
/// px.
pub(super) fn world_map(order: &mut PrintOrder) -> Texture {
    let tone = Noise::new(12, 8, order.rng);
    let sea = order.ground;
    draw_texture(512, 256, |u, v| {
        let (longitude, latitude) = (360.0 * u - 180.0, 180.0 * v - 90.0);
        let wobble = 4.0 * (tone.at(u, v) - 0.5);
        let is_grid = (longitude / 30.0 + 12.0).fract() < 0.02 || (latitude / 30.0 + 6.0).fract() < 0.03;
        if !(-70.0..=80.0).contains(&latitude) {
            Rgb::hex(0xee_ee_ea)
        } else if is_land(longitude + wobble, latitude - wobble) {
            let dry = (1.0 - (latitude.abs() - 23.0).abs() / 22.0).clamp(0.0, 1.0);
            Rgb::hex(0x62_9a_4a).mix(Rgb::hex(0xd2_b4_6c), dry * 0.85).scaled(0.9 + 0.2 * tone.at(v, u))
        } else if is_grid {
            sea.scaled(1.25)
        } else {
            sea
        }
    })
}

/// A leaf with a midrib along v and side veins; 64 x 128 px.
pub(super) fn leaf(order: &mut PrintOrder) -> Texture {
    let tone = Noise::new(3, 6, order.rng);
    draw_texture(64, 128, |u, v| {
        let across = (u - 0.5).abs();
        let is_vein = ((v - 0.9 * across) * 9.0).rem_euclid(1.0) < 0.12 || across < 0.03;
        order.ground.scaled(0.86 + 0.25 * tone.at(u, v) + if is_vein { 0.22 } else { 0.0 })
    })
}

/// Crumbs of soil with a few light grains; 256 px, repeats.
pub(super) fn soil(order: &mut PrintOrder) -> Texture {
    let (clods, crumbs) = (Noise::new(22, 22, order.rng), Noise::new(70, 70, order.rng));
    let grains = Noise::new(48, 48, order.rng);
    draw_texture(256, 256, |u, v| {
        let soil = order.ground.scaled(0.55 + 0.35 * clods.at(u, v) + 0.4 * crumbs.at(u, v));
        soil.mix(Rgb::hex(0xd8_d0_c0), ((grains.at(u, v) - 0.965) * 25.0).clamp(0.0, 0.8))
    })
}

/// Wood of the ground's color with its grain along v, which is the axis of turned parts; 256 px, repeats.
pub(super) fn grain(order: &mut PrintOrder) -> Texture {
    let wood = wood_grain(order.ground, order.rng);
    let mut image = Image::filled(wood.height_px(), wood.width_px(), [0; 4]);
    for y in 0..wood.height_px() {
        for x in 0..wood.width_px() {
            image.set_pixel(y, x, wood.pixel(x, y));
        }
    }
    Texture::new(image)
}

/// `count` boards side by side along v with their grain along u; 512 px, repeats.
pub(super) fn planks(order: &mut PrintOrder) -> Texture {
    wood_planks(order.ground, order.count.unwrap_or(4).clamp(1, 24) as usize, order.rng)
}
