//! Conversion of linear light to sRGB.

use glam::Vec3;

use super::shade_band::PixelLight;
use super::tone_curve::ToneCurve;
use imaging::srgb::SrgbEncoder;

/// Converts light to sRGB after compressing highlights. Neighbors in a row often have equal light (a plain backdrop, a
/// surface in the shade), so the last result is cached.
#[derive(Default)]
pub struct ToneMapper {
    /// Last light and its bytes, for even and for odd rows, since rows are converted in pairs.
    last: [Option<(Vec3, [u8; 4])>; 2],
    curve: ToneCurve,
    srgb: SrgbEncoder,
}

impl ToneMapper {
    pub fn new(curve: ToneCurve) -> Self {
        Self { curve, ..Self::default() }
    }

    /// sRGB of a pixel in that row.
    pub fn encode(&mut self, row: usize, light: &PixelLight) -> [u8; 4] {
        let srgb = self.srgb;
        let developed = |c: Vec3| [srgb.byte(c.x), srgb.byte(c.y), srgb.byte(c.z), 255];
        let color = match light {
            PixelLight::Even(color) => *color,
            PixelLight::Uneven(colors) if colors.iter().all(|color| *color == colors[0]) => colors[0],
            PixelLight::Uneven(colors) => {
                let sum: Vec3 = colors.iter().map(|color| self.curve.apply(*color)).sum();
                return developed(sum * (1.0 / colors.len() as f32));
            }
        };
        match self.last[row % 2] {
            Some((known, bytes)) if known == color => bytes,
            _ => {
                let bytes = developed(self.curve.apply(color));
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
    fn tone_mapper_cache_equals_fresh_result() {
        let lights = [0.2, 0.2, 0.9, 0.2, 0.9, 1.4].map(Vec3::splat);
        let mut tone_mapper = ToneMapper::default();
        for (row, color) in [0, 0, 1, 0, 1, 2].into_iter().zip(lights) {
            let fresh = ToneMapper::default().encode(row, &PixelLight::Even(color));
            assert_eq!(tone_mapper.encode(row, &PixelLight::Even(color)), fresh);
            assert_eq!(tone_mapper.encode(row, &PixelLight::Uneven(&[color; 4])), fresh);
        }
        // Half the samples dark: each sample is compressed before averaging.
        let half = [Vec3::ZERO, Vec3::splat(4.0)];
        let mean = encode_srgb(0.5 * ToneCurve::Knee.apply(half[1]).x);
        assert_eq!(tone_mapper.encode(0, &PixelLight::Uneven(&half)), [mean, mean, mean, 255]);
    }
}
