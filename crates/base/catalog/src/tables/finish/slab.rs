//! Tabletops of stone, concrete and tiles. Each image covers [`METERS_PER_REPEAT`] and repeats.

use std::f32::consts::TAU;

use rand::RngExt;

use crate::tables::grain::METERS_PER_REPEAT;
use crate::texture::{Noise, draw_texture};
use geometry::Rgb;
use imaging::{Image, Texture};
use runtime::seed::Rng;

/// Marble of `color` with long veins of `vein` that widen and fade: [`crate::texture::marble`] at the scale of a
/// tabletop, so that no vein of it comes twice. 512 x 384 px; repeats.
pub fn marble_slab(color: Rgb, vein: Rgb, rng: &mut Rng) -> Texture {
    let [warp, bend, grain] =
        [(9, 6), (24, 16), (78, 52)].map(|(columns, rows)| Noise::new(columns, rows, rng));
    let [cross_warp, cross_bend] = [(9, 6), (24, 16)].map(|(columns, rows)| Noise::new(columns, rows, rng));
    let [strong, weak] = [(10, 7), (12, 8)].map(|(columns, rows)| Noise::new(columns, rows, rng));
    // The phase runs along whole numbers of turns, so that the image repeats.
    let line = |phase: f32, width: f32| (1.0 - 2.0 * (phase.rem_euclid(1.0) - 0.5).abs() / width).max(0.0);
    draw_texture(512, 384, |u, v| {
        let (warp, grain) = (warp.at(u, v), 0.05 * grain.at(u, v));
        let bent = 0.42 * warp + 0.16 * bend.at(u, v) + grain;
        let cross_bent = 0.42 * cross_warp.at(u, v) + 0.16 * cross_bend.at(u, v) + grain;
        let (strong, weak) = (strong.at(u, v), weak.at(u, v));
        let main = strong * line(5.0 * u + 2.0 * v + bent, 0.03 + 0.09 * strong * strong);
        let fine = 0.5 * weak * line(5.0 * v - 3.0 * u + cross_bent, 0.02 + 0.03 * weak);
        color.mix(vein, (0.75 * main + 0.6 * fine + 0.14 * warp).min(0.9))
    })
}

/// Size of an image of stone, pixels along u and v.
const STONE_PX: [u32; 2] = [768, 512];
/// Size of an image of granite, whose grains are finer.
const GRANITE_PX: [u32; 2] = [1152, 768];

/// Granite of about that color: light feldspar, gray quartz and dark mica in grains of a few millimeters.
pub fn granite_slab(color: Rgb, rng: &mut Rng) -> Texture {
    let [feldspar, quartz, mica] =
        [(520, 346), (640, 426), (470, 313)].map(|(columns, rows)| Noise::new(columns, rows, rng));
    let cloud = Noise::new(9, 6, rng);
    let (light, dark) = (color.mix(Rgb([0.95, 0.92, 0.88]), 0.45), color.scaled(0.3));
    let [width, height] = GRANITE_PX;
    draw_texture(width, height, |u, v| {
        let cloud = 0.12 * (cloud.at(u, v) - 0.5);
        let of_light = 3.0 * (feldspar.at(u, v) + cloud - 0.6);
        let of_dark = 4.0 * (mica.at(u, v) - cloud - 0.66);
        let grain = color.scaled(0.88 + 0.24 * quartz.at(u, v));
        grain.mix(light, of_light.clamp(0.0, 0.6)).mix(dark, of_dark.clamp(0.0, 0.75))
    })
}

/// Poured concrete, ground smooth: clouds, a fine grain and a few pores.
pub fn concrete_slab(color: Rgb, rng: &mut Rng) -> Texture {
    let [broad, cloud, grain, pores] =
        [(5, 4), (17, 12), (300, 200), (190, 130)].map(|(columns, rows)| Noise::new(columns, rows, rng));
    let [width, height] = STONE_PX;
    draw_texture(width, height, |u, v| {
        let tone =
            0.11 * (broad.at(u, v) - 0.5) + 0.09 * (cloud.at(u, v) - 0.5) + 0.06 * (grain.at(u, v) - 0.5);
        let pore = (9.0 * (pores.at(u, v) - 0.955)).clamp(0.0, 0.4);
        color.scaled((1.0 + tone) * (1.0 - pore))
    })
}

