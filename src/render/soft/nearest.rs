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

/// By how much rounding may move a row's first and last pixel, pixels and share of the coordinates.
const SLIP_PX: f32 = 1e-3;
const SLIP_SHARE: f32 = 1e-6;

/// Of each pixel the nearest triangle and its key.
#[derive(Debug, Default)]
pub struct Nearest {
    pub width_px: usize,
    pub faces: Vec<u32>,
    pub keys: Vec<f32>,
    /// Of each vertex x, y and key.
    corners: Vec<[f32; 3]>,
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
        let mut corners = std::mem::take(&mut self.corners);
        corners.clear();
        corners.extend((0..).zip(points).map(|(v, point)| [point.at_px[0], point.at_px[1], keys(v)]));
        for (number, t) in triangles.iter().enumerate() {
            self.add(number as u32, t.map(|v| corners[v as usize]), grid);
        }
        self.corners = corners;
    }

    #[inline]
    fn add(&mut self, number: u32, corners: [[f32; 3]; 3], grid: Grid) {
        let (width, height) = (grid.width_px(), grid.height_px);
        // Most triangles are so small that they pass between the centers.
        let [xs, ys] = [0, 1].map(|axis| corners.map(|p| p[axis]));
        let least = |c: [f32; 3]| lesser(lesser(c[0], c[1]), c[2]);
        let most = |c: [f32; 3]| -least(c.map(|c| -c));
        let (first, end) = (ceil_within(least(ys) - 0.5, height), ceil_within(most(ys) - 0.5, height));
        if first >= end {
            return;
        }
        let (left, right) = (least(xs), most(xs));
        let slip = SLIP_PX + SLIP_SHARE * (left.abs() + right.abs());
        if ceil_within(left - slip - 0.5, width) >= ceil_within(right + slip - 0.5, width) {
            return;
        }
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
            if from >= to {
                continue;
            }
            let at_row = p[0][2] + (center - p[0][1]) * key_dy;
            let row = y * width + from..y * width + to;
            let pixels = self.keys[row.clone()].iter_mut().zip(&mut self.faces[row]);
            for (x, (nearest, face)) in (from..to).zip(pixels) {
                let key = at_row + (x as f32 + 0.5 - p[0][0]) * key_dx;
                if key > *nearest {
                    (*nearest, *face) = (key, number);
                }
            }
        }
    }
}

/// As a single instruction.
#[inline]
fn lesser(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}
