//! The picture's side of the comparison: the mask's square crop, its contour's distance field, and
//! which pixels and which sides of its box say something.

mod window;

use glam::DVec2;

use super::silhouette::{BLOCK_PX, BlockRow};
use crate::geometry::Mask;
use crate::geometry::distance_transform::distance_transform;
use window::{Axis, Window};

/// Share of the crop's side left free on each side of the box.
const MARGIN: f64 = 0.04;

/// A mask cropped to its box, padded to a square, resized.
pub struct Crop {
    pub side_px: usize,
    /// Box of the mask in the picture, pixels.
    pub low_px: DVec2,
    pub high_px: DVec2,
    /// Which sides of the box are the object's own and not an occluder's: left, top, right, bottom.
    pub own_sides: [bool; 4],
    /// Crop pixels per picture pixel, and the picture position in the middle of the crop.
    pub scale: f64,
    pub center_px: DVec2,
    /// Soft mask, 0..1, row-major; 0 where unknown.
    pub mask: Vec<f32>,
    /// 1 where the picture shows what is there, 0 where something else hides it.
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
        // Points per crop pixel and axis: enough that no picture pixel is skipped.
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

/// A side is the object's own unless a good part of the pixels along it border on something unknown.
fn own_sides(mask: &Mask, unknown: &Mask, [x0, y0, x1, y1]: [u32; 4]) -> [bool; 4] {
    let hidden = |x: i64, y: i64| {
        x < 0
            || y < 0
            || x >= i64::from(mask.width_px())
            || y >= i64::from(mask.height_px())
            || unknown.contains(x as u32, y as u32)
    };
    // Pixels of the outermost two lines, and whether what lies beyond or beside them is hidden.
    let own = |pixels: Vec<(u32, u32)>, step: (i64, i64)| {
        let (mut all, mut doubtful) = (0, 0);
        for (x, y) in pixels.into_iter().filter(|&(x, y)| mask.contains(x, y)) {
            let (x, y) = (i64::from(x), i64::from(y));
            let beside = [(1, 1), (2, 2)].iter().any(|&(a, b)| {
                hidden(x + a * step.0, y + b * step.1)
                    || hidden(x + a * step.1, y + b * step.0)
                    || hidden(x - a * step.1, y - b * step.0)
            });
            all += 1;
            doubtful += usize::from(beside);
        }
        doubtful * 4 <= all
    };
    let column = |x: u32| (y0..y1).map(|y| (x, y)).collect();
    let row = |y: u32| (x0..x1).map(|x| (x, y)).collect();
    [own(column(x0), (-1, 0)), own(row(y0), (0, -1)), own(column(x1 - 1), (1, 0)), own(row(y1 - 1), (0, 1))]
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
    // Without any contour (all of it hidden) the term says nothing.
    distance.iter_mut().filter(|d| !d.is_finite()).for_each(|d| *d = 0.0);
    distance
}
