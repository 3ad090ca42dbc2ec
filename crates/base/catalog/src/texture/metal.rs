//! Brushed metal: fine streaks along u.

use super::{Noise, draw_texture};
use geometry::Rgb;
use imaging::Texture;
use runtime::seed::Rng;

/// Streaked metal of the given color, 128 px; repeats.
pub fn brushed_metal(color: Rgb, rng: &mut Rng) -> Texture {
    let (fine, broad) = (Noise::new(2, 64, rng), Noise::new(2, 9, rng));
    draw_texture(128, 128, |u, v| color.scaled(0.93 + 0.1 * fine.at(u, v) + 0.05 * broad.at(u, v)))
}
