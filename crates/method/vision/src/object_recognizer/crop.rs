//! Input of the recognizer: a square around an object, gray where the object is not (`training/close_ups.py`).

use image::imageops::{FilterType, resize};
use image::{Rgb, RgbImage};

use crate::image_encoder::normalized;
use crate::morphology::dilate;
use imaging::{Image, Mask};

/// Margin on each side of the object's box, a share of its longer side.
const MARGIN: f64 = 0.1;

/// Growth of the mask before everything outside it becomes gray, a share of the longer side.
const GROWTH: f64 = 0.0125;
const GRAY: u8 = 118;

/// Normalized colors of the square around the mask, channel by channel; `None` for an empty mask. The square moves
/// into the image where it can; where it is larger than the image, it repeats the pixels of the edge.
pub(super) fn square_crop(image: &Image, mask: &Mask, side_px: usize) -> Option<Vec<f32>> {
    let [left, upper, right, lower] = mask.bbox_px()?.map(f64::from);
    let longer = (right - left).max(lower - upper);
    let side = longer * (1.0 + 2.0 * MARGIN);
    let image_px = [image.width_px(), image.height_px()];
    let [x, y] = [(left, right, image_px[0]), (upper, lower, image_px[1])].map(|(low, high, limit)| {
        let (limit, start) = (f64::from(limit), 0.5 * (low + high - side));
        let start = if side <= limit { start.clamp(0.0, limit - side) } else { start };
        [start, start + side].map(|edge| edge.round_ties_even() as i64)
    });
    let [columns, rows] = [x, y].map(|[from, to]| (to - from).max(1) as usize);
    // The position in the image of a position in the square.
    let position = |index: usize| {
        let within = |at: i64, k: usize| at.clamp(0, i64::from(image_px[k]) - 1) as u32;
        (within(x[0] + (index % columns) as i64, 0), within(y[0] + (index / columns) as i64, 1))
    };
    let own: Vec<bool> = (0..columns * rows)
        .map(|index| {
            let (x, y) = position(index);
            mask.contains(x, y)
        })
        .collect();
    let own = dilate(&own, columns, rows, (GROWTH * longer) as f32);
    let part = RgbImage::from_fn(columns as u32, rows as u32, |column, row| {
        let index = row as usize * columns + column as usize;
        let (x, y) = position(index);
        let [r, g, b, a] = image.pixel(x, y).map(u32::from);
        let opaque = |level: u32| ((level * a + 255 * (255 - a) + 127) / 255) as u8;
        Rgb(if own[index] { [r, g, b].map(opaque) } else { [GRAY; 3] })
    });
    let small = resize(&part, side_px as u32, side_px as u32, FilterType::Triangle);
    let channel = |k: usize| small.pixels().map(move |p| normalized(k, f32::from(p[k]) / 255.0));
    Some((0..3).flat_map(channel).collect())
}
