//! From linear light to sRGB.

use glam::Vec3;

use super::lit_band::PixelLight;
use super::tone::compress;
use imaging::srgb::SrgbEncoder;

/// Turns light into sRGB, highlights bent first. Neighbors in a row often have the same light (a plain backdrop, a
/// surface in the shade), and what was found for one holds for the next.
#[derive(Default)]
pub struct Film {
    /// Of even and of odd rows, since both are exposed in turn.
    last: [Option<(Vec3, [u8; 4])>; 2],
    srgb: SrgbEncoder,
}

impl Film {
    /// sRGB of a pixel in that row.
    pub fn exposed(&mut self, row: usize, light: &PixelLight) -> [u8; 4] {
        let srgb = self.srgb;
        let developed = |c: Vec3| [srgb.byte(c.x), srgb.byte(c.y), srgb.byte(c.z), 255];
        let color = match light {
            PixelLight::Even(color) => *color,
            PixelLight::Uneven(colors) if colors.iter().all(|color| *color == colors[0]) => colors[0],
            PixelLight::Uneven(colors) => {
                let sum: Vec3 = colors.iter().map(|color| compress(*color)).sum();
                return developed(sum * (1.0 / colors.len() as f32));
            }
        };
        match self.last[row % 2] {
            Some((known, bytes)) if known == color => bytes,
            _ => {
                let bytes = developed(compress(color));
                self.last[row % 2] = Some((color, bytes));
                bytes
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use imaging::srgb::encode_srgb;

    #[test]
    fn what_is_remembered_is_what_is_found() {
        let lights = [0.2, 0.2, 0.9, 0.2, 0.9, 1.4].map(Vec3::splat);
        let mut film = Film::default();
        for (row, color) in [0, 0, 1, 0, 1, 2].into_iter().zip(lights) {
            let fresh = Film::default().exposed(row, &PixelLight::Even(color));
            assert_eq!(film.exposed(row, &PixelLight::Even(color)), fresh);
            assert_eq!(film.exposed(row, &PixelLight::Uneven(&[color; 4])), fresh);
        }
        // Half in the dark: each sample is bent before the mean.
        let half = [Vec3::ZERO, Vec3::splat(4.0)];
        let mean = encode_srgb(0.5 * compress(half[1]).x);
        assert_eq!(film.exposed(0, &PixelLight::Uneven(&half)), [mean, mean, mean, 255]);
    }
}
