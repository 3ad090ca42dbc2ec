//! Watershed superpixels of the border map, within groups of cells with a common center vote.
//!
//! Center votes alone fail where an object lies at the center of another one (pliers on a mat), and where the peak
//! of a small object is lost beside that of a large one. The border between the two may still be visible. So each
//! group is split by a watershed of its border map.

use std::collections::VecDeque;

use glam::DVec2;

/// Number of flooding levels.
const LEVELS: usize = 20;

/// Grid of map cells with the predictions for each.
#[derive(Clone, Copy)]
pub(super) struct CellGrid<'a> {
    pub width: usize,
    /// Center group of a cell; `None` for background.
    pub group: &'a [Option<usize>],
    /// Probability of a border between two objects, 0..1.
    pub border: &'a [f64],
    /// Object probability, 0..1.
    pub object: &'a [f64],
    /// Map position of the voted center.
    pub vote: &'a [DVec2],
    /// Center score, about 0..1.
    pub center: &'a [f64],
}

/// The superpixel of each cell, and their number.
pub(super) struct Superpixels {
    pub of_cell: Vec<Option<usize>>,
    pub count: usize,
}

impl CellGrid<'_> {
    pub fn count(&self) -> usize {
        self.group.len()
    }

    pub fn height(&self) -> usize {
        self.count() / self.width
    }

    /// The four neighbors inside the map.
    pub fn neighbors(&self, cell: usize) -> impl Iterator<Item = usize> + use<> {
        let (width, count) = (self.width, self.count());
        let x = cell % width;
        let left = (x > 0).then(|| cell - 1);
        let right = (x + 1 < width).then(|| cell + 1);
        let above = cell.checked_sub(width);
        let below = Some(cell + width).filter(|p| *p < count);
        [left, right, above, below].into_iter().flatten()
    }

    /// The cell and its eight neighbors inside the map.
    fn around(&self, cell: usize) -> impl Iterator<Item = usize> + use<> {
        let (width, height) = (self.width, self.height());
        let (x, y) = (cell % width, cell / width);
        (y.saturating_sub(1)..(y + 2).min(height))
            .flat_map(move |v| (x.saturating_sub(1)..(x + 2).min(width)).map(move |u| v * width + u))
    }

    /// Border probabilities inside groups: 0 next to another group, which explains the border.
    pub fn inner_borders(&self) -> Vec<f64> {
        let is_explained = |cell: usize| {
            let own = self.group[cell];
            self.around(cell).any(|other| self.group[other].is_some() && self.group[other] != own)
        };
        (0..self.count()).map(|cell| if is_explained(cell) { 0.0 } else { self.border[cell] }).collect()
    }

    /// Watershed of the smoothed inner borders within each group.
    pub fn superpixels(&self, inner_borders: &[f64]) -> Superpixels {
        let mut of_level = vec![Vec::new(); LEVELS];
        let level: Vec<usize> = (0..self.count()).map(|cell| self.level(cell, inner_borders)).collect();
        for cell in (0..self.count()).filter(|&cell| self.group[cell].is_some()) {
            of_level[level[cell]].push(cell);
        }
        let mut superpixel: Vec<Option<usize>> = vec![None; self.count()];
        let mut count = 0;
        let same = |a: usize, b: usize| self.group[a] == self.group[b];
        let flood = |superpixel: &mut Vec<Option<usize>>, mut front: VecDeque<usize>| {
            while let Some(from) = front.pop_front() {
                for to in self.neighbors(from) {
                    if superpixel[to].is_none() && level[to] == level[from] && same(from, to) {
                        superpixel[to] = superpixel[from];
                        front.push_back(to);
                    }
                }
            }
        };
        for cells in &of_level {
            // Cells next to a lower superpixel join it.
            let shore: Vec<(usize, usize)> = cells
                .iter()
                .filter_map(|&cell| {
                    let lower = self.neighbors(cell).filter(|&other| same(cell, other));
                    lower.filter_map(|other| superpixel[other]).next().map(|owner| (cell, owner))
                })
                .collect();
            shore.iter().for_each(|(cell, owner)| superpixel[*cell] = Some(*owner));
            flood(&mut superpixel, shore.into_iter().map(|(cell, _)| cell).collect());
            for &cell in cells {
                if superpixel[cell].is_none() {
                    superpixel[cell] = Some(count);
                    count += 1;
                    flood(&mut superpixel, VecDeque::from([cell]));
                }
            }
        }
        Superpixels { of_cell: superpixel, count }
    }

    /// Level of the mean over a cell and its neighbors.
    fn level(&self, cell: usize, values: &[f64]) -> usize {
        let (sum, count) = self.around(cell).fold((0.0, 0.0), |(sum, n), k| (sum + values[k], n + 1.0));
        ((LEVELS as f64 * sum / count) as usize).min(LEVELS - 1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn superpixels_end_at_borders_and_groups() {
        // 12 x 4 cells: a border in the center of the first group, another group at the right.
        let group: Vec<Option<usize>> = (0..48).map(|k| Some(usize::from(k % 12 >= 9))).collect();
        let border: Vec<f64> = (0..48).map(|k| if k % 12 == 4 { 0.9 } else { 0.0 }).collect();
        let (none, votes) = (vec![0.0; 48], vec![DVec2::ZERO; 48]);
        let grid = CellGrid {
            width: 12,
            group: &group,
            border: &border,
            object: &none,
            vote: &votes,
            center: &none,
        };
        let superpixels = grid.superpixels(&grid.inner_borders());
        assert_eq!(superpixels.count, 3);
        let of = |x: usize| superpixels.of_cell[x];
        assert!(of(0) != of(8) && of(8) != of(11) && of(0).is_some(), "{:?}", superpixels.of_cell);
    }

    #[test]
    fn inner_borders_are_zero_next_to_other_group() {
        let group: Vec<Option<usize>> = (0..48).map(|k| Some(usize::from(k % 12 >= 6))).collect();
        let border = vec![0.8; 48];
        let (none, votes) = (vec![0.0; 48], vec![DVec2::ZERO; 48]);
        let grid = CellGrid {
            width: 12,
            group: &group,
            border: &border,
            object: &none,
            vote: &votes,
            center: &none,
        };
        let inner = grid.inner_borders();
        assert_eq!(inner[..12], [0.8, 0.8, 0.8, 0.8, 0.8, 0.0, 0.0, 0.8, 0.8, 0.8, 0.8, 0.8]);
    }
}
