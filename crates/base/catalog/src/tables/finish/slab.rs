//! Tabletops of one slab of marble.

use crate::texture::{Noise, draw_texture};
use geometry::Rgb;
use imaging::Texture;
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
