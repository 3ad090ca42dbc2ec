//! The part of a mask under its crop, sampled between pixel centers.

use imaging::Mask;

/// Sampling points of the crop's pixels along one axis of the image.
pub struct Axis {
    /// Image pixel from which [`SamplePosition::low`] counts.
    first: i64,
    /// Sampling positions, crop pixel by crop pixel.
    footings: Vec<SamplePosition>,
    /// Per crop pixel.
    points: usize,
}

/// A sampling point between two pixel centers.
#[derive(Clone, Copy)]
struct SamplePosition {
    /// The pixel before it.
    low: usize,
    /// 0 at that pixel's center, 1 at the next one's.
    share: f64,
}

/// Content of an image pixel.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Pixel {
    Own,
    Other,
    Hidden,
}

/// The pixels under a crop. Beyond the image all is hidden.
pub struct Window<'a> {
    columns: &'a Axis,
    rows: &'a Axis,
    width_px: usize,
    pixels: Vec<Pixel>,
}

impl Axis {
    /// `points` in each of `side_px` crop pixels; `scale` crop pixels per image pixel, `center_px` the image
    /// position in the center of the crop.
    pub fn new(side_px: usize, points: usize, scale: f64, center_px: f64) -> Self {
        let half = 0.5 * side_px as f64;
        let from_first_center = |k: usize| {
            let offset = ((k % points) as f64 + 0.5) / points as f64;
            ((k / points) as f64 + offset - half) / scale + center_px - 0.5
        };
        let first = from_first_center(0).floor();
        let footings = (0..side_px * points)
            .map(from_first_center)
            .map(|at| SamplePosition { low: (at.floor() - first) as usize, share: at - at.floor() })
            .collect();
        Self { first: first as i64, footings, points }
    }

    /// Image pixels it reaches over.
    fn length_px(&self) -> usize {
        self.footings.last().map_or(0, |last| last.low + 2)
    }
}

impl<'a> Window<'a> {
    pub fn new(mask: &Mask, unknown: &Mask, columns: &'a Axis, rows: &'a Axis) -> Self {
        let (width_px, height_px) = (columns.length_px(), rows.length_px());
        let mut pixels = vec![Pixel::Hidden; width_px * height_px];
        let inside = |first: i64, length: usize, size: u32| {
            let low = (-first).clamp(0, length as i64);
            low as usize..(i64::from(size) - first).clamp(low, length as i64) as usize
        };
        let across = inside(columns.first, width_px, mask.width_px());
        for v in inside(rows.first, height_px, mask.height_px()) {
            let y = (rows.first + v as i64) as u32;
            for u in across.clone() {
                let x = (columns.first + u as i64) as u32;
                pixels[v * width_px + u] = match (mask.contains(x, y), unknown.contains(x, y)) {
                    (true, _) => Pixel::Own,
                    (false, true) => Pixel::Hidden,
                    (false, false) => Pixel::Other,
                };
            }
        }
        Self { columns, rows, width_px, pixels }
    }

    /// Share of the crop pixel's points that are the mask's, and share of those that are not hidden; crop
    /// pixels from the first row on, bilinear between image pixels.
    pub fn each_crop_pixel(&self, mut visit: impl FnMut(f64, f64)) {
        let mut agreed = Vec::new();
        for row in self.rows.footings.chunks_exact(self.rows.points) {
            self.agree(row, &mut agreed);
            for column in self.columns.footings.chunks_exact(self.columns.points) {
                let under = &agreed[column[0].low..column[column.len() - 1].low + 2];
                // Most crop pixels lie on pixels of equal content.
                match under[0].filter(|_| under.iter().all(|shown| *shown == under[0])) {
                    Some(Pixel::Own) => visit(1.0, 1.0),
                    Some(Pixel::Other) => visit(0.0, 1.0),
                    Some(Pixel::Hidden) => visit(0.0, 0.0),
                    None => {
                        let (own, seen) = self.shares(column, row);
                        visit(own, seen);
                    }
                }
            }
        }
    }

    /// Content of each column of the window in the rows under a crop pixel; `None` where they differ.
    fn agree(&self, row: &[SamplePosition], agreed: &mut Vec<Option<Pixel>>) {
        let line = |v: usize| &self.pixels[v * self.width_px..(v + 1) * self.width_px];
        agreed.clear();
        agreed.extend(line(row[0].low).iter().map(|shown| Some(*shown)));
        for v in row[0].low + 1..row[row.len() - 1].low + 2 {
            for (agreed, shown) in agreed.iter_mut().zip(line(v)) {
                *agreed = agreed.filter(|before| before == shown);
            }
        }
    }

    fn shares(&self, column: &[SamplePosition], row: &[SamplePosition]) -> (f64, f64) {
        let (mut own, mut seen) = (0.0, 0.0);
        for v in row {
            for u in column {
                let (set, hidden) = self.sample(u, v);
                own += set;
                seen += 1.0 - hidden;
            }
        }
        let count = (row.len() * column.len()) as f64;
        (own / count, seen / count)
    }

    /// Mask and hidden at a sampling point.
    fn sample(&self, u: &SamplePosition, v: &SamplePosition) -> (f64, f64) {
        let (mut set, mut hidden) = (0.0, 0.0);
        for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
            let weight = (if dx == 0 { 1.0 - u.share } else { u.share })
                * (if dy == 0 { 1.0 - v.share } else { v.share });
            match self.pixels[(v.low + dy) * self.width_px + u.low + dx] {
                Pixel::Own => set += weight,
                Pixel::Hidden => hidden += weight,
                Pixel::Other => {}
            }
        }
        (set, hidden)
    }
}
