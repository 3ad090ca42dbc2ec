//! Position embeddings for a grid of patches other than the stored one, by bicubic interpolation as in the reference.

use crate::bicubic::interpolating;

/// `stored` is row-major over `grid` x `grid` cells of `hidden` values; so is the result over `rows` x `columns`.
pub(super) fn interpolate(
    stored: &[f32],
    grid: usize,
    hidden: usize,
    rows: usize,
    columns: usize,
) -> Vec<f32> {
    if (rows, columns) == (grid, grid) {
        return stored.to_vec();
    }
    let (down, across) = (interpolating(grid, rows), interpolating(grid, columns));
    let mut result = vec![0.0; rows * columns * hidden];
    for (place, values) in result.chunks_exact_mut(hidden).enumerate() {
        let (row_taps, column_taps) = (&down[place / columns], &across[place % columns]);
        for (y, row_weight) in (row_taps.first..).zip(&row_taps.weights) {
            for (x, column_weight) in (column_taps.first..).zip(&column_taps.weights) {
                let at = (y * grid + x) * hidden;
                let weight = row_weight * column_weight;
                for (value, stored) in values.iter_mut().zip(&stored[at..at + hidden]) {
                    *value += weight * stored;
                }
            }
        }
    }
    result
}
