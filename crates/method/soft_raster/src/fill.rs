//! Layer counts: how many layers of the surface lie over each pixel center, and thus the hard silhouette (1 where
//! there is any).
//!
//! The surface is drawn by its steps, the edges at which layers begin or end (contours and borders). Each row sums the
//! layers that begin to the left (nonzero winding). That is a few hundred lines for thousands of triangles. There are
//! no cracks: an edge's crossing with a row is computed identically, from its upper end, for all triangles that share
//! the edge.

use super::{Grid, MovingPoint, Surface};
use imaging::rounding::ceil_within;

/// An edge at which layers begin or end.
#[derive(Clone, Copy, Debug)]
pub struct Step {
    /// Among the surface's edges.
    pub edge: u32,
    /// Layers to its left, on the way from its first end to its second, less those to its right.
    pub layers: i32,
}

/// Layer counts of a surface, with working memory.
#[derive(Debug, Default)]
pub struct Fill {
    steps: Vec<Step>,
    /// Of each pixel; there are not thousands over one. In between: layers that begin there, less those that end.
    layers: Vec<i16>,
}

impl Fill {
    /// Counts a surface's layers and replaces the previous counts. `clockwise` of each triangle.
    pub fn count<const N: usize>(
        &mut self,
        surface: &Surface,
        points: &[MovingPoint<N>],
        clockwise: &[bool],
        grid: Grid,
    ) {
        self.find_steps(surface, clockwise);
        self.layers.clear();
        self.layers.resize(grid.pixels(), 0);
        let layers = &mut self.layers;
        each_line(surface, points, &self.steps, |upper, lower, begin| {
            begin_along(upper, lower, begin as i16, grid, layers);
        });
        for row in layers.chunks_exact_mut(grid.width_px()) {
            let mut sum = 0;
            for pixel in row {
                sum += *pixel;
                *pixel = sum;
            }
        }
    }

    fn find_steps(&mut self, surface: &Surface, clockwise: &[bool]) {
        self.steps.clear();
        for (number, &pair) in (0..).zip(&surface.pairs) {
            // There layers neither begin nor end.
            if Surface::passes_smoothly(pair, clockwise) {
                continue;
            }
            let edge = &surface.edges[number as usize];
            // A ray meets as many triangles of one orientation of a closed surface as of the other, so the clockwise
            // ones suffice; of an open surface all count, the others reversed.
            let layers: i32 = surface
                .sides(edge)
                .iter()
                .map(|side| match (clockwise[side.triangle as usize], side.back) {
                    (false, _) if surface.closed => 0,
                    (clockwise, back) if clockwise == back => 1,
                    _ => -1,
                })
                .sum();
            if layers != 0 {
                self.steps.push(Step { edge: number, layers });
            }
        }
    }

    pub fn steps(&self) -> &[Step] {
        &self.steps
    }

    /// Over each pixel's center, row-major; of a closed surface those that face one way.
    pub fn layers(&self) -> &[i16] {
        &self.layers
    }
}

/// The lines at which layers begin or end: upper end, lower end, layers that begin there along a row. Where none
/// is left over a position it is outside.
pub fn each_line<const N: usize>(
    surface: &Surface,
    points: &[MovingPoint<N>],
    steps: &[Step],
    mut line: impl FnMut([f32; 2], [f32; 2], i32),
) {
    for step in steps {
        let [a, b] = surface.edges[step.edge as usize].ends.map(|v| points[v as usize].at_px);
        let (upper, lower, layers) = if a[1] <= b[1] { (a, b, step.layers) } else { (b, a, -step.layers) };
        line(upper, lower, layers);
    }
}

fn begin_along(upper: [f32; 2], lower: [f32; 2], begin: i16, grid: Grid, layers: &mut [i16]) {
    let first = ceil_within(upper[1] - 0.5, grid.height_px);
    let end = ceil_within(lower[1] - 0.5, grid.height_px);
    let (width, slope) = (grid.width_px(), (lower[0] - upper[0]) / (lower[1] - upper[1]));
    for y in first..end {
        let x = upper[0] + (y as f32 + 0.5 - upper[1]) * slope;
        let column = ceil_within(x - 0.5, width);
        if column < width {
            layers[y * width + column] += begin;
        }
    }
}
