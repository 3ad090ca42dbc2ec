//! A binary mask, stored as COCO run lengths in files.

mod coco;
mod compressed;

use std::sync::Arc;

use serde::{Deserialize, Serialize};

pub use coco::compressed;

/// One bit per pixel, rows from the top. Clones share their pixels until one of them is changed.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "RunLengths", into = "RunLengths")]
pub struct Mask {
    width_px: u32,
    height_px: u32,
    bits: Arc<Vec<bool>>,
}

/// Uncompressed COCO run-length encoding: columns from the left, each from the top, runs alternating
/// from background; `size` is [height, width].
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct RunLengths {
    pub size: [u32; 2],
    pub counts: Vec<u32>,
}

/// The sum of the run lengths is not the number of pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("run lengths do not add up to height x width (at most 2^28 pixels)")]
pub struct InvalidRunLengths;

impl Mask {
    /// No pixel set.
    pub fn empty(width_px: u32, height_px: u32) -> Self {
        Self::from_bits(width_px, height_px, vec![false; width_px as usize * height_px as usize])
    }

    /// From row-major bits, one per pixel.
    ///
    /// # Panics
    ///
    /// Panics unless there are width x height bits.
    pub fn from_bits(width_px: u32, height_px: u32, bits: Vec<bool>) -> Self {
        assert_eq!(bits.len(), width_px as usize * height_px as usize, "a mask has one bit a pixel");
        Self { width_px, height_px, bits: Arc::new(bits) }
    }

    /// The pixels for which `inside(x, y)` holds.
    pub fn from_fn(width_px: u32, height_px: u32, inside: impl Fn(u32, u32) -> bool) -> Self {
        let mut bits = Vec::with_capacity(width_px as usize * height_px as usize);
        (0..height_px).for_each(|y| bits.extend((0..width_px).map(|x| inside(x, y))));
        Self::from_bits(width_px, height_px, bits)
    }

    pub fn width_px(&self) -> u32 {
        self.width_px
    }

    pub fn height_px(&self) -> u32 {
        self.height_px
    }

    /// Row-major bits.
    pub fn bits(&self) -> &[bool] {
        &self.bits
    }

    /// Whether the pixel is set; `false` outside the image.
    pub fn contains(&self, x: u32, y: u32) -> bool {
        x < self.width_px && y < self.height_px && self.bits[(y * self.width_px + x) as usize]
    }

    /// Sets or clears a pixel inside the image.
    pub fn set(&mut self, x: u32, y: u32, inside: bool) {
        Arc::make_mut(&mut self.bits)[(y * self.width_px + x) as usize] = inside;
    }

    /// Union in place with a mask of the same size.
    pub fn unite(&mut self, other: &Mask) {
        Arc::make_mut(&mut self.bits).iter_mut().zip(&*other.bits).for_each(|(bit, &more)| *bit |= more);
    }

    /// Difference: the pixels set here and not in a mask of the same size.
    pub fn without(&self, other: &Mask) -> Self {
        let bits = self.bits.iter().zip(&*other.bits).map(|(&bit, &other)| bit && !other).collect();
        Self::from_bits(self.width_px, self.height_px, bits)
    }

    /// Number of set pixels.
    pub fn area_px(&self) -> usize {
        self.bits.iter().filter(|&&bit| bit).count()
    }

    /// Bounding box of the set pixels, `[x0, y0, x1, y1]`, x1 and y1 exclusive; `None` for an empty mask.
    pub fn bbox_px(&self) -> Option<[u32; 4]> {
        let width = self.width_px.max(1) as usize;
        let rows = || self.bits.chunks_exact(width).enumerate().filter(|(_, row)| any(row));
        let (y0, first) = rows().next()?;
        let (y1, _) = rows().next_back()?;
        let mut x0 = first.iter().position(|&b| b)?;
        let mut x1 = first.iter().rposition(|&b| b)? + 1;
        for row in self.bits[y0 * width..(y1 + 1) * width].chunks_exact(width) {
            // Only rows that extend the box are searched for their ends.
            if any(&row[..x0]) {
                x0 = row.iter().position(|&b| b).unwrap_or(x0);
            }
            if any(&row[x1..]) {
                x1 = row.iter().rposition(|&b| b).map_or(x1, |last| last + 1);
            }
        }
        Some([x0, y0, x1, y1 + 1].map(|edge| edge as u32))
    }

    /// Intersection over union with a mask of the same size; 0 where both are empty.
    pub fn iou(&self, other: &Mask) -> f64 {
        let (mut both, mut either) = (0_usize, 0_usize);
        for (&a, &b) in self.bits.iter().zip(&*other.bits) {
            both += usize::from(a && b);
            either += usize::from(a || b);
        }
        if either == 0 { 0.0 } else { both as f64 / either as f64 }
    }
}

/// Whether any bit is set, with one branch per 64 bits.
fn any(bits: &[bool]) -> bool {
    bits.chunks(64).any(|bits| bits.iter().fold(false, |any, &bit| any | bit))
}

