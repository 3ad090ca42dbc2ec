//! Rasterization of a band: the visible triangle at each pixel center, eight pixels at a time.
//!
//! Edge functions are evaluated from the edge's lexicographically smaller end. The two triangles that share an edge
//! thus compute the same number to the bit, and exactly one of them takes a pixel center that lies on it: no cracks,
//! no pixel drawn twice.

use wide::f32x8;

use super::prepare::{ScreenTriangle, covered};

/// No triangle.
pub const NOTHING: u32 = u32::MAX;

/// Rows `first_row..first_row + rows` of an image: nearest depth key and its triangle at each pixel.
#[derive(Clone)]
pub struct Band {
    pub first_row: usize,
    pub rows: usize,
    pub width_px: usize,
    /// Row length of the buffers: the width and eight to spare.
    stride: usize,
    keys: Vec<f32>,
    /// Source index of the triangle in front, as bits of a float so that lanes of both buffers move alike.
    sources: Vec<f32>,
}

/// Rows wider than this are cut to the span that the triangle covers, pixels.
const WIDE_PX: usize = 16;

/// A triangle's edge functions, prepared for a row loop.
pub struct Edges {
    /// Start, and extent along x and y, of each edge; turned so that inside is positive.
    start: [(f32, f32); 3],
    extent: [(f32, f32); 3],
    /// Smallest edge value that counts as inside.
    threshold: [f32; 3],
    key_at_start: f32,
    key_dx: f32,
    key_dy: f32,
    key_low: f32,
    key_high: f32,
}

/// Lowest and highest pixel center of two ranges in a row.
struct Span {
    touched: (f32, f32),
    inside: (f32, f32),
}

impl Edges {
    /// `None` for a triangle without area.
    #[inline]
    pub fn new(t: &ScreenTriangle) -> Option<Self> {
        // In f64: for slivers the difference of products in f32 would be rounding alone.
        let (x1, y1) = (f64::from(t.x[1]) - f64::from(t.x[0]), f64::from(t.y[1]) - f64::from(t.y[0]));
        let (x2, y2) = (f64::from(t.x[2]) - f64::from(t.x[0]), f64::from(t.y[2]) - f64::from(t.y[0]));
        let area = x1 * y2 - y1 * x2;
        if area == 0.0 || !area.is_finite() {
            return None;
        }
        let mut edges = Self {
            start: [(0.0, 0.0); 3],
            extent: [(0.0, 0.0); 3],
            threshold: [0.0; 3],
            key_at_start: t.key[0],
            key_dx: 0.0,
            key_dy: 0.0,
            key_low: t.key[0].min(t.key[1]).min(t.key[2]),
            key_high: t.key[0].max(t.key[1]).max(t.key[2]),
        };
        for k in 0..3 {
            let j = (k + 1) % 3;
            let (a, b) = ((t.x[k], t.y[k]), (t.x[j], t.y[j]));
            let forward = a < b;
            let (from, to) = if forward { (a, b) } else { (b, a) };
            // e(p) = (p.y - from.y) * dx - (p.x - from.x) * dy is positive left of the directed edge
            // (y down: for area > 0 inside is where e of the edge a -> b is positive).
            let turned = forward == (area > 0.0);
            let sign = if turned { 1.0 } else { -1.0 };
            edges.start[k] = from;
            edges.extent[k] = (sign * (to.0 - from.0), sign * (to.1 - from.1));
            // On a shared edge the value is 0 in both triangles. Only the one on the edge's positive side takes it as
            // inside.
            edges.threshold[k] = if turned { 0.0 } else { f32::MIN_POSITIVE };
        }
        let (k1, k2) = (f64::from(t.key[1] - t.key[0]), f64::from(t.key[2] - t.key[0]));
        edges.key_dx = ((k1 * y2 - k2 * y1) / area) as f32;
        edges.key_dy = ((k2 * x1 - k1 * x2) / area) as f32;
        Some(edges)
    }

    /// Range of pixel centers at which the row through `py` touches the triangle, and the range at which it is
    /// certainly inside. The tests between the two decide, so both keep a margin above any rounding error.
    fn span(&self, py: f32) -> Span {
        let mut span = Span { touched: (f32::MIN, f32::MAX), inside: (f32::MIN, f32::MAX) };
        for ((sx, sy), (ex, ey)) in self.start.iter().zip(self.extent) {
            let offset = (py - sy) * (ex / ey);
            let margin = 1.0 + 1e-5 * (sx.abs() + offset.abs());
            let (before, after) = (sx + offset - margin, sx + offset + margin);
            if !margin.is_finite() {
                // A level edge: no column says on which side of it the row runs.
                span.inside = (f32::MAX, f32::MIN);
            } else if ey > 0.0 {
                span.touched.1 = span.touched.1.min(after);
                span.inside.1 = span.inside.1.min(before);
            } else {
                span.touched.0 = span.touched.0.max(before);
                span.inside.0 = span.inside.0.max(after);
            }
        }
        span
    }

    /// Mask of eight pixel centers `(px, py)`.
    #[inline]
    fn test(&self, px: f32x8, py: f32) -> f32x8 {
        let value = |k: usize| {
            let ((sx, sy), (ex, ey)) = (self.start[k], self.extent[k]);
            f32x8::splat((py - sy) * ex) - (px - f32x8::splat(sx)) * f32x8::splat(ey)
        };
        value(0).simd_ge(f32x8::splat(self.threshold[0]))
            & value(1).simd_ge(f32x8::splat(self.threshold[1]))
            & value(2).simd_ge(f32x8::splat(self.threshold[2]))
    }

