//! Cells of an image that the surface certainly covers throughout; the outline search skips them.
//!
//! The layer count at a pixel's center bounds the count elsewhere in its square from below. On the straight way there
//! each step that passes the square is crossed at most once, and removes layers only if the center lies on the side
//! that has them. A cell is covered if the bound is positive in all its squares. The test is conservative: covered
//! cells may be missed, and cells beyond the image always are. Cost: two vectors for each step in each cell with no
//! empty center.

use wide::f32x8;

use super::Grid;
use super::bins::{Bins, CELL_PX, SLACK_PX};

/// Distance beyond a cell's border that the surface covers too, pixels; steps passing nearer are entered in the cell.
pub const WIDENED_PX: f32 = 0.5 * SLACK_PX;

/// Half a pixel, widened.
const HALF_PX: f32 = 0.5 + WIDENED_PX;

/// Centers this near to a step may lie to either side of it, pixels: above the rounding of single precision.
const NEAR_PX: f32 = 1e-3;

/// Steps up to this length have no direction to rely on, pixels.
const SHORT_PX: f32 = 0.02;

/// Pixels along a cell's side, and two rows of them: column and row of each.
const CELL: usize = CELL_PX as usize;
const COLUMNS: [f32; 2 * CELL] = [0.0, 1.0, 2.0, 3.0, 0.0, 1.0, 2.0, 3.0];
const ROWS: [f32; 2 * CELL] = [0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0];

/// A step in the form that the bound uses.
#[derive(Clone, Copy, Debug)]
pub struct StepLine {
    from_px: [f32; 2],
    direction_px: [f32; 2],
    /// Centers whose squares it touches, if it is long.
    low_px: [f32; 2],
    high_px: [f32; 2],
    /// Area between such a center and the step, signed, where layers may be lost.
    min_px2: f32,
    max_px2: f32,
    layers: f32,
}

impl StepLine {
    /// `layers` lie to its left or, if negative, to its right.
    pub fn between(a: [f32; 2], b: [f32; 2], layers: i32) -> Self {
        let [dx, dy] = [b[0] - a[0], b[1] - a[1]];
        let reach_px2 = (HALF_PX + NEAR_PX) * (dx.abs() + dy.abs());
        let length_px = (dx * dx + dy * dy).sqrt();
        let near_px2 = if length_px < SHORT_PX { reach_px2 } else { NEAR_PX * length_px };
        // With y down the left is the negative side.
        let (min_px2, max_px2) = if layers > 0 { (-reach_px2, near_px2) } else { (-near_px2, reach_px2) };
        Self {
            from_px: a,
            direction_px: [dx, dy],
            low_px: [0, 1].map(|axis| a[axis].min(b[axis]) - HALF_PX - NEAR_PX),
            high_px: [0, 1].map(|axis| a[axis].max(b[axis]) + HALF_PX + NEAR_PX),
            min_px2,
            max_px2,
            layers: layers.unsigned_abs() as f32,
        }
    }

    /// Layers that may be lost on the way from a center to elsewhere in its square, for eight centers in two rows; the
    /// first center is given.
    #[inline]
    fn lost(&self, first_px: [f32; 2]) -> f32x8 {
        let [dx, dy] = self.direction_px;
        let (columns, rows) = (f32x8::from(COLUMNS), f32x8::from(ROWS));
        let at_first = dx * (first_px[1] - self.from_px[1]) - dy * (first_px[0] - self.from_px[0]);
        let area = f32x8::splat(at_first) + f32x8::splat(dx) * rows - f32x8::splat(dy) * columns;
        let within = |lanes: f32x8, low: f32, high: f32| {
            lanes.simd_ge(f32x8::splat(low)) & lanes.simd_le(f32x8::splat(high))
        };
        let lost = within(area, self.min_px2, self.max_px2)
            & within(columns, self.low_px[0] - first_px[0], self.high_px[0] - first_px[0])
            & within(rows, self.low_px[1] - first_px[1], self.high_px[1] - first_px[1]);
        lost & f32x8::splat(self.layers)
    }
}

/// Covered cells; reuse it to save allocations.
#[derive(Debug, Default)]
pub struct InsideCells {
    covered: Vec<bool>,
}

impl InsideCells {
    /// Tests all cells that steps pass: `lines` has the steps by cell. `doubtful` cells contain further edges.
    pub fn find(&mut self, lines: &Bins, steps: &[StepLine], doubtful: &[usize], layers: &[i16], grid: Grid) {
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

fn surely_covered(corner: [f32; 2], here: &[u32], steps: &[StepLine], layers: &[i16], grid: Grid) -> bool {
    let [x, y] = corner.map(|c| c as i32);
    let (width, height) = (grid.width_px(), grid.height_px);
    if x < 0 || y < 0 || x as usize + CELL > width || y as usize + CELL > height {
        return false;
    }
    let first = y as usize * width + x as usize;
    if (0..CELL).any(|row| layers[first + row * width..][..CELL].contains(&0)) {
        return false;
    }
    (0..CELL).step_by(2).all(|row| {
        let pixels = |k: usize| first + (row + k / CELL) * width + k % CELL;
        let mut left = f32x8::from(std::array::from_fn(|k| f32::from(layers[pixels(k)])));
        let first_px = [corner[0] + 0.5, corner[1] + row as f32 + 0.5];
        for &step in here {
            left -= steps[step as usize].lost(first_px);
        }
        left.simd_gt(f32x8::ZERO).all()
    })
}
