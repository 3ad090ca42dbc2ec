//! Soft coverage from the hard image and the outline: the nearest outline point of each pixel within reach, eight
//! pixels at a time, in parallel bands of rows.

use rayon::prelude::*;
use wide::f32x8;

use super::outline::Piece;
use super::{BLOCK_PX, Grid};

/// Rows of one task.
const BAND_ROWS: usize = 32;

/// x at which the sigmoid is 1e-4 from its limit; farther pixels are left as they are.
const CUT_OFF: f32 = 9.21;

const LANES: [f32; BLOCK_PX] = [0.5, 1.5, 2.5, 3.5, 4.5, 5.5, 6.5, 7.5];

/// Distance from the outline up to which it changes the coverage, pixels.
pub fn reach_px(sigma_px2: f32) -> f32 {
    (CUT_OFF * sigma_px2).sqrt()
}

/// An image's planes or a band of them, all row-major.
pub struct Planes<'a, const N: usize> {
    /// In: hard, 0 or 1. Out: soft.
    pub coverage: &'a mut [f32],
    /// In: 0. In between: derivatives of the squared distance. Out: those of the coverage.
    pub slopes: [&'a mut [f32]; N],
    /// In: infinite. Out: squared distance to the outline where within reach.
    pub nearest_px2: &'a mut [f32],
    /// Of each block; in: false.
    pub near_outline: &'a mut [bool],
}

impl<'a, const N: usize> Planes<'a, N> {
    /// The first rows and the others.
    fn split(self, rows: usize, blocks_across: usize) -> (Self, Self) {
        let pixels = rows * blocks_across * BLOCK_PX;
        let (coverage, coverage_rest) = self.coverage.split_at_mut(pixels);
        let (nearest_px2, nearest_rest) = self.nearest_px2.split_at_mut(pixels);
        let (near_outline, near_rest) = self.near_outline.split_at_mut(rows * blocks_across);
        let mut rests: [&'a mut [f32]; N] = std::array::from_fn(|_| <&mut [f32]>::default());
        let mut k = 0;
        let slopes = self.slopes.map(|plane| {
            let (first, rest) = plane.split_at_mut(pixels);
            rests[k] = rest;
            k += 1;
            first
        });
        (
            Self { coverage, slopes, nearest_px2, near_outline },
            Self {
                coverage: coverage_rest,
                slopes: rests,
                nearest_px2: nearest_rest,
                near_outline: near_rest,
            },
        )
    }
}

/// Softens the hard image along the outline. Pieces are taken in their order in every band, so ties are
/// decided alike with any number of threads.
pub fn soften<'a, const N: usize>(pieces: &'a [Piece<N>], grid: Grid, sigma_px2: f32, planes: Planes<'a, N>) {
    let mut bands = Vec::with_capacity(grid.height_px.div_ceil(BAND_ROWS));
    let (mut rest, mut first_row) = (planes, 0);
    while first_row < grid.height_px {
        let rows = BAND_ROWS.min(grid.height_px - first_row);
        let (band, others) = rest.split(rows, grid.blocks_across);
        let pieces = Vec::with_capacity(pieces.len());
        bands.push(Band { first_row, rows, blocks_across: grid.blocks_across, planes: band, pieces });
        (rest, first_row) = (others, first_row + rows);
    }
    let reach = reach_px(sigma_px2);
    for piece in pieces {
        let [a, b] = piece.ends.map(|end| end.at_px[1]);
        // A row more to both sides than it can reach.
        let first = (a.min(b) - reach - 1.0).max(0.0) as usize / BAND_ROWS;
        let end = ((a.max(b) + reach + 1.0).max(0.0) as usize / BAND_ROWS + 1).min(bands.len());
        (first..end).for_each(|band| bands[band].pieces.push(piece));
    }
    bands.into_par_iter().for_each(|mut band| {
        std::mem::take(&mut band.pieces).into_iter().for_each(|piece| band.approach(piece, reach));
        band.finish(sigma_px2);
    });
}

struct Band<'a, const N: usize> {
    first_row: usize,
    rows: usize,
    blocks_across: usize,
    planes: Planes<'a, N>,
    /// Pieces that may be within reach, in their order.
    pieces: Vec<&'a Piece<N>>,
}

#[inline]
fn load(plane: &[f32], at: usize) -> f32x8 {
    let mut lanes = [0.0; BLOCK_PX];
    lanes.copy_from_slice(&plane[at..at + BLOCK_PX]);
    f32x8::from(lanes)
}

