//! Input of DINOv2 from an image.
//!
//! The opaque part is cropped, composited over the mean color of ImageNet, padded with it to a square, resized
//! (bicubic with antialiasing, as in the reference) and normalized with ImageNet's mean and deviation, so that
//! padding is exactly 0. The reference crops the center of the image instead; here nothing at the rim is lost.
//! Colors of transparent pixels do not count.

use crate::bicubic::antialiased;
use crate::image_encoder::{MEAN, normalized};
use crate::patch_projection::Pixels;
use imaging::Image;

/// The normalized square; `None` if nothing is opaque.
pub(super) fn pixels(image: &Image, side_px: usize) -> Option<Pixels> {
    let [left, top, right, bottom] = opaque_bounds(image)?;
    let (width, height) = (right - left, bottom - top);
    let square = width.max(height);
    let (pad_x, pad_y) = ((square - width) / 2, (square - height) / 2);
    let taps = antialiased(square, side_px);

    // Row by row, so that a large image needs no copy of itself in floating point.
    let background = MEAN.map(|mean| 255.0 * mean);
    let mut reduced_rows = vec![background; square * side_px];
    let mut row = vec![background; square];
    for y in 0..height {
        for (x, color) in row[pad_x..pad_x + width].iter_mut().enumerate() {
            *color = flattened(image.pixel((left + x) as u32, (top + y) as u32), background);
        }
        let reduced = &mut reduced_rows[(pad_y + y) * side_px..][..side_px];
        for (color, taps) in reduced.iter_mut().zip(&taps) {
            *color = blended(taps.weights.iter().zip(&row[taps.first..]));
        }
    }
    let mut rgb = vec![0.0; 3 * side_px * side_px];
    for (y, taps) in taps.iter().enumerate() {
        for x in 0..side_px {
            let column = reduced_rows[taps.first * side_px + x..].iter().step_by(side_px);
            let color = blended(taps.weights.iter().zip(column));
            for channel in 0..3 {
                let share = color[channel].clamp(0.0, 255.0) / 255.0;
                rgb[(channel * side_px + y) * side_px + x] = normalized(channel, share);
            }
        }
    }
    Some(Pixels { rgb, height_px: side_px, width_px: side_px })
}

/// Bounds of the opaque part: left, top, and right and bottom exclusive.
fn opaque_bounds(image: &Image) -> Option<[usize; 4]> {
    let mut bounds: Option<[usize; 4]> = None;
    for y in 0..image.height_px() {
        for x in 0..image.width_px() {
            if image.pixel(x, y)[3] >= 128 {
                let (x, y) = (x as usize, y as usize);
                let [left, top, right, bottom] = bounds.unwrap_or([x, y, x + 1, y + 1]);
                bounds = Some([left.min(x), top.min(y), right.max(x + 1), bottom.max(y + 1)]);
            }
        }
    }
    bounds
}

fn flattened([r, g, b, a]: [u8; 4], background: [f32; 3]) -> [f32; 3] {
    let alpha = f32::from(a) / 255.0;
    let color = [r, g, b].map(f32::from);
    std::array::from_fn(|channel| alpha * color[channel] + (1.0 - alpha) * background[channel])
}

fn blended<'a>(parts: impl Iterator<Item = (&'a f32, &'a [f32; 3])>) -> [f32; 3] {
    parts.fold([0.0; 3], |sum, (weight, color)| {
        std::array::from_fn(|channel| sum[channel] + weight * color[channel])
    })
}
