//! Share of an object's color pattern that a category's parts, faces and prints explain.
//!
//! Absolute colors vary freely, so each part takes its best color. The measure is the share of the variance inside
//! the outline that parts, shaded faces and prints of the mesh explain beyond a smooth ramp. Least squares,
//! channel by channel.

use super::observed::Observation;
use super::outline_raster::{NOTHING, Projection, Raster, Stance};
use super::stock_mesh::StockMesh;
use crate::pixels::distance;
use geometry::Camera;

/// Minimum share of the cells of a part with its own column.
const MIN_PART: f64 = 0.03;
/// Columns of a smooth ramp: 1, x, y, x^2, xy, y^2.
const RAMP: usize = 6;
/// Maximum number of columns.
const MAX: usize = 18;

/// Result of the comparison.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Appearance {
    /// Share of the color variance that a smooth ramp explains, and that mesh and ramp explain.
    pub by_ramp: f64,
    pub by_mesh: f64,
    /// Standard deviation of the colors, CIELAB.
    pub contrast: f64,
    /// Mean distance of the parts' colors to those of the category, CIELAB, each at most [`FAR`].
    pub off_palette: f64,
    /// Cells compared.
    pub cells: usize,
}

/// Maximum distance of a color.
const FAR: f32 = 40.0;

/// Compares at a stance; `palette` are the category's colors. `None` if too little of the object is covered.
pub(super) fn compare(
    observed: &Observation,
    camera: &Camera,
    mesh: &StockMesh,
    palette: &[[f32; 3]],
    stance: &Stance,
    raster: &mut Raster,
) -> Option<Appearance> {
    let grid = &observed.grid;
    let through = Projection::new(camera, grid, stance);
    if !raster.draw((grid.columns, grid.rows), &mesh.positions, &mesh.triangles, &through) {
        return None;
    }
    let is_covered = |cell: usize| raster.front()[cell] != NOTHING && observed.cover[cell] > 0.6;
    let cells: Vec<(usize, usize)> = (0..grid.cells())
        .filter(|cell| is_covered(*cell))
        .map(|cell| (cell, raster.front()[cell] as usize))
        .collect();
    if cells.len() < 24 {
        return None;
    }
    let mut counts = vec![0_usize; mesh.part_lab.len()];
    cells.iter().for_each(|(_, triangle)| counts[usize::from(mesh.part[*triangle])] += 1);
    let lowest = (MIN_PART * cells.len() as f64) as usize + 1;
    let mut parts: Vec<usize> = (0..counts.len()).filter(|part| counts[*part] >= lowest).collect();
    parts.sort_by_key(|part| (std::cmp::Reverse(counts[*part]), *part));
    // The largest part needs no column of its own: the ramp has a constant.
    parts.truncate(1 + MAX - RAMP - 4);
    let inner = parts.get(1..).unwrap_or_default();
    let columns = RAMP + 4 + inner.len();
    let turn = glam::Quat::from_rotation_z(stance.yaw_rad as f32);
    let mut mean = [0.0_f32; 3];
    cells
        .iter()
        .for_each(|(cell, _)| (0..3).for_each(|k| mean[k] += observed.lab[*cell][k] / cells.len() as f32));
    let mut fit = LeastSquares::new(columns);
    for (cell, triangle) in &cells {
        let x = (*cell % grid.columns) as f32 / grid.columns as f32 - 0.5;
        let y = (*cell / grid.columns) as f32 / grid.rows as f32 - 0.5;
        let mut row = [0.0_f32; MAX];
        row[..RAMP].copy_from_slice(&[1.0, x, y, x * x, x * y, y * y]);
        row[RAMP..RAMP + 3].copy_from_slice(&(turn * mesh.normal[*triangle]).to_array());
        let part = usize::from(mesh.part[*triangle]);
        row[RAMP + 3] = 0.02 * (mesh.surface_lab[*triangle][0] - mesh.part_lab[part][0]);
        if let Some(at) = inner.iter().position(|other| *other == part) {
            row[RAMP + 4 + at] = 1.0;
        }
        fit.add(&row[..columns], std::array::from_fn(|k| observed.lab[*cell][k] - mean[k]));
    }
    let total = fit.left_by(1);
    let contrast = (total / cells.len() as f64).sqrt();
    // About two units of sensor noise and grain count as explained.
    let noise = 4.0 * cells.len() as f64;
    let explained = |left: f64| 1.0 - (left + noise) / (total + noise);
    let (by_ramp, by_mesh) = (explained(fit.left_by(RAMP)), explained(fit.left_by(columns)));
    Some(Appearance {
        by_ramp,
        by_mesh,
        contrast,
        off_palette: off_palette(observed, mesh, palette, &cells, &parts),
        cells: cells.len(),
    })
}

