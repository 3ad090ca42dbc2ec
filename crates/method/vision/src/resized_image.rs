//! Resizing of 8-bit images by bicubic interpolation with antialiasing, byte for byte as Pillow's `BICUBIC`.
//!
//! The preprocessing of published models uses Pillow, and perceptual distances react to the filter. Like there, rows
//! are resized first and rounded to bytes, then columns, both in fixed-point arithmetic. Each channel is on its own,
//! alpha too. Cost: proportional to input pixels times the new width, some 10 ms for a photograph.

use crate::bicubic::{Taps, antialiased_exactly};
use imaging::Image;

/// Bits after the binary point of a weight, those of Pillow.
const WEIGHT_BITS: u32 = 22;

/// The image at another size in pixels, both sides at least 1. An image of that size already is returned as it is.
pub fn resized(image: &Image, width_px: u32, height_px: u32) -> Image {
    let wide = if image.width_px() == width_px { image.clone() } else { in_width(image, width_px) };
    if wide.height_px() == height_px { wide } else { in_height(&wide, height_px) }
}

fn in_width(image: &Image, width_px: u32) -> Image {
    let taps = fixed_point(image.width_px(), width_px);
    let mut result = Image::filled(width_px, image.height_px(), [0; 4]);
    let rows = image.as_rgba().chunks_exact(4 * image.width_px() as usize);
    for (row, new) in rows.zip(result.as_rgba_mut().chunks_exact_mut(4 * width_px as usize)) {
        for (pixel, taps) in new.chunks_exact_mut(4).zip(&taps) {
            let colors = row[4 * taps.first..].chunks_exact(4);
            pixel.copy_from_slice(&blended(taps, colors));
        }
    }
    result
}

fn in_height(image: &Image, height_px: u32) -> Image {
    let taps = fixed_point(image.height_px(), height_px);
    let stride = 4 * image.width_px() as usize;
    let mut result = Image::filled(image.width_px(), height_px, [0; 4]);
    for (new, taps) in result.as_rgba_mut().chunks_exact_mut(stride.max(1)).zip(&taps) {
        for (x, pixel) in new.chunks_exact_mut(4).enumerate() {
            let colors =
                image.as_rgba()[taps.first * stride..].chunks(stride).map(|row| &row[4 * x..4 * x + 4]);
            pixel.copy_from_slice(&blended(taps, colors));
        }
    }
    result
}

/// Weights as multiples of 2^-22, rounded away from zero at halves.
fn fixed_point(from: u32, to: u32) -> Vec<Taps<i32>> {
    let fixed = |weight: f64| (weight * f64::from(1 << WEIGHT_BITS)).round() as i32;
    let taps = antialiased_exactly(from as usize, to as usize);
    taps.into_iter()
        .map(|taps| Taps { first: taps.first, weights: taps.weights.into_iter().map(fixed).collect() })
        .collect()
}

fn blended<'a>(taps: &Taps<i32>, colors: impl Iterator<Item = &'a [u8]>) -> [u8; 4] {
    let mut sum = [1_i32 << (WEIGHT_BITS - 1); 4];
    for (weight, color) in taps.weights.iter().zip(colors) {
        for (sum, byte) in sum.iter_mut().zip(color) {
            *sum += weight * i32::from(*byte);
        }
    }
    sum.map(|sum| (sum >> WEIGHT_BITS).clamp(0, 255) as u8)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn image_of_same_size_and_uniform_color_are_kept() {
        let image = Image::from_rgba(3, 2, (0..24).map(|byte| byte * 10).collect()).expect("4 bytes a pixel");
        assert_eq!(resized(&image, 3, 2), image);
        let uniform = Image::filled(37, 11, [3, 130, 255, 255]);
        assert_eq!(resized(&uniform, 8, 29), Image::filled(8, 29, [3, 130, 255, 255]));
    }

    #[test]
    fn each_axis_is_resized_on_its_own() {
        let row: Vec<u8> = [10, 200, 90].iter().flat_map(|&byte| [byte, byte, byte, 255]).collect();
        let image = Image::from_rgba(3, 1, row).expect("4 bytes a pixel");
        let high = resized(&image, 3, 4);
        assert_eq!((high.width_px(), high.height_px()), (3, 4));
        for y in 0..4 {
            assert_eq!(high.pixel(1, y), [200, 200, 200, 255]);
        }
        // Weights of Keys at 1/4 of a step between 10 and 200, with a = -0.5 and the missing neighbor left out:
        // (0.8671875, 0.2265625, -0.0234375) and their sum 1.0703125, which divides them.
        let wide = resized(&image, 6, 1);
        assert_eq!(
            wide.pixel(1, 0)[0],
            ((0.867_187_5 * 10.0 + 0.226_562_5 * 200.0 - 0.023_437_5 * 90.0) / 1.070_312_5_f64).round() as u8
        );
    }
}
