//! Woven materials: cloth and wicker.

use std::f32::consts::PI;

use super::{Noise, draw_texture};
use geometry::Rgb;
use imaging::Texture;
use runtime::seed::Rng;

/// Plain-woven cloth, 128 px, 16 threads each way; repeats.
pub fn fabric_weave(color: Rgb, rng: &mut Rng) -> Texture {
    let slub = Noise::new(16, 16, rng);
    draw_texture(128, 128, |u, v| {
        color.scaled(woven(u * 16.0, v * 16.0, 0.22) * (0.95 + 0.1 * slub.at(u, v)))
    })
}

/// Basketwork, 256 px, `strands` withies across; repeats for even counts.
pub fn wicker(color: Rgb, strands: usize, rng: &mut Rng) -> Texture {
    let tone = Noise::new(strands, strands, rng);
    let n = strands as f32;
    draw_texture(256, 256, |u, v| color.scaled(woven(u * n, v * n, 0.6) * (0.85 + 0.25 * tone.at(u, v))))
}

/// Brightness of a plain weave: the thread on top alternates, each is round.
fn woven(x: f32, y: f32, depth: f32) -> f32 {
    let across = if (x.floor() + y.floor()) as i64 % 2 == 0 { x.fract() } else { y.fract() };
    1.0 + 0.1 * depth - depth * (1.0 - (PI * across).sin())
}
