//! The hard silhouette: 1 at the pixel centers that some triangle covers, 0 elsewhere.
//!
//! A closed surface is drawn by its contour, the edges at which it turns away from the eye, each with the
//! number of layers that begin there: a pixel with a layer is inside (nonzero winding). That is a few hundred
//! lines for thousands of triangles. A surface with a border is drawn triangle by triangle. Neither leaves
//! cracks: an edge's crossing with a row is computed alike for all that share the edge, from its upper end.

use super::{Grid, MovingPoint, Surface};
use crate::geometry::rounding::ceil_within;

/// What drawing one picture after another works in.
#[derive(Debug, Default)]
pub struct Fill {
    /// Of each pixel: layers that begin there, less those that end.
    begins: Vec<i32>,
}

impl Fill {
    /// Draws the surface in place of what `picture` held; row-major. `clockwise` of each triangle.
    pub fn draw<const N: usize>(
        &mut self,
        surface: &Surface,
        points: &[MovingPoint<N>],
        clockwise: &[bool],
        grid: Grid,
        picture: &mut Vec<f32>,
    ) {
        picture.clear();
        picture.resize(grid.pixels(), 0.0);
        let corner = |v: u32| points[v as usize].at_px;
        if !surface.closed {
            surface.triangles.iter().for_each(|t| fill_triangle(t.map(corner), grid, picture));
            return;
        }
        self.begins.clear();
        self.begins.resize(grid.pixels(), 0);
        each_line(surface, points, clockwise, |upper, lower, layers| {
            self.begin_along(upper, lower, layers, grid);
        });
        let width = grid.width_px();
        for (row, begins) in picture.chunks_exact_mut(width).zip(self.begins.chunks_exact(width)) {
            let mut layers = 0;
            for (pixel, begins) in row.iter_mut().zip(begins) {
                layers += begins;
                *pixel = if layers != 0 { 1.0 } else { 0.0 };
            }
        }
    }

    fn begin_along(&mut self, upper: [f32; 2], lower: [f32; 2], layers: i32, grid: Grid) {
        let first = ceil_within(upper[1] - 0.5, grid.height_px);
        let end = ceil_within(lower[1] - 0.5, grid.height_px);
        let (width, slope) = (grid.width_px(), (lower[0] - upper[0]) / (lower[1] - upper[1]));
        for y in first..end {
            let x = upper[0] + (y as f32 + 0.5 - upper[1]) * slope;
            let column = ceil_within(x - 0.5, width);
            if column < width {
                self.begins[y * width + column] += layers;
            }
        }
    }
}

/// The lines at which layers begin or end: upper end, lower end, layers that begin to their right. Where none
/// is left over a position it is outside.
pub fn each_line<const N: usize>(
    surface: &Surface,
    points: &[MovingPoint<N>],
    clockwise: &[bool],
    mut line: impl FnMut([f32; 2], [f32; 2], i32),
) {
    for edge in &surface.edges {
        // Of a closed surface each ray meets as many triangles of one orientation as of the other, and the
        // clockwise ones will do; of any other all count, the others turned over.
        let layers: i32 = surface
            .sides(edge)
            .iter()
            .map(|side| match (clockwise[side.triangle as usize], side.back) {
                (false, _) if surface.closed => 0,
                (clockwise, back) if clockwise == back => -1,
                _ => 1,
            })
            .sum();
        if layers != 0 {
            let [a, b] = edge.ends.map(|v| points[v as usize].at_px);
            let (upper, lower, layers) = if a[1] <= b[1] { (a, b, layers) } else { (b, a, -layers) };
            line(upper, lower, layers);
        }
    }
}

/// Sets the pixels whose centers lie in a triangle, any orientation.
fn fill_triangle(corners: [[f32; 2]; 3], grid: Grid, picture: &mut [f32]) {
    let (width, height) = (grid.width_px(), grid.height_px);
    let mut p = corners;
    // By height, ties by x.
    let before = |a: [f32; 2], b: [f32; 2]| (a[1], a[0]) < (b[1], b[0]);
    if before(p[1], p[0]) {
        p.swap(0, 1);
    }
    if before(p[2], p[1]) {
        p.swap(1, 2);
    }
    if before(p[1], p[0]) {
        p.swap(0, 1);
    }
    let first = ceil_within(p[0][1] - 0.5, height);
    let end = ceil_within(p[2][1] - 0.5, height);
    if first >= end {
        return;
    }
    let slope = |a: [f32; 2], b: [f32; 2]| (b[0] - a[0]) / (b[1] - a[1]);
    let (long, upper, lower) = (slope(p[0], p[2]), slope(p[0], p[1]), slope(p[1], p[2]));
    for y in first..end {
        let center = y as f32 + 0.5;
        let x_long = p[0][0] + (center - p[0][1]) * long;
        let x_short = if center < p[1][1] {
            p[0][0] + (center - p[0][1]) * upper
        } else {
            p[1][0] + (center - p[1][1]) * lower
        };
        let from = ceil_within(x_long.min(x_short) - 0.5, width);
        let to = ceil_within(x_long.max(x_short) - 0.5, width);
        if from < to {
            picture[y * width + from..y * width + to].fill(1.0);
        }
    }
}
