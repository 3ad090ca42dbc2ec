//! Stone: veined marble, speckled granite.

use super::{Noise, draw_texture};
use geometry::Rgb;
use imaging::Texture;
use runtime::seed::Rng;

/// Marble of `color` with long veins of `vein` in two directions that widen and fade, 256 px; repeats.
pub fn marble(color: Rgb, vein: Rgb, rng: &mut Rng) -> Texture {
    let [warp, bend, grain, fade] = [3, 8, 26, 4].map(|n| Noise::new(n, n, rng));
    // The phase runs along whole numbers of turns, so that the image repeats; the noise bends its lines without closing
    // them to loops.
    let line = |phase: f32, width: f32| (1.0 - 2.0 * (phase.rem_euclid(1.0) - 0.5).abs() / width).max(0.0);
    draw_texture(256, 256, |u, v| {
        let bent = |u: f32, v: f32| 0.42 * warp.at(u, v) + 0.16 * bend.at(u, v) + 0.05 * grain.at(u, v);
        let (strong, weak) = (fade.at(u, v), fade.at(v, u));
        let main = strong * line(2.0 * u + v + bent(u, v), 0.03 + 0.09 * strong * strong);
        let fine = 0.5 * weak * line(3.0 * v - u + bent(v, u), 0.02 + 0.03 * weak);
        color.mix(vein, (0.75 * main + 0.6 * fine + 0.14 * warp.at(u, v)).min(0.9))
    })
}

/// Granite: grains of lighter and darker `color`, 256 px; repeats.
pub fn granite(color: Rgb, rng: &mut Rng) -> Texture {
    let (grain, patch) = (Noise::new(80, 80, rng), Noise::new(24, 24, rng));
    draw_texture(256, 256, |u, v| color.scaled(0.65 + 0.5 * grain.at(u, v) + 0.2 * patch.at(u, v)))
}
