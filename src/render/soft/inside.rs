//! Which cells of a picture the surface surely covers throughout: no outline need be looked for there.
//!
//! Of the layers over a pixel center one knows how many are left elsewhere in its cell at the least: on the straight way
//! there each step that passes the cell is crossed once at most, and takes layers away only if the center lies to the
//! side that has them. Where some are left for one of a few centers, the cell is covered, and so is [`WIDENED_PX`]
//! around it. Cells may be covered without being found so; those beyond the picture never are.

use super::Grid;
use super::bins::{Bins, CELL_PX, SLACK_PX};
use super::crossing::{cross, minus};

/// How far beyond a cell's border the surface covers too, pixels: what passes nearer was entered in the cell.
pub const WIDENED_PX: f64 = 0.5 * SLACK_PX as f64;

/// Pixel centers this near to a step count as lying to either side of it: layers are counted in single precision.
const NEAR_PX: f64 = 1e-3;

/// Pixels along a cell's side.
const CELL: usize = CELL_PX as usize;

/// The pixels of a cell that are tried.
const TRIED: [[usize; 2]; 5] = [[0, 0], [CELL - 1, CELL - 1], [CELL - 1, 0], [0, CELL - 1], [1, 2]];

/// A step as this file needs it.
#[derive(Clone, Copy, Debug)]
pub struct StepLine {
    from_px: [f64; 2],
    direction_px: [f64; 2],
    /// To its left, or if negative to its right.
    layers: i32,
    /// Area between the step and a position that is [`NEAR_PX`] away.
    near_px2: f64,
}

impl StepLine {
    pub fn new(from_px: [f64; 2], direction_px: [f64; 2], layers: i32) -> Self {
        let [dx, dy] = direction_px;
        Self { from_px, direction_px, layers, near_px2: NEAR_PX * (dx * dx + dy * dy).sqrt() }
    }

    /// Layers that are lost on the way from there over the step.
    #[inline]
    fn lost_from(&self, p: [f64; 2]) -> i32 {
        let to_the_right = cross(self.direction_px, minus(p, self.from_px));
        let on_the_other_side =
            if self.layers > 0 { to_the_right > self.near_px2 } else { to_the_right < -self.near_px2 };
        if on_the_other_side { 0 } else { self.layers.abs() }
    }
}

/// Cells that are covered; keep it to save allocations.
#[derive(Debug, Default)]
pub struct Inside {
    covered: Vec<bool>,
}

impl Inside {
    /// Looks at all cells that steps pass: `lines` has them sorted by cell. `doubtful` cells are passed by more than that.
    pub fn find(&mut self, lines: &Bins, steps: &[StepLine], doubtful: &[usize], layers: &[i32], grid: Grid) {
        self.covered.clear();
        self.covered.extend((0..lines.cells()).map(|cell| {
            let here = lines.in_cell(cell);
            !here.is_empty() && surely_covered(lines.corner_of(cell), here, steps, layers, grid)
        }));
        doubtful.iter().for_each(|&cell| self.covered[cell] = false);
    }

    /// Of each cell; false where nothing passes.
    pub fn covered(&self) -> &[bool] {
        &self.covered
    }
}

fn surely_covered(corner: [f32; 2], here: &[u32], steps: &[StepLine], layers: &[i32], grid: Grid) -> bool {
    let [x, y] = corner.map(|c| c as i32);
    let (width, height) = (grid.width_px(), grid.height_px);
    if x < 0 || y < 0 || x as usize + CELL > width || y as usize + CELL > height {
        return false;
    }
    let first = y as usize * width + x as usize;
    if (0..CELL).any(|row| layers[first + row * width..][..CELL].contains(&0)) {
        return false;
    }
    TRIED.iter().any(|&[column, row]| {
        let center = [x as f64 + column as f64 + 0.5, y as f64 + row as f64 + 0.5];
        let mut left = layers[first + row * width + column];
        for &step in here {
            left -= steps[step as usize].lost_from(center);
            if left <= 0 {
                return false;
            }
        }
        true
    })
}
