//! Silhouettes as bits: a row of the image is a few machine words. Twice as fine as the image in both
//! directions, so counting bits gives each pixel's coverage in quarters.
//!
//! A closed surface is drawn by its contour: the edges at which it turns away from the eye, each with the
//! number of layers that end there; what has a layer is inside (nonzero winding). A surface with a border
//! is drawn triangle by triangle. Both set the same bits of a closed surface.

mod coverage;

pub use coverage::{BLOCK_PX, BlockRow, Coverage, each};

use imaging::rounding::{ceil_within, floor};

/// A square image, built bit by bit.
#[derive(Default)]
pub struct BitImage {
    side_bits: usize,
    words: usize,
    bits: Vec<u64>,
    /// Crossings of contour lines with the rows' centers: of each row the bit from which on a crossing counts, in the
    /// upper half, and the layers that begin there, above [`NO_LAYERS`].
    crossings: Vec<Vec<u32>>,
}

/// Offset of the layer counts, so that they need no sign.
const NO_LAYERS: u32 = 1 << 15;

impl BitImage {
    /// Empties the image and makes it `side_px` pixels wide and high (a multiple of 32, at most
    /// 1024), two bits each way.
    pub fn clear(&mut self, side_px: usize) {
        self.side_bits = 2 * side_px;
        self.words = self.side_bits.div_ceil(64);
        self.bits.clear();
        self.bits.resize(self.words * self.side_bits, 0);
    }

    /// Sets the bits inside closed contours: lines with the number of layers to one side of them (any side,
    /// as long as it is the same for all; fewer than 2^15).
    pub fn fill_contour(&mut self, lines: impl Iterator<Item = ([f32; 2], [f32; 2], i32)>) {
        let mut crossings = std::mem::take(&mut self.crossings);
        crossings.resize(self.side_bits, Vec::new());
        let (mut top, mut bottom) = (self.side_bits, 0);
        for (a, b, layers) in lines {
            let (a, b) = ([2.0 * a[0], 2.0 * a[1]], [2.0 * b[0], 2.0 * b[1]]);
            let (upper, lower, layers) = if a[1] <= b[1] { (a, b, layers) } else { (b, a, -layers) };
            let first = ceil_within(upper[1] - 0.5, self.side_bits);
            let end = ceil_within(lower[1] - 0.5, self.side_bits);
            if first >= end {
                continue;
            }
            (top, bottom) = (top.min(first), bottom.max(end));
            let slope = (lower[0] - upper[0]) / (lower[1] - upper[1]);
            let begins = NO_LAYERS.wrapping_add_signed(layers);
            let last_bit = self.side_bits as f32;
            for (y, row) in (first..end).zip(&mut crossings[first..end]) {
                let x = upper[0] + (y as f32 + 0.5 - upper[1]) * slope;
                let bit = -floor(-(x - 0.5).clamp(0.0, last_bit));
                row.push((bit as u32) << 16 | begins);
            }
        }
        for (y, row) in (top..bottom).zip(crossings.iter_mut().skip(top)) {
            row.sort_unstable();
            let (mut depth, mut from) = (0, 0);
            for crossing in row.drain(..) {
                let bit = crossing >> 16;
                if depth == 0 {
                    from = bit;
                }
                depth += (crossing & 0xffff).cast_signed() - NO_LAYERS.cast_signed();
                if depth == 0 {
                    self.set(y, from as usize, bit as usize);
                }
            }
        }
        self.crossings = crossings;
    }

    /// Sets the bits whose centers lie in the triangle (pixel coordinates; any orientation).
    #[inline]
    pub fn fill(&mut self, corners: [[f32; 2]; 3]) {
        let mut p = corners.map(|[x, y]| (2.0 * x, 2.0 * y));
        // By height, ties by x: the two triangles at an edge walk it the same way.
        let before = |a: (f32, f32), b: (f32, f32)| (a.1, a.0) < (b.1, b.0);
        if before(p[1], p[0]) {
            p.swap(0, 1);
        }
        if before(p[2], p[1]) {
            p.swap(1, 2);
        }
        if before(p[1], p[0]) {
            p.swap(0, 1);
        }
        let first = ceil_within(p[0].1 - 0.5, self.side_bits);
        let end = ceil_within(p[2].1 - 0.5, self.side_bits);
        if first >= end {
            return;
        }
        let slope = |a: (f32, f32), b: (f32, f32)| (b.0 - a.0) / (b.1 - a.1);
        let (long, upper, lower) = (slope(p[0], p[2]), slope(p[0], p[1]), slope(p[1], p[2]));
        for y in first..end {
            let center = y as f32 + 0.5;
            let x_long = p[0].0 + (center - p[0].1) * long;
            let x_short = if center < p[1].1 {
                p[0].0 + (center - p[0].1) * upper
            } else {
                p[1].0 + (center - p[1].1) * lower
            };
            let (left, right) = (x_long.min(x_short), x_long.max(x_short));
            let (from, to) =
                (ceil_within(left - 0.5, self.side_bits), ceil_within(right - 0.5, self.side_bits));
            self.set(y, from, to);
        }
    }

