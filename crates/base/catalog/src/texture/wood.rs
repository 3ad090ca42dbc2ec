//! Wood: growth rings stretched along u (the grain's direction), pores, and boards.

use super::{Noise, draw_texture};
use geometry::Rgb;
use imaging::Texture;
use runtime::seed::Rng;

/// Plain-sawn wood of the given color, 256 px, grain along u; repeats.
pub fn wood_grain(color: Rgb, rng: &mut Rng) -> Texture {
    let grain = Grain::new(rng);
    draw_texture(256, 256, |u, v| grain.color(color, u, v))
}

/// Boards side by side (`boards` along v), each with its own shade; grain along u; repeats.
pub fn wood_planks(color: Rgb, boards: usize, rng: &mut Rng) -> Texture {
    let grains: Vec<Grain> = (0..boards).map(|_| Grain::new(rng)).collect();
    let shades = Noise::new(1, boards, rng);
    draw_texture(256, 256, |u, v| {
        let across = v * boards as f32;
        let board = (across as usize).min(boards - 1);
        let edge = (across.fract() - 0.5).abs();
        let seam = if edge > 0.485 { 0.62 } else { 1.0 };
        let shade = 0.86 + 0.22 * shades.at(0.0, board as f32 / boards as f32);
        grains[board].color(color, u, v).scaled(shade * seam)
    })
}

struct Grain {
    warp: Noise,
    fine: Noise,
    tone: Noise,
}

impl Grain {
    fn new(rng: &mut Rng) -> Self {
        Self { warp: Noise::new(3, 5, rng), fine: Noise::new(6, 96, rng), tone: Noise::new(2, 9, rng) }
    }

    fn color(&self, color: Rgb, u: f32, v: f32) -> Rgb {
        let rings = (v * 7.0 + 1.6 * self.warp.at(u, v)).fract();
        // Earlywood brightens slowly, latewood ends in a dark line.
        let line = (rings - 0.75).max(0.0) / 0.25;
        let pores = (self.fine.at(u, v) - 0.62).max(0.0);
        color.scaled(1.06 + 0.08 * (self.tone.at(u, v) - 0.5) - 0.2 * line * line - 0.55 * pores)
    }
}