fn off_palette(
    observed: &Observation,
    mesh: &StockMesh,
    palette: &[[f32; 3]],
    cells: &[(usize, usize)],
    parts: &[usize],
) -> f64 {
    let (mut sum, mut weight) = (0.0, 0.0);
    for part in parts {
        let own = cells.iter().filter(|(_, triangle)| usize::from(mesh.part[*triangle]) == *part);
        let (mut mean, mut count) = ([0.0_f32; 3], 0.0_f32);
        for (cell, _) in own {
            (0..3).for_each(|k| mean[k] += observed.lab[*cell][k]);
            count += 1.0;
        }
        let mean = mean.map(|sum| sum / count.max(1.0));
        // Light and shadow change lightness more than hue.
        let squeezed = |lab: [f32; 3]| [0.5 * lab[0], lab[1], lab[2]];
        let known = palette.iter().chain(std::iter::once(&mesh.part_lab[*part]));
        let nearest = known.map(|lab| distance(squeezed(*lab), squeezed(mean))).fold(FAR, f32::min);
        sum += f64::from(nearest * count);
        weight += f64::from(count);
    }
    sum / f64::max(weight, 1.0)
}

/// Normal equations of three channels over the same columns.
struct LeastSquares {
    columns: usize,
    products: Vec<f64>,
    targets: Vec<[f64; 3]>,
    squares: f64,
}

impl LeastSquares {
    fn new(columns: usize) -> Self {
        let (products, targets) = (vec![0.0; columns * columns], vec![[0.0; 3]; columns]);
        Self { columns, products, targets, squares: 0.0 }
    }

    fn add(&mut self, row: &[f32], color: [f32; 3]) {
        for (i, a) in row.iter().enumerate().filter(|(_, a)| **a != 0.0) {
            for (j, b) in row.iter().enumerate().take(i + 1) {
                self.products[i * self.columns + j] += f64::from(a * b);
            }
            (0..3).for_each(|k| self.targets[i][k] += f64::from(*a) * f64::from(color[k]));
        }
        self.squares += color.iter().map(|c| f64::from(*c).powi(2)).sum::<f64>();
    }

    /// Residual sum of squares of the first columns, with a small ridge, by Cholesky decomposition.
    fn left_by(&self, first: usize) -> f64 {
        let mut lower = vec![0.0; first * first];
        let mut solved = vec![[0.0; 3]; first];
        let mut left = self.squares;
        for i in 0..first {
            for j in 0..=i {
                let inner: f64 = (0..j).map(|k| lower[i * first + k] * lower[j * first + k]).sum();
                let product = self.products[i * self.columns + j];
                lower[i * first + j] = if i == j {
                    (product * 1.001 + 1e-6 - inner).max(1e-9).sqrt()
                } else {
                    (product - inner) / lower[j * first + j]
                };
            }
            let mut own = self.targets[i];
            for (k, other) in solved.iter().enumerate().take(i) {
                own = std::array::from_fn(|channel| own[channel] - lower[i * first + k] * other[channel]);
            }
            solved[i] = own.map(|target| target / lower[i * first + i]);
            left -= solved[i].iter().map(|value: &f64| value.powi(2)).sum::<f64>();
        }
        left.max(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn least_squares_explains_color_by_matching_column_only() {
        let mut fit = LeastSquares::new(3);
        for k in 0..40 {
            let (stripe, ramp) = (f32::from(k % 2 == 0), k as f32 / 40.0);
            fit.add(&[1.0, ramp, stripe], [20.0 * stripe - 10.0, 0.0, 0.0]);
        }
        let [constant, ramp, all] = [1, 2, 3].map(|first| fit.left_by(first));
        assert!((constant - 40.0 * 100.0).abs() < 50.0, "{constant}");
        assert!(ramp > 0.9 * constant && all < 0.02 * constant, "{ramp} {all}");
    }
}
