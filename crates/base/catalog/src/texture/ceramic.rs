//! Glazes: speckled stoneware, bands and stripes.

use rand::RngExt;

use super::{Noise, draw_texture};
use geometry::Rgb;
use imaging::Texture;
use runtime::seed::Rng;

/// A glaze with darker iron specks, 256 px; repeats.
pub fn ceramic_speckle(color: Rgb, rng: &mut Rng) -> Texture {
    let (cloud, specks) = (Noise::new(4, 4, rng), Noise::new(64, 64, rng));
    draw_texture(256, 256, |u, v| {
        let speck = 1.0 - 0.5 * ((specks.at(u, v) - 0.86) / 0.06).clamp(0.0, 1.0);
        color.scaled((0.96 + 0.07 * cloud.at(u, v)) * speck)
    })
}

/// `color` with a band of `band` between heights `low` and `high` (v, 0..1), and a slightly wavy edge.
pub fn glaze_band(color: Rgb, band: Rgb, low: f32, high: f32, rng: &mut Rng) -> Texture {
    let wave = Noise::new(9, 1, rng);
    draw_texture(256, 256, |u, v| {
        let shift = 0.03 * (wave.at(u, 0.0) - 0.5);
        if (low + shift..high + shift).contains(&v) { band } else { color }
    })
}

/// `color` with `count` thin lines of `line` between v = `low` and `high`.
pub fn striped_band(color: Rgb, line: Rgb, low: f32, high: f32, count: usize, rng: &mut Rng) -> Texture {
    let width = rng.random_range(0.3..0.5_f32);
    draw_texture(64, 256, |_, v| {
        let along = (v - low) / (high - low) * count as f32;
        if (0.0..count as f32).contains(&along) && along.fract() < width { line } else { color }
    })
}
