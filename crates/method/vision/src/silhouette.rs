//! Downsampled mask with per-row prefix sums, for O(rows) overlap with a polygon.

use glam::DVec2;

/// Downsampled crop of a mask. The overlap of an interval takes two lookups per row.
pub(crate) struct Silhouette {
    /// Position of the crop's corner and the side of a cell, pixels.
    origin: DVec2,
    cell_px: f64,
    columns: usize,
    rows: usize,
    /// Prefix sums of the cells of each row.
    sums: Vec<f32>,
    area: f32,
    /// Prefix sums of the occluded cells.
    hidden: Option<Vec<f32>>,
}

/// Weight of an occluded cell that the shape covers, relative to a visible background cell.
const OCCLUDED_WEIGHT: f32 = 0.15;

impl Silhouette {
    /// From pixel indices of an image `width` wide: at most `side` cells a side, with a margin of a quarter.
    pub fn new(indices: &[usize], width: usize, side: usize) -> Self {
        let (mut low, mut high) = ([usize::MAX; 2], [0_usize; 2]);
        for &index in indices {
            let p = [index % width, index / width];
            (0..2).for_each(|k| (low[k], high[k]) = (low[k].min(p[k]), high[k].max(p[k] + 1)));
        }
        let extent = [0, 1].map(|k| high[k].saturating_sub(low[k]).max(1) as f64);
        // Whole pixels, so that inner cells are exactly full.
        let cell_px = (1.5 * extent[0].max(extent[1]) / side as f64).ceil().max(1.0);
        let origin = (DVec2::new(low[0] as f64, low[1] as f64) - 0.25 * DVec2::from_array(extent)).floor();
        let count = |k: usize| (1.5 * extent[k] / cell_px).ceil() as usize + 1;
        let (columns, rows) = (count(0), count(1));
        let mut cells = vec![0.0_f32; columns * rows];
        let share = 1.0 / (cell_px * cell_px) as f32;
        for &index in indices {
            let p = DVec2::new((index % width) as f64 + 0.5, (index / width) as f64 + 0.5) - origin;
            let (c, r) = ((p.x / cell_px) as usize, (p.y / cell_px) as usize);
            cells[r.min(rows - 1) * columns + c.min(columns - 1)] += share;
        }
        let sums = running_sums(&cells, columns);
        let area = sums.chunks_exact(columns + 1).map(|row| row[columns]).sum();
        Self { origin, cell_px, columns, rows, sums, area, hidden: None }
    }

    /// Adds occluders: `in_front` has a flag a pixel of the image, `width` wide. A shape may extend below them at
    /// little cost, within the margin.
    pub fn with_occluders(mut self, in_front: &[bool], width: usize) -> Self {
        let step = self.cell_px as usize;
        let mut cells = vec![0.0_f32; self.columns * self.rows];
        let share = 1.0 / (self.cell_px * self.cell_px) as f32;
        let height = in_front.len() / width.max(1);
        for (index, cell) in cells.iter_mut().enumerate() {
            let corner = [self.origin.x, self.origin.y].map(|from| from as i64);
            let at = [index % self.columns, index / self.columns].map(|k| (k * step) as i64);
            for y in
                (0..step as i64).map(|d| corner[1] + at[1] + d).filter(|y| (0..height as i64).contains(y))
            {
                let xs = (0..step as i64).map(|d| corner[0] + at[0] + d);
                let set = xs
                    .filter(|x| (0..width as i64).contains(x))
                    .filter(|x| in_front[y as usize * width + *x as usize]);
                *cell += share * set.count() as f32;
            }
        }
        self.hidden = cells.iter().any(|cell| *cell > 0.0).then(|| running_sums(&cells, self.columns));
        self
    }

