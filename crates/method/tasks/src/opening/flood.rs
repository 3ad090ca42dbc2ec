//! Basins of a height field: where water would stay.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use super::height_field::HeightField;

/// Least depth of water that counts, meters.
const MIN_WATER_M: f64 = 0.002;

/// Water that stays in connected cells.
pub(super) struct Basin {
    pub cells: Vec<usize>,
    /// Height of its surface.
    pub level_m: f64,
    /// Lowest ground.
    pub floor_m: f64,
    pub volume_m3: f64,
}

/// The basins of a height field. Water drains over the border of the grid; a hole inside the object, as that of a ring,
/// has its ground at the bottom of the object.
pub(super) fn basins(field: &HeightField) -> Vec<Basin> {
    let levels_m = levels(field);
    let ground_m = |cell: usize| field.heights_m[cell].max(field.bottom_m);
    let is_wet = |cell: usize| levels_m[cell] - ground_m(cell) > MIN_WATER_M;
    let mut seen = vec![false; levels_m.len()];
    let mut basins = Vec::new();
    for start in 0..levels_m.len() {
        if seen[start] || !is_wet(start) {
            continue;
        }
        seen[start] = true;
        let (mut cells, mut at) = (vec![start], 0);
        while at < cells.len() {
            for next in neighbors(field, cells[at]) {
                // Two basins that touch have one level each.
                let same = (levels_m[next] - levels_m[start]).abs() < 1e-9;
                if !seen[next] && is_wet(next) && same {
                    seen[next] = true;
                    cells.push(next);
                }
            }
            at += 1;
        }
        let depth_m: f64 = cells.iter().map(|&cell| levels_m[cell] - ground_m(cell)).sum();
        basins.push(Basin {
            level_m: levels_m[start],
            floor_m: cells.iter().map(|&cell| ground_m(cell)).fold(f64::INFINITY, f64::min),
            volume_m3: depth_m * field.cell_m * field.cell_m,
            cells,
        });
    }
    basins
}

/// Height of the water in each cell, or of the ground where there is none: the lowest level from which it drains.
fn levels(field: &HeightField) -> Vec<f64> {
    let count = field.heights_m.len();
    let mut levels_m = vec![f64::INFINITY; count];
    let mut queue = BinaryHeap::new();
    let is_border = |cell: usize| {
        let (column, row) = (cell % field.columns, cell / field.columns);
        column == 0 || row == 0 || column + 1 == field.columns || row + 1 == field.rows
    };
    for cell in (0..count).filter(|&cell| is_border(cell)) {
        levels_m[cell] = field.bottom_m;
        queue.push(Reverse((Ordered(field.bottom_m), cell)));
    }
    while let Some(Reverse((Ordered(level_m), cell))) = queue.pop() {
        for next in neighbors(field, cell) {
            if levels_m[next] == f64::INFINITY {
                levels_m[next] = level_m.max(field.heights_m[next]);
                queue.push(Reverse((Ordered(levels_m[next]), next)));
            }
        }
    }
    levels_m
}

/// The four cells beside a cell; walls that are connected over corners hold water.
fn neighbors(field: &HeightField, cell: usize) -> impl Iterator<Item = usize> {
    let (columns, rows) = (field.columns, field.rows);
    let (column, row) = (cell % columns, cell / columns);
    let sides = [
        (column > 0).then(|| cell - 1),
        (column + 1 < columns).then(|| cell + 1),
        (row > 0).then(|| cell - columns),
        (row + 1 < rows).then(|| cell + columns),
    ];
    sides.into_iter().flatten()
}

/// A height with the total order of its bits.
#[derive(PartialEq)]
struct Ordered(f64);

impl Eq for Ordered {}

impl PartialOrd for Ordered {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Ordered {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.0.total_cmp(&other.0)
    }
}
