//! Depth buffer: the nearest triangle at each pixel center.
//!
//! Triangles are drawn row by row. Depth enters as its reciprocal, the *key*, which is linear on the screen and larger
//! where nearer. Of equal keys the first triangle's counts, so the image is always the same. An edge's crossing with a
//! row is computed identically for all triangles that share the edge. Both sides of a triangle are visible. Cost:
//! grows with the triangles and the pixels they cover, hidden ones included.

use std::ops::Range;

use wide::bytemuck::cast;
use wide::{f32x4, u32x4};

use super::{Grid, MovingPoint};
use imaging::rounding::{ceil_within, lesser};

/// No triangle.
pub const NOTHING: u32 = u32::MAX;

/// Bound on the rounding of a row's first and last pixel, pixels and share of the coordinates.
const SLIP_PX: f32 = 1e-3;
const SLIP_SHARE: f32 = 1e-6;

/// Pixels that are drawn together.
const LANES: usize = 4;

/// Of each pixel the nearest triangle and its key.
#[derive(Debug, Default)]
pub struct Nearest {
    pub width_px: usize,
    pub faces: Vec<u32>,
    pub keys: Vec<f32>,
    /// Of each vertex x, y and key.
    corners: Vec<[f32; 3]>,
    /// Place of each vertex among the pixels' centers.
    places: Vec<Place>,
}

/// For a vertex the first row and column of pixel centers at or beyond it, and both negated, so that the minima over
/// three vertices are the bounds of their triangle. Columns have a margin for rounding.
#[derive(Clone, Copy, Debug)]
struct Place(f32x4);

impl Place {
    fn new([x, y]: [f32; 2], slip_px: f32, grid: Grid) -> Self {
        let row = ceil_within(y - 0.5, grid.height_px) as f32;
        let column = |x: f32| ceil_within(x - 0.5, grid.width_px()) as f32;
        Self(f32x4::from([row, column(x - slip_px), -row, -column(x + slip_px)]))
    }

    /// Columns and rows in which the triangle between three vertices may have pixels.
    #[inline]
    fn around([a, b, c]: [Self; 3]) -> Option<[Range<usize>; 2]> {
        let [top, left, bottom, right] = a.0.fast_min(b.0).fast_min(c.0).to_array();
        let found = (top < -bottom) & (left < -right);
        found.then(|| [left as usize..-right as usize, top as usize..-bottom as usize])
    }
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
        self.corners.clear();
        self.corners.extend((0..).zip(points).map(|(v, point)| [point.at_px[0], point.at_px[1], keys(v)]));
        let farthest_px = points.iter().fold(0.0, |far, point| -lesser(-far, -point.at_px[0].abs()));
        let slip_px = SLIP_PX + 2.0 * SLIP_SHARE * farthest_px;
        self.places.clear();
        self.places.extend(points.iter().map(|point| Place::new(point.at_px, slip_px, grid)));
        for (number, &t) in (0..).zip(triangles) {
            // Most triangles are so small that they pass between the centers.
            if let Some(around) = Place::around(t.map(|v| self.places[v as usize])) {
                self.add(number, t, around);
            }
        }
    }

    fn add(&mut self, number: u32, triangle: [u32; 3], [columns, rows]: [Range<usize>; 2]) {
        let p = self.downward(triangle);
        let slope = |a: [f32; 3], b: [f32; 3]| (b[0] - a[0]) / (b[1] - a[1]);
        let (long, upper, lower) = (slope(p[0], p[2]), slope(p[0], p[1]), slope(p[1], p[2]));
        let [x1, y1, k1] = [0, 1, 2].map(|axis| p[1][axis] - p[0][axis]);
        let [x2, y2, k2] = [0, 1, 2].map(|axis| p[2][axis] - p[0][axis]);
        let per_area = 1.0 / (x1 * y2 - x2 * y1);
        let (key_dx, key_dy) = ((k1 * y2 - k2 * y1) * per_area, (k2 * x1 - k1 * x2) * per_area);
        if !key_dx.is_finite() || !key_dy.is_finite() {
            return;
        }
        let (half, left) = (f32x4::splat(0.5), f32x4::splat(p[0][0]));
        let (number, key_dx) = (u32x4::splat(number), f32x4::splat(key_dx));
        for y in rows {
            let center = y as f32 + 0.5;
            let x_long = p[0][0] + (center - p[0][1]) * long;
            let x_short = if center < p[1][1] {
                p[0][0] + (center - p[0][1]) * upper
            } else {
                p[1][0] + (center - p[1][1]) * lower
            };
            let from = f32x4::splat(x_long.min(x_short) - 0.5);
            let end = f32x4::splat(x_long.max(x_short) - 0.5);
            let at_row = f32x4::splat(p[0][2] + (center - p[0][1]) * key_dy);
            // Four pixels at once, inside or outside the row's span: spans are too short for branch prediction.
            let row = y * self.width_px..(y + 1) * self.width_px;
            let (keys, faces) = (&mut self.keys[row.clone()], &mut self.faces[row]);
            for first in columns.clone().step_by(LANES) {
                let first = first.min(keys.len() - LANES);
                let (keys, faces) = (&mut keys[first..first + LANES], &mut faces[first..first + LANES]);
                let x = f32x4::splat(first as f32) + f32x4::from([0.0, 1.0, 2.0, 3.0]);
                let key = at_row + (x + half - left) * key_dx;
                let before = f32x4::from([keys[0], keys[1], keys[2], keys[3]]);
                let nearer = x.simd_ge(from) & x.simd_lt(end) & key.simd_gt(before);
                keys.copy_from_slice(&nearer.bitselect(key, before).to_array());
                let before = u32x4::from([faces[0], faces[1], faces[2], faces[3]]);
                let nearer: u32x4 = cast(nearer);
                faces.copy_from_slice(&nearer.bitselect(number, before).to_array());
            }
        }
    }

    /// A triangle's corners by y, then x. Without branches: the order cannot be foreseen.
    #[inline]
    fn downward(&self, triangle: [u32; 3]) -> [[f32; 3]; 3] {
        let corners = triangle.map(|v| self.corners[v as usize]);
        let before = |a: usize, b: usize| {
            let ([ax, ay, _], [bx, by, _]) = (corners[a], corners[b]);
            usize::from((ay < by) | ((ay == by) & (ax < bx)))
        };
        let (swap_01, swap_02, swap_12) = (before(1, 0), before(2, 0), before(2, 1));
        let mut sorted = triangle;
        sorted[swap_01 + swap_02] = triangle[0];
        sorted[1 - swap_01 + swap_12] = triangle[1];
        sorted[2 - swap_02 - swap_12] = triangle[2];
        sorted.map(|v| self.corners[v as usize])
    }
}
