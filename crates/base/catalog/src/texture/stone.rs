//! Stone: veined marble, speckled granite.

use super::{Noise, draw_texture};
use geometry::Rgb;
use imaging::Texture;
use runtime::seed::Rng;

/// Marble of `color` with veins of `vein`, 256 px; repeats.
pub fn marble(color: Rgb, vein: Rgb, rng: &mut Rng) -> Texture {
    let octaves = [3, 7, 17].map(|n| Noise::new(n, n, rng));
    draw_texture(256, 256, |u, v| {
        let turbulence: f32 =
            octaves.iter().zip([1.0, 0.5, 0.2]).map(|(noise, weight)| weight * noise.at(u, v)).sum();
        let ridge = 1.0 - (2.0 * (1.5 * turbulence + u).fract() - 1.0).abs();
        let thin = (1.0 - 7.0 * ridge).max(0.0);
        color.mix(vein, 0.8 * thin * thin + 0.12 * octaves[0].at(v, u))
    })
}

/// Granite: grains of lighter and darker `color`, 256 px; repeats.
pub fn granite(color: Rgb, rng: &mut Rng) -> Texture {
    let (grain, patch) = (Noise::new(80, 80, rng), Noise::new(24, 24, rng));
    draw_texture(256, 256, |u, v| color.scaled(0.65 + 0.5 * grain.at(u, v) + 0.2 * patch.at(u, v)))
}
