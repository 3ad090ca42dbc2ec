//! Cells of the class of bare top that are another surface: the floor beside a table, the wall behind it.
//!
//! The network separates a top from its surroundings worst where both are plain. Colors do that: a step of color
//! cuts the cells into pieces. The top is the largest of the pieces on which objects stand, with all pieces of its
//! color, and those inside its convex hull: a pattern, a cloth, a stain. What remains lies beside the top and has
//! another color.
//!
//! A hard shadow over one end of a top is cut off too. Cost: linear in the cells, times the corners of the hull.

use glam::DVec2;

use crate::pixels::{Pixels, distance};
use crate::polygon::{convex_hull, encloses};
use crate::table_network::maps::{Maps, PixelClass};

/// Step of color between adjacent cells that separates pieces, CIELAB.
const STEP: f32 = 8.0;
/// Distance of mean colors from which a piece is another surface, CIELAB.
const OTHER_COLOR: f32 = 14.0;
/// Cells below an object in which its foot touches a piece.
const TOUCHES_WITHIN: usize = 2;
/// Minimum share of the most touched piece's cells below objects.
const MIN_TOUCHED_SHARE: f64 = 0.5;

/// Minimum share of the top in all pieces, and in their cells below objects. With less it is open which surface is the
/// top, and none is cut off: so in images of a wall behind a narrow strip of desk.
const MIN_TOP_SHARE: f64 = 0.65;
const MIN_TOP_TOUCHED_SHARE: f64 = 0.5;

/// Connected bare cells without a step of color.
struct Piece {
    cells: Vec<usize>,
    mean_color: [f32; 3],
    /// Number of cells below objects.
    touched: usize,
}

/// For each cell, whether it is bare and of another surface than the top.
pub(super) fn others(is_bare: &[bool], maps: &Maps, pixels: &Pixels) -> Vec<bool> {
    let mut is_other = vec![false; is_bare.len()];
    let pieces = pieces(is_bare, maps, pixels);
    let Some(max_touched) = pieces.iter().map(|piece| piece.touched).max() else { return is_other };
    let min_touched = MIN_TOUCHED_SHARE * max_touched as f64;
    let stood_on = pieces.iter().filter(|piece| piece.touched as f64 >= min_touched);
    let Some(top) = stood_on.max_by_key(|piece| piece.cells.len()) else { return is_other };
    let centers: Vec<DVec2> = top.cells.iter().map(|&index| maps.pixel_center(index)).collect();
    let hull = convex_hull(&centers);
    let is_top = |piece: &Piece| {
        let inside = piece.cells.iter().filter(|&&index| encloses(&hull, maps.pixel_center(index))).count();
        2 * inside > piece.cells.len() || distance(piece.mean_color, top.mean_color) <= OTHER_COLOR
    };
    let (top, other): (Vec<&Piece>, Vec<&Piece>) = pieces.iter().partition(|piece| is_top(piece));
    let cells = |pieces: &[&Piece]| pieces.iter().map(|piece| piece.cells.len()).sum::<usize>() as f64;
    let touched = |pieces: &[&Piece]| pieces.iter().map(|piece| piece.touched).sum::<usize>() as f64;
    let is_clear = cells(&top) >= MIN_TOP_SHARE * (cells(&top) + cells(&other))
        && touched(&top) >= MIN_TOP_TOUCHED_SHARE * (touched(&top) + touched(&other));
    if is_clear {
        other.iter().flat_map(|piece| &piece.cells).for_each(|&index| is_other[index] = true);
    }
    is_other
}

fn pieces(is_bare: &[bool], maps: &Maps, pixels: &Pixels) -> Vec<Piece> {
    let (width, height) = (maps.width(), maps.height());
    let color: Vec<Option<[f32; 3]>> = (0..is_bare.len())
        .map(|index| if is_bare[index] { cell_color(index, maps, pixels) } else { None })
        .collect();
    let below_object = |index: usize| {
        let (x, y) = (index % width, index / width);
        (y.saturating_sub(TOUCHES_WITHIN)..y).any(|y| maps.class(y * width + x) == PixelClass::Object)
    };
    let mut is_taken = vec![false; is_bare.len()];
    let mut pieces = Vec::new();
    for start in 0..is_bare.len() {
        if is_taken[start] || color[start].is_none() {
            continue;
        }
        is_taken[start] = true;
        let (mut cells, mut next) = (vec![start], 0);
        while let Some(&index) = cells.get(next) {
            next += 1;
            let (x, y) = (index % width, index / width);
            let around = [
                (x > 0).then(|| index - 1),
                (x + 1 < width).then_some(index + 1),
                (y > 0).then(|| index - width),
                (y + 1 < height).then_some(index + width),
            ];
            for other in around.into_iter().flatten() {
                let is_near = color[index].zip(color[other]).is_some_and(|(a, b)| distance(a, b) < STEP);
                if is_near && !is_taken[other] {
                    is_taken[other] = true;
                    cells.push(other);
                }
            }
        }
        let colors = cells.iter().filter_map(|&index| color[index]);
        let mean_color = mean(colors);
        let touched = cells.iter().filter(|&&index| below_object(index)).count();
        pieces.push(Piece { cells, mean_color, touched });
    }
    pieces
}

/// Mean color of the pixels around the center of a cell; `None` outside the copy.
fn cell_color(index: usize, maps: &Maps, pixels: &Pixels) -> Option<[f32; 3]> {
    let center = pixels.scale * maps.in_image(maps.pixel_center(index));
    let around = (0..9)
        .filter_map(|k| pixels.index_at(center + DVec2::new(f64::from(k % 3) - 1.0, f64::from(k / 3) - 1.0)));
    pixels.index_at(center)?;
    Some(mean(around.map(|pixel| pixels.lab[pixel])))
}

fn mean(colors: impl Iterator<Item = [f32; 3]>) -> [f32; 3] {
    let (sum, count) =
        colors.fold(([0.0; 3], 0.0), |(sum, count), c| ([0, 1, 2].map(|k| sum[k] + c[k]), count + 1.0));
    sum.map(|s: f32| s / f32::max(count, 1.0))
}