    /// Intersection over union with a shape whose rows are the spans that convex polygons cover (pixels, any
    /// orientation).
    pub fn overlap(&self, polygons: &[Vec<DVec2>]) -> f64 {
        let mut spans = vec![(f64::INFINITY, f64::NEG_INFINITY); self.rows];
        let mut outside = 0.0;
        for polygon in polygons {
            for k in 0..polygon.len() {
                let a = (polygon[k] - self.origin) / self.cell_px;
                let b = (polygon[(k + 1) % polygon.len()] - self.origin) / self.cell_px;
                let (top, bottom) = if a.y <= b.y { (a, b) } else { (b, a) };
                // A part beyond the crop is far from the mask.
                if top.y < -0.5 || bottom.y > self.rows as f64 + 0.5 {
                    outside += (bottom.y.min(1e4) - top.y.max(-1e4)).min(50.0);
                }
                let first = (top.y - 0.5).ceil().max(0.0) as usize;
                for (row, span) in spans.iter_mut().enumerate().skip(first) {
                    let y = row as f64 + 0.5;
                    if y > bottom.y {
                        break;
                    }
                    let t = if bottom.y > top.y { (y - top.y) / (bottom.y - top.y) } else { 0.5 };
                    let x = top.x + t * (bottom.x - top.x);
                    *span = (span.0.min(x), span.1.max(x));
                }
            }
        }
        let (mut both, mut own) = (0.0, 0.0);
        for (row, &(x0, x1)) in spans.iter().enumerate() {
            if x1 > x0 {
                own += (x1 - x0) as f32;
                both += self.sum_to(&self.sums, row, x1) - self.sum_to(&self.sums, row, x0);
                if let Some(hidden) = &self.hidden {
                    let under = self.sum_to(hidden, row, x1) - self.sum_to(hidden, row, x0);
                    own -= (1.0 - OCCLUDED_WEIGHT) * under;
                }
            }
        }
        let either = f64::from(own + self.area - both) + outside;
        f64::from(both) / either.max(1e-9)
    }

    /// Intersection over union with the union of simple polygons (pixels), sampled at the cell centers.
    pub fn overlap_of_polygons(&self, polygons: &[Vec<DVec2>]) -> f64 {
        let in_cells = |p: &DVec2| (*p - self.origin) / self.cell_px;
        let polygons: Vec<Vec<DVec2>> =
            polygons.iter().map(|polygon| polygon.iter().map(in_cells).collect()).collect();
        let (mut both, mut own) = (0.0_f32, 0.0_f32);
        let mut covered = vec![false; self.columns];
        let mut crossings: Vec<f64> = Vec::new();
        for row in 0..self.rows {
            let y = row as f64 + 0.5;
            covered.fill(false);
            for polygon in &polygons {
                crossings.clear();
                let sides = (0..polygon.len()).map(|k| (polygon[k], polygon[(k + 1) % polygon.len()]));
                let crossing = sides.filter(|(a, b)| (a.y > y) != (b.y > y));
                crossings.extend(crossing.map(|(a, b)| a.x + (b.x - a.x) * (y - a.y) / (b.y - a.y)));
                crossings.sort_by(f64::total_cmp);
                for pair in crossings.chunks_exact(2) {
                    let column = |x: f64| ((x - 0.5).ceil().max(0.0) as usize).min(self.columns);
                    let (from, to) = (column(pair[0]), column(pair[1]));
                    covered[from..to.max(from)].fill(true);
                }
            }
            for (column, _) in covered.iter().enumerate().filter(|(_, covered)| **covered) {
                let at = row * (self.columns + 1) + column;
                let within = |sums: &[f32]| sums[at + 1] - sums[at];
                both += within(&self.sums);
                own += 1.0 - self.hidden.as_deref().map_or(0.0, |h| (1.0 - OCCLUDED_WEIGHT) * within(h));
            }
        }
        f64::from(both) / f64::from(own + self.area - both).max(1e-9)
    }

    /// Intersection over union with the union of triangles of projected corners (pixels), sampled at the cell
    /// centers. Triangles of one orientation suffice for a closed shell.
    pub fn overlap_of_triangles(&self, pixels: &[DVec2], triangles: &[[u32; 3]]) -> f64 {
        let corners: Vec<DVec2> = pixels.iter().map(|p| (*p - self.origin) / self.cell_px).collect();
        let mut covered = vec![false; self.columns * self.rows];
        let mut outside = 0.0_f64;
        for t in triangles {
            let [a, b, c] = t.map(|v| corners[v as usize]);
            let area = 0.5 * (b - a).perp_dot(c - a);
            if area <= 0.0 {
                continue;
            }
            let (low, high) = (a.min(b).min(c), a.max(b).max(c));
            // A part beyond the crop is far from the mask.
            let limit = DVec2::new(self.columns as f64 + 0.5, self.rows as f64 + 0.5);
            if low.min_element() < -0.5 || high.cmpgt(limit).any() {
                outside += area.min(50.0);
            }
            let first = (low.y - 0.5).ceil().max(0.0) as usize;
            let last = ((high.y - 0.5).floor() + 1.0).clamp(0.0, self.rows as f64) as usize;
            for row in first..last {
                let y = row as f64 + 0.5;
                let (mut left, mut right) = (f64::INFINITY, f64::NEG_INFINITY);
                for (p, q) in [(a, b), (b, c), (c, a)] {
                    if (p.y <= y) != (q.y <= y) {
                        let x = p.x + (q.x - p.x) * (y - p.y) / (q.y - p.y);
                        (left, right) = (left.min(x), right.max(x));
                    }
                }
                let column = |x: f64| ((x - 0.5).ceil().max(0.0) as usize).min(self.columns);
                if right > left {
                    let row = row * self.columns;
                    covered[row + column(left)..row + column(right).max(column(left))].fill(true);
                }
            }
        }
        let (mut both, mut own) = (0.0_f32, 0.0_f32);
        for (row, covered) in covered.chunks_exact(self.columns).enumerate() {
            for (column, _) in covered.iter().enumerate().filter(|(_, covered)| **covered) {
                let at = row * (self.columns + 1) + column;
                let within = |sums: &[f32]| sums[at + 1] - sums[at];
                both += within(&self.sums);
                own += 1.0 - self.hidden.as_deref().map_or(0.0, |h| (1.0 - OCCLUDED_WEIGHT) * within(h));
            }
        }
        f64::from(both) / (f64::from(own + self.area - both) + outside).max(1e-9)
    }

