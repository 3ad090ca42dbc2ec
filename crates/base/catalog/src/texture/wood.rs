//! Wood: growth rings stretched along u (the grain's direction), pores, and boards.

use super::{Noise, draw_texture};
use geometry::Rgb;
use imaging::Texture;
use runtime::seed::Rng;

/// Plain-sawn wood of the given color, 256 px, grain along u; repeats.
pub fn wood_grain(color: Rgb, rng: &mut Rng) -> Texture {
    let grain = Grain::new(7.0, 96, rng);
    draw_texture(256, 256, |u, v| grain.color(color, u, v))
}

/// Boards side by side (`boards` along v), each with its own shade; 512 px, grain along u; repeats.
pub fn wood_planks(color: Rgb, boards: usize, rng: &mut Rng) -> Texture {
    let grains: Vec<Grain> = (0..boards).map(|_| Grain::new(24.0, 190, rng)).collect();
    let shades = Noise::new(1, boards, rng);
    draw_texture(512, 512, |u, v| {
        let across = v * boards as f32;
        let board = (across as usize).min(boards - 1);
        let edge = (across.fract() - 0.5).abs();
        let seam = if edge > 0.488 { 0.7 } else { 1.0 };
        let shade = 0.9 + 0.14 * shades.at(0.0, board as f32 / boards as f32);
        grains[board].color(color, u, v).scaled(shade * seam)
    })
}

struct Grain {
    /// Growth rings across the texture.
    rings: f32,
    warp: Noise,
    fine: Noise,
    tone: Noise,
}

impl Grain {
    /// `pores` is the number of rows of pores across the texture.
    fn new(rings: f32, pores: usize, rng: &mut Rng) -> Self {
        let (warp, fine, tone) =
            (Noise::new(3, 5, rng), Noise::new(pores / 12, pores, rng), Noise::new(2, 9, rng));
        Self { rings, warp, fine, tone }
    }

    fn color(&self, color: Rgb, u: f32, v: f32) -> Rgb {
        let rings = (v * self.rings + (1.0 + 0.1 * self.rings) * self.warp.at(u, v)).fract();
        // Earlywood darkens slowly to the latewood, which ends at once.
        let line = (rings - 0.5).max(0.0) / 0.5;
        let pores = (self.fine.at(u, v) - 0.66).max(0.0);
        color.scaled(1.04 + 0.08 * (self.tone.at(u, v) - 0.5) - 0.14 * line * line - 0.4 * pores)
    }
}