    /// Sets the bits `from..to` of a row.
    #[inline]
    fn set(&mut self, y: usize, from: usize, to: usize) {
        if from >= to {
            return;
        }
        let row = &mut self.bits[y * self.words..(y + 1) * self.words];
        let (first, last) = (from / 64, (to - 1) / 64);
        let head = u64::MAX << (from % 64);
        let tail = u64::MAX >> (63 - (to - 1) % 64);
        if first == last {
            row[first] |= head & tail;
        } else {
            row[first] |= head;
            row[first + 1..last].fill(u64::MAX);
            row[last] |= tail;
        }
    }

    /// Coverage of its pixels.
    pub fn cover(&self, coverage: &mut Coverage) {
        coverage.cover(self.side_bits / 2, &self.bits, self.words);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn drawn(side_px: usize, draw: impl FnOnce(&mut BitImage)) -> Vec<f32> {
        let mut image = BitImage::default();
        image.clear(side_px);
        draw(&mut image);
        let mut coverage = Coverage::default();
        image.cover(&mut coverage);
        let pixels: Vec<f32> = (0..side_px).flat_map(|y| coverage.from(y, 1)[..side_px].to_vec()).collect();
        // Previous content leaves no trace.
        let mut used = Coverage::default();
        let mut other = BitImage::default();
        other.clear(side_px);
        other.fill([[0.3, 1.2], [0.9 * side_px as f32, 3.0], [2.0, side_px as f32]]);
        other.cover(&mut used);
        image.cover(&mut used);
        for (y, row) in pixels.chunks(side_px).enumerate() {
            assert_eq!(used.from(y, 1)[..side_px], *row);
            for (block, pixels) in row.chunks(BLOCK_PX).enumerate() {
                assert_eq!(coverage.covered(y) >> block & 1 == 1, pixels.iter().any(|p| *p > 0.0));
                let even = (y.max(1) - 1..(y + 2).min(side_px)).all(|v| {
                    let from = (block * BLOCK_PX).max(BLOCK_PX) - BLOCK_PX;
                    let to = ((block + 2) * BLOCK_PX).min(side_px);
                    let all = &pixels_of(&coverage, v, side_px)[from..to];
                    all.iter().all(|p| *p == pixels[0] && p.fract() == 0.0)
                });
                assert_eq!(coverage.outline(y) >> block & 1 == 0, even, "{y} {block}");
            }
        }
        pixels
    }

    fn pixels_of(coverage: &Coverage, y: usize, side_px: usize) -> Vec<f32> {
        coverage.from(y, 1)[..side_px].to_vec()
    }

    #[test]
    fn two_triangles_make_a_square_of_the_right_area() {
        let (a, b, c, d) = ([3.2, 4.1], [20.7, 4.1], [20.7, 25.6], [3.2, 25.6]);
        let coverage = drawn(32, |image| {
            image.fill([a, b, c]);
            image.fill([c, d, a]);
        });
        let area: f32 = coverage.iter().sum();
        assert!((area - 17.5 * 21.5).abs() < 12.0, "{area}");
        assert_eq!((coverage[10 * 32 + 10], coverage[10 * 32 + 2], coverage[10 * 32 + 21]), (1.0, 0.0, 0.0));
    }

    #[test]
    fn fill_contour_equals_triangle_fill() {
        let corners = [[2.3, 3.1], [50.7, 8.4], [61.2, 40.9], [30.1, 62.5], [5.5, 44.4]];
        let hole = [[20.2, 20.1], [20.9, 35.3], [33.8, 30.2]];
        let around = |p: &[[f32; 2]], layers: i32| -> Vec<([f32; 2], [f32; 2], i32)> {
            (0..p.len()).map(|k| (p[k], p[(k + 1) % p.len()], layers)).collect()
        };
        let triangles = drawn(64, |image| {
            (1..4).for_each(|k| image.fill([corners[0], corners[k], corners[k + 1]]));
        });
        let contour = drawn(64, |image| image.fill_contour(around(&corners, 1).into_iter()));
        assert_eq!(contour, triangles);
        // Counted twice it is still inside; a hole in one layer only is none.
        let twice = drawn(64, |image| {
            image.fill_contour(around(&corners, 2).into_iter().chain(around(&hole, 1)));
        });
        assert_eq!(twice, triangles);
        let pierced = drawn(64, |image| {
            image.fill_contour(around(&corners, 1).into_iter().chain(around(&hole, 1)));
        });
        assert_eq!((pierced[28 * 64 + 24], pierced[10 * 64 + 24]), (0.0, 1.0));
    }
}
