//! Input of CLIP from an image, as `CLIPImageProcessor` of `transformers` prepares it with Pillow: the shorter side is
//! resized to the input's (bicubic, antialiased, rounded to bytes), the center square is cut out, and colors are
//! normalized with CLIP's own mean and deviation.

use crate::patch_projection::Pixels;
use crate::resized_image::resized;
use imaging::Image;

/// Mean and standard deviation of red, green and blue in CLIP's training set, 0..1.
const MEAN: [f32; 3] = [0.481_454_66, 0.457_827_5, 0.408_210_73];
const DEVIATION: [f32; 3] = [0.268_629_54, 0.261_302_6, 0.275_777_1];

/// The normalized square; alpha is ignored.
pub(super) fn pixels(image: &Image, side_px: usize) -> Pixels {
    let side = side_px as u32;
    let (width, height) = (image.width_px().max(1), image.height_px().max(1));
    let short = u64::from(width.min(height));
    // The longer side is rounded down, as in the reference.
    let scaled = |length: u32| (u64::from(side) * u64::from(length) / short) as u32;
    let image = resized(image, scaled(width), scaled(height));
    let (left, top) = ((image.width_px() - side) / 2, (image.height_px() - side) / 2);
    let mut rgb = Vec::with_capacity(3 * side_px * side_px);
    for channel in 0..3 {
        for y in top..top + side {
            let color = |x: u32| f32::from(image.pixel(x, y)[channel]) / 255.0;
            rgb.extend((left..left + side).map(|x| (color(x) - MEAN[channel]) / DEVIATION[channel]));
        }
    }
    Pixels { rgb, height_px: side_px, width_px: side_px }
}
