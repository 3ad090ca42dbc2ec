//! Speckled stoneware.

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