impl From<Mask> for RunLengths {
    fn from(mask: Mask) -> Self {
        let (width, height) = (mask.width_px as usize, mask.height_px);
        // Column-major indices of pixels that differ from their predecessor. Rows are compared in memory order, because
        // most neighboring rows are equal.
        let mut changes: Vec<u32> = Vec::new();
        let mut last = false;
        for x in 0..width.min(mask.bits.len()) {
            if mask.bits[x] != last {
                changes.push(x as u32 * height);
            }
            last = mask.bits[mask.bits.len() - width + x];
        }
        for (y, (above, row)) in
            mask.bits.chunks_exact(width.max(1)).zip(mask.bits.chunks_exact(width.max(1)).skip(1)).enumerate()
        {
            for (block, (a, b)) in
                above.chunks(32).zip(row.chunks(32)).enumerate().filter(|(_, (a, b))| a != b)
            {
                let differing = a.iter().zip(b).enumerate().filter(|(_, (a, b))| a != b);
                changes.extend(differing.map(|(k, _)| (32 * block + k) as u32 * height + y as u32 + 1));
            }
        }
        changes.sort_unstable();
        changes.push(mask.width_px * height);
        let starts = std::iter::once(0).chain(changes.iter().copied());
        let counts = changes.iter().zip(starts).map(|(end, start)| end - start).collect();
        Self { size: [height, mask.width_px], counts }
    }
}

impl TryFrom<RunLengths> for Mask {
    type Error = InvalidRunLengths;
    fn try_from(runs: RunLengths) -> Result<Self, InvalidRunLengths> {
        let [height_px, width_px] = runs.size;
        let pixels = u64::from(height_px) * u64::from(width_px);
        if pixels > 1 << 28 || runs.counts.iter().map(|&c| u64::from(c)).sum::<u64>() != pixels {
            return Err(InvalidRunLengths);
        }
        let mut bits = vec![false; pixels as usize];
        if pixels == 0 {
            return Ok(Mask::from_bits(width_px, height_px, bits));
        }
        // First, bits mark pixels that differ from the one above; the top row holds final values. Then a running XOR
        // down the rows restores the mask.
        let (width, height) = (width_px as usize, height_px as usize);
        let (mut at, mut inside, mut next_column) = (0, false, 0);
        for count in runs.counts {
            let end = at + count as usize;
            while next_column * height < end {
                bits[next_column] = inside;
                next_column += 1;
            }
            if end < width * height && !end.is_multiple_of(height) {
                bits[end % height * width + end / height] ^= true;
            }
            (at, inside) = (end, !inside);
        }
        for y in 1..height {
            let (above, row) = bits[(y - 1) * width..(y + 1) * width].split_at_mut(width);
            row.iter_mut().zip(above).for_each(|(bit, above)| *bit ^= *above);
        }
        Ok(Mask::from_bits(width_px, height_px, bits))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn run_lengths_round_trip_and_reject_wrong_sums() {
        let mask = Mask::from_fn(7, 5, |x, y| (x + 2 * y) % 3 == 0 && x > 0);
        let runs = RunLengths::from(mask.clone());
        assert_eq!(Mask::try_from(runs), Ok(mask.clone()));
        assert_eq!(mask.bbox_px(), Some([1, 0, 7, 5]));
        assert!((mask.iou(&mask) - 1.0).abs() < 1e-12);
        let empty = Mask::empty(4, 3);
        assert_eq!(RunLengths::from(empty.clone()), RunLengths { size: [3, 4], counts: vec![12] });
        for bits in 0..1 << 6 {
            let mask = Mask::from_fn(3, 2, |x, y| bits >> (3 * y + x) & 1 == 1);
            let runs = RunLengths::from(mask.clone());
            assert!(runs.counts[1..].iter().all(|&count| count > 0), "{bits:b}: {runs:?}");
            assert_eq!(Mask::try_from(runs), Ok(mask.clone()));
            let set =
                || (0..2).flat_map(|y| (0..3).map(move |x| (x, y))).filter(|&(x, y)| mask.contains(x, y));
            let of = |x: u32, y: u32| [x, y, x + 1, y + 1];
            let bbox = set()
                .map(|(x, y)| of(x, y))
                .reduce(|a, b| [a[0].min(b[0]), a[1].min(b[1]), a[2].max(b[2]), a[3].max(b[3])]);
            assert_eq!(mask.bbox_px(), bbox);
        }
        // Empty runs, as other writers produce them.
        let split = RunLengths { size: [2, 2], counts: vec![0, 1, 0, 1, 1, 0, 1, 0] };
        assert_eq!(Mask::try_from(split), Ok(Mask::from_fn(2, 2, |x, _| x == 0)));
        let short = RunLengths { size: [2, 2], counts: vec![3] };
        assert_eq!(Mask::try_from(short), Err(InvalidRunLengths));
    }
}
