//! Silhouettes of triangle soups as bits: a row of the picture is a few machine words, a triangle ors
//! its spans into them. Twice as fine as the picture in both directions, so counting bits gives each
//! pixel's coverage in quarters.

/// Coverage of a square picture, built bit by bit.
pub struct BitPicture {
    side_bits: usize,
    words: usize,
    bits: Vec<u64>,
}

impl BitPicture {
    /// An empty picture of `side_px` pixels (a multiple of 32), two bits each way.
    pub fn new(side_px: usize) -> Self {
        let side_bits = 2 * side_px;
        let words = side_bits.div_ceil(64);
        Self { side_bits, words, bits: vec![0; words * side_bits] }
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
        let first = (p[0].1 - 0.5).ceil().max(0.0);
        let end = (p[2].1 - 0.5).ceil().min(self.side_bits as f32);
        if first < end {
            let slope = |a: (f32, f32), b: (f32, f32)| (b.0 - a.0) / (b.1 - a.1);
            let (long, upper, lower) = (slope(p[0], p[2]), slope(p[0], p[1]), slope(p[1], p[2]));
            for y in first as usize..end as usize {
                let center = y as f32 + 0.5;
                let x_long = p[0].0 + (center - p[0].1) * long;
                let x_short = if center < p[1].1 {
                    p[0].0 + (center - p[0].1) * upper
                } else {
                    p[1].0 + (center - p[1].1) * lower
                };
                self.span(y, x_long.min(x_short), x_long.max(x_short));
            }
        }
    }

    #[inline]
    fn span(&mut self, y: usize, left: f32, right: f32) {
        let from = (left - 0.5).ceil().max(0.0) as usize;
        let to = (right - 0.5).ceil().clamp(0.0, self.side_bits as f32) as usize;
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

    /// Coverage 0..1 of each pixel, row-major, written into `out`.
    pub fn coverage(&self, out: &mut [f32]) {
        const COUNTS: [u8; 4] = [0, 1, 1, 2];
        let side_px = self.side_bits / 2;
        for (y, row) in out.chunks_exact_mut(side_px).enumerate() {
            let upper = &self.bits[2 * y * self.words..(2 * y + 1) * self.words];
            let lower = &self.bits[(2 * y + 1) * self.words..(2 * y + 2) * self.words];
            for (word, pixels) in row.chunks_mut(32).enumerate() {
                let (mut a, mut b) = (upper[word], lower[word]);
                if a | b == 0 {
                    pixels.fill(0.0);
                    continue;
                }
                if a & b == u64::MAX {
                    pixels.fill(1.0);
                    continue;
                }
                for pixel in pixels {
                    *pixel = 0.25 * f32::from(COUNTS[(a & 3) as usize] + COUNTS[(b & 3) as usize]);
                    a >>= 2;
                    b >>= 2;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_triangles_make_a_square_of_the_right_area() {
        let mut picture = BitPicture::new(32);
        let corner = |x: f32, y: f32| [x, y];
        let (a, b, c, d) = (corner(3.2, 4.1), corner(20.7, 4.1), corner(20.7, 25.6), corner(3.2, 25.6));
        picture.fill([a, b, c]);
        picture.fill([c, d, a]);
        let mut coverage = vec![0.0; 32 * 32];
        picture.coverage(&mut coverage);
        let area: f32 = coverage.iter().sum();
        assert!((area - 17.5 * 21.5).abs() < 12.0, "{area}");
        assert_eq!((coverage[10 * 32 + 10], coverage[10 * 32 + 2], coverage[10 * 32 + 21]), (1.0, 0.0, 0.0));
    }
}