    #[inline]
    fn key(&self, px: f32x8, py: f32, x0: f32, y0: f32) -> f32x8 {
        let along_x = (px - f32x8::splat(x0)) * f32x8::splat(self.key_dx);
        (along_x + f32x8::splat(self.key_at_start + (py - y0) * self.key_dy))
            // The plane of a triangle seen edge-on is steep: rounding would take keys beyond those of its corners, in
            // front of others.
            .fast_max(f32x8::splat(self.key_low))
            .fast_min(f32x8::splat(self.key_high))
    }
}

const LANES: [f32; 8] = [0.5, 1.5, 2.5, 3.5, 4.5, 5.5, 6.5, 7.5];

impl Band {
    /// An empty band.
    pub fn new(first_row: usize, rows: usize, width_px: usize) -> Self {
        let stride = width_px + 8;
        Self {
            first_row,
            rows,
            width_px,
            stride,
            keys: vec![f32::NEG_INFINITY; stride * rows],
            sources: vec![f32::from_bits(NOTHING); stride * rows],
        }
    }

    /// Source index and depth key in front at column `x` of the band's row `row`.
    #[inline]
    pub fn at(&self, x: usize, row: usize) -> (u32, f32) {
        let k = row * self.stride + x;
        (self.sources[k].to_bits(), self.keys[k])
    }

    /// Source indices of [`Self::at`] at `count` columns from `x` on, as bits of floats.
    #[inline]
    pub fn sources(&self, x: usize, row: usize, count: usize) -> &[f32] {
        &self.sources[row * self.stride + x..][..count]
    }

    /// Depth keys of the band's row `row`.
    pub fn key_row(&self, row: usize) -> &[f32] {
        &self.keys[row * self.stride..row * self.stride + self.width_px]
    }

    /// Draws the triangle where it is nearer than the band's content. `screen` masks texels: bit (x & 3) + 4 (y & 3)
    /// set = drawn (`0xffff` = all of them).
    #[inline]
    pub fn draw(&mut self, t: &ScreenTriangle, screen: u16) {
        let Some((x0, x1)) = covered(t.x, self.width_px) else { return };
        let Some((y0, y1)) = covered(t.y, self.first_row + self.rows) else { return };
        let Some(edges) = Edges::new(t) else { return };
        let source = f32x8::splat(f32::from_bits(t.source));
        for y in y0.max(self.first_row)..=y1 {
            let py = y as f32 + 0.5;
            let row = (y - self.first_row) * self.stride;
            let (mut x, mut last, mut sure) = (x0, x1, (f32::MAX, f32::MIN));
            if x1 - x0 > WIDE_PX {
                let span = edges.span(py);
                x = x.max(span.touched.0 as usize);
                last = last.min(span.touched.1 as usize);
                sure = span.inside;
            }
            while x <= last {
                let px = f32x8::splat(x as f32) + f32x8::from(LANES);
                let mut inside = if x as f32 >= sure.0 && (x + 8) as f32 <= sure.1 {
                    f32x8::splat(f32::from_bits(u32::MAX))
                } else {
                    edges.test(px, py)
                };
                if screen != 0xffff {
                    let bits = screen >> (4 * (y & 3));
                    let lanes = std::array::from_fn(|lane| {
                        if bits >> ((x + lane) & 3) & 1 == 1 { f32::from_bits(u32::MAX) } else { 0.0 }
                    });
                    inside &= f32x8::from(lanes);
                }
                if inside.to_bitmask() != 0 {
                    let key = edges.key(px, py, t.x[0], t.y[0]);
                    let keys = lanes_mut(&mut self.keys, row + x);
                    let old = f32x8::from(*keys);
                    let nearer = inside & key.simd_gt(old);
                    if nearer.to_bitmask() != 0 {
                        *keys = nearer.bitselect(key, old).to_array();
                        let sources = lanes_mut(&mut self.sources, row + x);
                        *sources = nearer.bitselect(source, f32x8::from(*sources)).to_array();
                    }
                }
                x += 8;
            }
        }
    }

    /// Calls `visit(x, row, key)` for each pixel of the triangle that is nearer than the band's content.
    pub fn each_pixel_in_front(&self, t: &ScreenTriangle, mut visit: impl FnMut(usize, usize, f32)) {
        let Some((x0, x1)) = covered(t.x, self.width_px) else { return };
        let Some((y0, y1)) = covered(t.y, self.first_row + self.rows) else { return };
        let Some(edges) = Edges::new(t) else { return };
        for y in y0.max(self.first_row)..=y1 {
            let py = y as f32 + 0.5;
            let row = y - self.first_row;
            let mut x = x0;
            while x <= x1 {
                let px = f32x8::splat(x as f32) + f32x8::from(LANES);
                let key = edges.key(px, py, t.x[0], t.y[0]);
                let old = lanes_of(&self.keys, row * self.stride + x);
                let mut bits = (edges.test(px, py) & key.simd_gt(old)).to_bitmask();
                while bits != 0 {
                    let lane = bits.trailing_zeros() as usize;
                    bits &= bits - 1;
                    if x + lane < self.width_px {
                        visit(x + lane, row, key.to_array()[lane]);
                    }
                }
                x += 8;
            }
        }
    }
}

const SPARE: &str = "rows have eight places to spare";

/// Eight numbers from a place on. An array and no slice: copies of slices of eight are calls.
#[inline]
fn lanes_of(numbers: &[f32], at: usize) -> f32x8 {
    f32x8::from(*numbers[at..].first_chunk().expect(SPARE))
}

#[inline]
fn lanes_mut(numbers: &mut [f32], at: usize) -> &mut [f32; 8] {
    numbers[at..].first_chunk_mut().expect(SPARE)
}