#[inline]
fn store(plane: &mut [f32], at: usize, value: f32x8) {
    plane[at..at + BLOCK_PX].copy_from_slice(&value.to_array());
}

impl<const N: usize> Band<'_, N> {
    /// Updates the pixels within reach of a piece.
    fn approach(&mut self, piece: &Piece<N>, reach: f32) {
        let [a, b] = piece.ends.map(|end| end.at_px);
        let top = self.first_row as f32;
        let (low, high) = (a[1].min(b[1]) - reach, a[1].max(b[1]) + reach);
        if high <= top || low >= top + self.rows as f32 {
            return;
        }
        let [dx, dy] = [b[0] - a[0], b[1] - a[1]];
        let per_length2 = 1.0 / (dx * dx + dy * dy).max(1e-12);
        let per_rise = 1.0 / dy;
        // Pixels are decided by their distance; this margin makes up for rounding.
        let widely = reach + 1e-3 + 1e-6 * (dx.abs() + dy.abs());
        let first = (low - top - 0.5).max(0.0) as usize;
        let end = ((high - top + 0.5).max(0.0) as usize).min(self.rows);
        for row in first..end {
            let y = top + row as f32 + 0.5;
            // Columns: those of the part of the piece within reach of the row.
            let share = |y: f32| ((y - a[1]) * per_rise).clamp(0.0, 1.0);
            let (t, u) = if dy.abs() < 1e-6 { (0.0, 1.0) } else { (share(y - widely), share(y + widely)) };
            let (left, right) = (a[0] + t * dx, a[0] + u * dx);
            let (left, right) = (left.min(right) - widely, left.max(right) + widely);
            if right <= 0.0 {
                continue;
            }
            let first = left.max(0.0) as usize / BLOCK_PX;
            let end = (right as usize / BLOCK_PX + 1).min(self.blocks_across);
            let wy = y - a[1];
            for block in first..end {
                let at = (row * self.blocks_across + block) * BLOCK_PX;
                let wx = f32x8::from(LANES) + f32x8::splat((block * BLOCK_PX) as f32 - a[0]);
                let t = (wx * f32x8::splat(dx * per_length2) + f32x8::splat(wy * dy * per_length2))
                    .fast_max(f32x8::ZERO)
                    .fast_min(f32x8::ONE);
                let (cx, cy) = (wx - t * f32x8::splat(dx), f32x8::splat(wy) - t * f32x8::splat(dy));
                let distance2 = cx * cx + cy * cy;
                let before = load(self.planes.nearest_px2, at);
                let closer = distance2.simd_lt(before.fast_min(f32x8::splat(reach * reach)));
                if closer.to_bitmask() == 0 {
                    continue;
                }
                self.planes.near_outline[row * self.blocks_across + block] = true;
                store(self.planes.nearest_px2, at, closer.bitselect(distance2, before));
                for (k, plane) in self.planes.slopes.iter_mut().enumerate() {
                    // d(|p - c|^2) = -2 (p - c) dc; the point c's own sliding along the piece does not count,
                    // it is at right angles to p - c.
                    let [from, to] = piece.ends.map(|end| end.slopes[k]);
                    let vx = f32x8::splat(from[0]) + t * f32x8::splat(to[0] - from[0]);
                    let vy = f32x8::splat(from[1]) + t * f32x8::splat(to[1] - from[1]);
                    let slope = f32x8::splat(-2.0) * (cx * vx + cy * vy);
                    let old = load(plane, at);
                    store(plane, at, closer.bitselect(slope, old));
                }
            }
        }
    }

    /// Eq. 1 of the paper, with its derivative.
    fn finish(&mut self, sigma_px2: f32) {
        let per_sigma = f32x8::splat(1.0 / sigma_px2);
        for block in 0..self.rows * self.blocks_across {
            if !self.planes.near_outline[block] {
                continue;
            }
            let at = block * BLOCK_PX;
            let (hard, distance2) = (load(self.planes.coverage, at), load(self.planes.nearest_px2, at));
            let sign = hard + hard - f32x8::ONE;
            let near = distance2.simd_lt(f32x8::splat(f32::INFINITY));
            let x = near.bitselect(sign * distance2 * per_sigma, f32x8::ZERO);
            let soft = f32x8::ONE / (f32x8::ONE + (-x).exp());
            store(self.planes.coverage, at, near.bitselect(soft, hard));
            // Where the outline is out of reach the slope of the distance is still 0.
            let gain = soft * (f32x8::ONE - soft) * sign * per_sigma;
            for plane in &mut self.planes.slopes {
                let slope = load(plane, at) * gain;
                store(plane, at, slope);
            }
        }
    }
}
