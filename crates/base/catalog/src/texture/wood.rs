//! Wood: fine growth rings stretched along u (the grain's direction), pores, and boards.

use super::{Noise, draw_texture};
use geometry::Rgb;
use imaging::Texture;
use runtime::seed::Rng;

/// Wood of the given color with nearly straight grain, 256 px, grain along u; repeats.
pub fn wood_grain(color: Rgb, rng: &mut Rng) -> Texture {
    let grain = Grain::new(22.0, 96, rng);
    draw_texture(256, 256, |u, v| grain.color(color, u, v))
}

/// Boards side by side (`boards` along v), each with its own shade; 512 px, grain along u; repeats.
pub fn wood_planks(color: Rgb, boards: usize, rng: &mut Rng) -> Texture {
    let grains: Vec<Grain> = (0..boards).map(|_| Grain::new(72.0, 190, rng)).collect();
    let shades = Noise::new(1, boards, rng);
    draw_texture(512, 512, |u, v| {
        let across = v * boards as f32;
        let board = (across as usize).min(boards - 1);
        let edge = (across.fract() - 0.5).abs();
        let seam = if edge > 0.49 { 0.78 } else { 1.0 };
        let shade = 0.915 + 0.11 * shades.at(0.0, board as f32 / boards as f32);
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
        // The rings bend by a share of the texture, whatever their number.
        let at = v * self.rings + (1.0 + 0.09 * self.rings) * self.warp.at(u, v);
        let number = at.floor();
        let ring = at - number;
        // Earlywood darkens slowly to the latewood, which ends soon. No two rings are alike.
        let strength = 0.4 + 1.2 * self.tone.at(0.37 * number, 0.23 * number);
        let line = if ring < 0.82 { (ring / 0.82) * (ring / 0.82) } else { (1.0 - ring) / 0.18 };
        let fiber = self.fine.at(u, v);
        let pores = (self.fine.at(2.0 * u, 3.0 * v) - 0.68).max(0.0);
        let tone = self.tone.at(u, v) - 0.5;
        color.scaled(1.03 + 0.07 * tone + 0.05 * (fiber - 0.5) - 0.075 * strength * line - 0.3 * pores)
    }
}
