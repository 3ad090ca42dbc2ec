//! The mask's square crop with its contour's distance field, its known pixels and its unoccluded sides.

mod window;

use glam::DVec2;

use super::silhouette::{BLOCK_PX, BlockRow};
use imaging::Mask;
use imaging::distance_transform::distance_transform;
use window::{Axis, Window};

/// Share of the crop's side left free on each side of the box.
const MARGIN: f64 = 0.04;

/// Distance beyond the box up to which occluders are traced, pixels.
const BEYOND_PX: i64 = 2;

/// Reach of an occluder beyond a side from which the side counts as occluded, pixels.
const BEYOND_MIN: usize = 2;

/// Share of the mask's border pixels next to unknown pixels up to which the mask counts as unoccluded.
const DOUBTFUL_SHARE: f64 = 0.05;

/// A mask cropped to its box, padded to a square, resized.
pub struct Crop {
    pub side_px: usize,
    /// Box of the mask in the image, pixels.
    pub low_px: DVec2,
    pub high_px: DVec2,
    /// For left, top, right and bottom: whether this side of the box is the object's own and not an occluder's.
    pub own_sides: [bool; 4],
    /// Crop pixels per image pixel, and the image position in the center of the crop.
    pub scale: f64,
    pub center_px: DVec2,
    /// Soft mask, 0..1, row-major; 0 where unknown.
    pub mask: Vec<f32>,
    /// 1 where the pixel is known, 0 where an occluder hides it.
    pub known: Vec<f32>,
    /// Blocks of each row in which any pixel is known.
    pub known_blocks: Vec<BlockRow>,
    /// `known` without the first and the last column, which have no neighbor on one side.
    pub inner: Vec<f32>,
    /// Distance to the mask's own contour, crop pixels.
    pub distance_px: Vec<f32>,
    /// Sum of `mask`.
    pub mask_area: f64,
}

impl Crop {
    /// `bbox` is the mask's box.
    pub fn new(mask: &Mask, unknown: &Mask, bbox: [u32; 4], side_px: usize) -> Self {
        let [x0, y0, x1, y1] = bbox.map(f64::from);
        let (low_px, high_px) = (DVec2::new(x0, y0), DVec2::new(x1, y1));
        let size = high_px - low_px;
        let center_px = 0.5 * (low_px + high_px);
        let scale = side_px as f64 * (1.0 - 2.0 * MARGIN) / size.max_element();
        let own_sides = own_sides(mask, unknown, bbox);
        // Points per crop pixel and axis: enough that no image pixel is skipped.
        let points = (1.0 / scale).ceil().clamp(1.0, 8.0) as usize;
        let columns = Axis::new(side_px, points, scale, center_px.x);
        let rows = Axis::new(side_px, points, scale, center_px.y);
        let mut soft = Vec::with_capacity(side_px * side_px);
        let mut known = Vec::with_capacity(side_px * side_px);
        Window::new(mask, unknown, &columns, &rows).each_crop_pixel(|own, seen| {
            let is_known = if seen > 0.5 { 1.0 } else { 0.0 };
            soft.push(own as f32 * is_known);
            known.push(is_known);
        });
        let distance_px = contour_distance(&soft, &known, side_px);
        let blocks = |row: &[f32]| {
            let known = |(block, pixels): (usize, &[f32])| BlockRow::from(pixels.contains(&1.0)) << block;
            row.chunks(BLOCK_PX).enumerate().map(known).sum()
        };
        let mut inner = known.clone();
        for row in inner.chunks_exact_mut(side_px) {
            (row[0], row[side_px - 1]) = (0.0, 0.0);
        }
        let mask_area = soft.iter().map(|&s| f64::from(s)).sum();
        Self {
            side_px,
            low_px,
            high_px,
            own_sides,
            scale,
            center_px,
            known_blocks: known.chunks_exact(side_px).map(blocks).collect(),
            inner,
            mask: soft,
            known,
            distance_px,
            mask_area,
        }
    }
}

/// A side is the object's own unless an occluder of the object reaches beyond it: unknown pixels connected with the
/// mask's border by unknown pixels, the image's border included. A known pixel beside the outermost ones is not
/// sufficient: if a candlestick's foot is hidden, the outermost pixels are the candle's.
fn own_sides(mask: &Mask, unknown: &Mask, [x0, y0, x1, y1]: [u32; 4]) -> [bool; 4] {
    let (width, height) = (i64::from(mask.width_px()), i64::from(mask.height_px()));
    let hidden =
        |x: i64, y: i64| x < 0 || y < 0 || x >= width || y >= height || unknown.contains(x as u32, y as u32);
    // The window in which occluders are traced: the box and a line around it.
    let [left, top, right, bottom] = [x0, y0, x1, y1].map(i64::from);
    let (low_x, low_y) = (left - BEYOND_PX, top - BEYOND_PX);
    let (columns, rows) = (right - left + 2 * BEYOND_PX, bottom - top + 2 * BEYOND_PX);
    let at = |x: i64, y: i64| ((y - low_y) * columns + (x - low_x)) as usize;
    let within = |x: i64, y: i64| (0..columns).contains(&(x - low_x)) && (0..rows).contains(&(y - low_y));
    let around = |x: i64, y: i64| [(x - 1, y), (x + 1, y), (x, y - 1), (x, y + 1)];
    let mut reached = vec![false; (columns * rows) as usize];
    let mut open = Vec::new();
    let (mut border, mut doubtful) = (0, 0);
    for y in top..bottom {
        for x in (left..right).filter(|&x| mask.contains(x as u32, y as u32)) {
            let (mut outer, mut unsure) = (false, false);
            for (u, v) in around(x, y) {
                let own = (left..right).contains(&u)
                    && (top..bottom).contains(&v)
                    && mask.contains(u as u32, v as u32);
                let is_hidden = !own && hidden(u, v);
                (outer, unsure) = (outer || !own, unsure || is_hidden);
                if is_hidden && !reached[at(u, v)] {
                    reached[at(u, v)] = true;
                    open.push((u, v));
                }
            }
            border += usize::from(outer);
            doubtful += usize::from(unsure);
        }
    }
    if (doubtful as f64) < DOUBTFUL_SHARE * border as f64 {
        return [true; 4];
    }
    let mut beyond = [0; 4];
    while let Some((x, y)) = open.pop() {
        let past = [x < left, y < top, x >= right, y >= bottom];
        beyond.iter_mut().zip(past).for_each(|(count, past)| *count += usize::from(past));
        for (u, v) in around(x, y) {
            if within(u, v) && !reached[at(u, v)] && hidden(u, v) {
                reached[at(u, v)] = true;
                open.push((u, v));
            }
        }
    }
    beyond.map(|count| count < BEYOND_MIN)
}

/// Distance to the pixels where the mask ends on something known.
fn contour_distance(soft: &[f32], known: &[f32], side: usize) -> Vec<f32> {
    let inside = |x: usize, y: usize| soft[y * side + x] > 0.5;
    let mut contour = vec![false; side * side];
    for y in 1..side - 1 {
        for x in 1..side - 1 {
            contour[y * side + x] = inside(x, y)
                && [(x - 1, y), (x + 1, y), (x, y - 1), (x, y + 1)]
                    .iter()
                    .any(|&(u, v)| !inside(u, v) && known[v * side + u] > 0.5);
        }
    }
    let mut distance = distance_transform(&contour, side, side);
    // Without any contour (all of it hidden) the term is 0.
    distance.iter_mut().filter(|d| !d.is_finite()).for_each(|d| *d = 0.0);
    distance
}
