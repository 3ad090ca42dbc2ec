//! Which triangle is nearest at each pixel center.
//!
//! A depth buffer, row by row of each triangle. Depth enters as its reciprocal, the *key*, which is linear on the
//! screen and larger where nearer. Of equal keys the first triangle's counts, so the picture is always the same. An
//! edge's crossing with a row is computed alike for all that share the edge. Both sides of a triangle are seen. Cost: grows
//! with the triangles and the pixels they cover, hidden ones included.

use super::{Grid, MovingPoint};
use crate::geometry::rounding::ceil_within;

/// No triangle.
pub const NOTHING: u32 = u32::MAX;

/// Of each pixel the nearest triangle and its key.
#[derive(Debug, Default)]
pub struct Nearest {
    pub width_px: usize,
    pub faces: Vec<u32>,
    pub keys: Vec<f32>,
}

impl Nearest {
    /// Draws triangles with corners at `points` and those `keys`, per vertex, in place of what was drawn before.
    pub fn draw<const N: usize>(
        &mut self,
        triangles: &[[u32; 3]],
        points: &[MovingPoint<N>],
        keys: impl Fn(u32) -> f32,
        grid: Grid,
    ) {
        self.width_px = grid.width_px();
        self.faces.clear();
        self.faces.resize(grid.pixels(), NOTHING);
        self.keys.clear();
        self.keys.resize(grid.pixels(), 0.0);
        for (number, t) in triangles.iter().enumerate() {
            let corners = t.map(|v| {
                let [x, y] = points[v as usize].at_px;
                [x, y, keys(v)]
            });
            self.add(number as u32, corners, grid);
        }
    }

    #[inline]
    fn add(&mut self, number: u32, corners: [[f32; 3]; 3], grid: Grid) {
        let (width, height) = (grid.width_px(), grid.height_px);
        let mut p = corners;
        let before = |a: [f32; 3], b: [f32; 3]| (a[1], a[0]) < (b[1], b[0]);
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
        let slope = |a: [f32; 3], b: [f32; 3]| (b[0] - a[0]) / (b[1] - a[1]);
        let (long, upper, lower) = (slope(p[0], p[2]), slope(p[0], p[1]), slope(p[1], p[2]));
        let [x1, y1, k1] = [0, 1, 2].map(|axis| p[1][axis] - p[0][axis]);
        let [x2, y2, k2] = [0, 1, 2].map(|axis| p[2][axis] - p[0][axis]);
        let per_area = 1.0 / (x1 * y2 - x2 * y1);
        let (key_dx, key_dy) = ((k1 * y2 - k2 * y1) * per_area, (k2 * x1 - k1 * x2) * per_area);
        if !key_dx.is_finite() || !key_dy.is_finite() {
            return;
        }
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
            let at_row = p[0][2] + (center - p[0][1]) * key_dy;
            for x in from..to {
                let key = at_row + (x as f32 + 0.5 - p[0][0]) * key_dx;
                let at = y * width + x;
                if key > self.keys[at] {
                    (self.keys[at], self.faces[at]) = (key, number);
                }
            }
        }
    }
}
