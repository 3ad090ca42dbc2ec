//! Skins, peels and crusts.

use rand::RngExt;

use super::{Noise, draw_texture};
use geometry::Rgb;
use imaging::Texture;
use runtime::seed::Rng;

/// Smooth skin: streaks from stem to base, a blush of `blush` on one side, paler dots; u repeats.
pub fn fruit_skin(color: Rgb, blush: Rgb, rng: &mut Rng) -> Texture {
    let (side, streak, dots) = (Noise::new(2, 2, rng), Noise::new(40, 3, rng), Noise::new(56, 40, rng));
    draw_texture(256, 128, |u, v| {
        let amount = (1.3 * side.at(u, v) - 0.6 + 0.5 * (streak.at(u, v) - 0.5)).clamp(0.0, 0.8);
        let dot = if dots.at(u, v) > 0.93 { 0.25 } else { 0.0 };
        color.mix(blush, amount).mix(Rgb([1.0, 0.95, 0.75]), dot)
    })
}

/// Dimpled peel; repeats.
pub fn citrus_peel(color: Rgb, rng: &mut Rng) -> Texture {
    let (pits, tone) = (Noise::new(110, 60, rng), Noise::new(5, 4, rng));
    draw_texture(256, 128, |u, v| {
        let pit = (pits.at(u, v) - 0.7).max(0.0);
        color.scaled(0.97 + 0.08 * tone.at(u, v) - 0.45 * pit)
    })
}

/// Banana peel along v: green-brown ends, fine brown lines and flecks along the fruit; u repeats.
pub fn banana_skin(color: Rgb, rng: &mut Rng) -> Texture {
    let (fleck, line) = (Noise::new(24, 30, rng), Noise::new(30, 4, rng));
    let brown = Rgb([0.32, 0.2, 0.08]);
    draw_texture(128, 256, |u, v| {
        let tip = (1.0 - v / 0.05).max(0.0).max((v - 0.9) / 0.1).clamp(0.0, 1.0);
        let spot = if fleck.at(u, v) > 0.88 { 0.6 } else { 0.0 };
        let streak = (line.at(u, v) - 0.75).max(0.0);
        color.mix(Rgb([0.55, 0.6, 0.15]), 0.6 * tip).mix(brown, (spot + streak + tip * tip * 0.8).min(0.9))
    })
}

/// Baked crust: brown in the center, paler toward `pale`, floury patches; repeats.
pub fn crust(brown: Rgb, pale: Rgb, rng: &mut Rng) -> Texture {
    let (broad, fine) = (Noise::new(5, 5, rng), Noise::new(40, 40, rng));
    draw_texture(256, 256, |u, v| {
        let mixed = brown.mix(pale, (0.9 * broad.at(u, v) - 0.1).clamp(0.0, 1.0));
        mixed.scaled(0.88 + 0.22 * fine.at(u, v))
    })
}

/// Icing of `base` with short bright sprinkles, 256 px.
pub fn sprinkles(base: Rgb, count: usize, rng: &mut Rng) -> Texture {
    let colors = [0xf2_d0_3b, 0x4f_b4_e0, 0xf4_f0_ea, 0x6c_c0_56, 0xe0_4f_6d].map(Rgb::hex);
    let sticks: Vec<(f32, f32, f32, Rgb)> = (0..count)
        .map(|_| {
            let angle = rng.random_range(0.0..std::f32::consts::PI);
            let pick = rng.random_range(0..colors.len());
            (rng.random_range(0.0..1.0), rng.random_range(0.0..1.0), angle, colors[pick])
        })
        .collect();
    draw_texture(256, 256, |u, v| {
        let hit = sticks.iter().find(|(su, sv, angle, _)| {
            let (dx, dy) = (u - su, v - sv);
            let along = dx * angle.cos() + dy * angle.sin();
            let across = dy * angle.cos() - dx * angle.sin();
            along.abs() < 0.026 && across.abs() < 0.009
        });
        hit.map_or(base, |stick| stick.3)
    })
}