/// Colors of the chips of terrazzo; the first is drawn most often.
const CHIPS: [u32; 5] = [0x8f_86_7a, 0xc9_b8_9c, 0x5c_5a_58, 0xa8_6f_55, 0x7d_8b_84];
/// Number of chips in 1.8 x 1.2 m.
const CHIP_COUNT: usize = 5200;

/// Terrazzo: angular chips of stone, 4 to 20 mm across, in cement of that color.
pub fn terrazzo_slab(color: Rgb, rng: &mut Rng) -> Texture {
    let grain = Noise::new(300, 200, rng);
    let [width, height] = STONE_PX;
    let mut image = Image::filled(width, height, [255; 4]);
    for y in 0..height {
        for x in 0..width {
            let tone = grain.at(x as f32 / width as f32, y as f32 / height as f32);
            image.set_pixel(x, y, color.scaled(0.98 + 0.04 * tone).to_rgba8());
        }
    }
    let px_per_mm = width as f32 / (1000.0 * METERS_PER_REPEAT.x as f32);
    for _ in 0..CHIP_COUNT {
        let kind = rng.random_range(0..CHIPS.len()).min(rng.random_range(0..CHIPS.len()));
        let tone = Rgb::hex(CHIPS[kind]).scaled(rng.random_range(0.85..1.15));
        let radius_px = px_per_mm * 2.0 * 5.0_f32.powf(rng.random_range(0.0_f32..1.0).powi(2));
        let center = [width, height].map(|side| rng.random_range(0.0..side as f32));
        // A polygon as half planes at irregular distances.
        let first = rng.random_range(0.0..TAU);
        let sides: Vec<(f32, f32, f32)> = (0..6)
            .map(|k| {
                let (sin, cos) = (first + TAU * (k as f32 + rng.random_range(-0.3..0.3)) / 6.0).sin_cos();
                (cos, sin, radius_px * rng.random_range(0.6..1.0))
            })
            .collect();
        let reach = radius_px.ceil() as i32 + 1;
        for (dx, dy) in (-reach..=reach).flat_map(|dy| (-reach..=reach).map(move |dx| (dx, dy))) {
            let outside = sides.iter().map(|(x, y, far)| x * dx as f32 + y * dy as f32 - far);
            let share = (0.5 - outside.fold(f32::NEG_INFINITY, f32::max)).clamp(0.0, 1.0);
            if share > 0.0 {
                let x = (center[0] as i32 + dx).rem_euclid(width as i32) as u32;
                let y = (center[1] as i32 + dy).rem_euclid(height as i32) as u32;
                let [r, g, b, _] = image.pixel(x, y).map(|byte| f32::from(byte) / 255.0);
                image.set_pixel(x, y, Rgb([r, g, b]).mix(tone, share).to_rgba8());
            }
        }
    }
    Texture::new(image)
}

/// Number of tiles along u and v, so that each is 150 mm square, and the width of a joint as a share of a tile.
const TILES: [u32; 2] = [12, 8];
const JOINT: f32 = 0.022;
const GROUT: Rgb = Rgb([0.66, 0.64, 0.6]);

/// Glazed tiles of that color, each a little different, with their joints.
pub fn tiles(color: Rgb, rng: &mut Rng) -> Texture {
    let tones: Vec<Rgb> =
        (0..TILES[0] * TILES[1]).map(|_| color.scaled(rng.random_range(0.955..1.02))).collect();
    let [glaze, grain] = [(40, 27), (300, 200)].map(|(columns, rows)| Noise::new(columns, rows, rng));
    let [width, height] = STONE_PX;
    draw_texture(width, height, |u, v| {
        let (x, y) = (u * TILES[0] as f32, v * TILES[1] as f32);
        let (column, row) = ((x as u32).min(TILES[0] - 1), (y as u32).min(TILES[1] - 1));
        let (x, y) = (x - column as f32, y - row as f32);
        let edge = x.min(1.0 - x).min(y).min(1.0 - y);
        if edge < 0.5 * JOINT {
            return GROUT.scaled(0.92 + 0.16 * grain.at(u, v));
        }
        // The glaze is thinner, and lighter, along its edge.
        let rim = (1.0 - (edge - 0.5 * JOINT) / 0.03).clamp(0.0, 1.0);
        tones[(row * TILES[0] + column) as usize].scaled(0.985 + 0.03 * glaze.at(u, v) + 0.025 * rim)
    })
}