    fn sum_to(&self, sums: &[f32], row: usize, x: f64) -> f32 {
        let x = x.clamp(0.0, self.columns as f64);
        let whole = (x as usize).min(self.columns - 1);
        let at = row * (self.columns + 1) + whole;
        let rest = (x - whole as f64) as f32;
        sums[at] + rest * (sums[at + 1] - sums[at])
    }
}

/// Prefix sums of the cells of each row.
fn running_sums(cells: &[f32], columns: usize) -> Vec<f32> {
    let mut sums = Vec::with_capacity(cells.len() + cells.len() / columns.max(1));
    for row in cells.chunks_exact(columns) {
        let mut sum = 0.0;
        sums.push(0.0);
        for cell in row {
            sum += cell.min(1.0);
            sums.push(sum);
        }
    }
    sums
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn overlap_of_shifted_square_equals_one_third() {
        let indices: Vec<usize> =
            (0..40).flat_map(|y| (0..40).map(move |x| (y + 30) * 200 + x + 50)).collect();
        for side in [60, 33] {
            let silhouette = Silhouette::new(&indices, 200, side);
            let square = |x: f64| {
                vec![vec![
                    DVec2::new(x, 30.0),
                    DVec2::new(x + 40.0, 30.0),
                    DVec2::new(x + 40.0, 70.0),
                    DVec2::new(x, 70.0),
                ]]
            };
            assert!(silhouette.overlap(&square(50.0)) > 0.95);
            assert!((silhouette.overlap(&square(70.0)) - 1.0 / 3.0).abs() < 0.05);
            let [left, right] = [50.0, 78.0].map(|x| {
                let corners = [(x, 30.0), (x + 12.0, 30.0), (x + 12.0, 70.0), (x, 70.0)];
                corners.map(|(x, y)| DVec2::new(x, y)).to_vec()
            });
            assert!(
                (silhouette.overlap_of_polygons(&[left.clone(), right.clone(), left.clone()]) - 0.6).abs()
                    < 0.06
            );
            // Both orientations, as of a shell's front and back.
            let corners: Vec<DVec2> = left.into_iter().chain(right).collect();
            let halves = [[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7], [2, 1, 0], [7, 6, 4]];
            assert!((silhouette.overlap_of_triangles(&corners, &halves) - 0.6).abs() < 0.06);
        }
    }

    #[test]
    fn overlap_barely_penalizes_shape_below_occluder() {
        let pixels =
            |x0: usize, x1: usize| (0..40).flat_map(move |y| (x0..x1).map(move |x| (y + 30) * 200 + x));
        let left: Vec<usize> = pixels(50, 70).collect();
        let mut in_front = vec![false; 200 * 100];
        pixels(70, 90).for_each(|index| in_front[index] = true);
        let square = vec![
            [(50.0, 30.0), (74.0, 30.0), (74.0, 70.0), (50.0, 70.0)].map(|(x, y)| DVec2::new(x, y)).to_vec(),
        ];
        let alone = Silhouette::new(&left, 200, 60).overlap(&square);
        let hidden = Silhouette::new(&left, 200, 60).with_occluders(&in_front, 200).overlap(&square);
        assert!(
            (alone - 20.0 / 24.0).abs() < 0.04 && (hidden - 20.0 / 20.6).abs() < 0.04,
            "{alone} {hidden}"
        );
    }
}
