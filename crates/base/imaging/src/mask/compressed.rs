//! COCO's compressed run-length text (`rleToString` of its API).
//!
//! Counts after the third are stored as differences to the count two before them. Each number is split into groups of
//! five bits, lowest first; a group is one character from `0` on, with a sixth bit that says whether more groups
//! follow. The highest bit of the last group is the sign.

use super::{InvalidRunLengths, RunLengths};

/// Largest number of groups of one count; 32-bit counts have at most seven.
const MAX_GROUPS: u32 = 7;

impl RunLengths {
    /// Reads `counts`; `size` is [height, width]. Memory is bounded by the text's length. The sum of the counts is
    /// checked by the conversion to [`Mask`](super::Mask).
    pub fn from_compressed(size: [u32; 2], counts: &str) -> Result<Self, InvalidRunLengths> {
        let mut read: Vec<u32> = Vec::new();
        let mut groups = counts.bytes();
        while groups.len() > 0 {
            let (mut value, mut shift) = (0_i64, 0);
            loop {
                let group = groups.next().and_then(|byte| byte.checked_sub(b'0')).filter(|&group| group < 64);
                let group = i64::from(group.ok_or(InvalidRunLengths)?);
                value |= (group & 0x1f) << shift;
                shift += 5;
                if group & 0x20 == 0 {
                    if group & 0x10 != 0 {
                        value |= -1 << shift;
                    }
                    break;
                }
                if shift >= 5 * MAX_GROUPS {
                    return Err(InvalidRunLengths);
                }
            }
            // The first run may be empty, so differences begin with the fourth count.
            if read.len() > 2 {
                value += i64::from(read[read.len() - 2]);
            }
            read.push(u32::try_from(value).map_err(|_| InvalidRunLengths)?);
        }
        Ok(Self { size, counts: read })
    }

    /// Writes `counts` as [`from_compressed`](Self::from_compressed) reads them.
    pub fn compressed(&self) -> String {
        let mut text = String::new();
        for (index, &count) in self.counts.iter().enumerate() {
            let mut value = i64::from(count);
            if index > 2 {
                value -= i64::from(self.counts[index - 2]);
            }
            loop {
                let group = value & 0x1f;
                value >>= 5;
                let more = if group & 0x10 != 0 { value != -1 } else { value != 0 };
                text.push(char::from(b'0' + group as u8 + if more { 0x20 } else { 0 }));
                if !more {
                    break;
                }
            }
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Mask;

    #[test]
    fn from_compressed_reads_texts_of_pycocotools() {
        // pycocotools.mask.encode of a 4 x 4 image with its center 2 x 2 set, and of an empty one.
        let center = RunLengths::from_compressed([4, 4], "52203").expect("is intact");
        assert_eq!(center.counts, [5, 2, 2, 2, 5]);
        let mask = Mask::try_from(center).expect("fills the picture");
        assert_eq!((mask.bbox_px(), mask.area_px()), (Some([1, 1, 3, 3]), 4));
        let empty = RunLengths::from_compressed([4, 4], "`0").expect("is intact");
        assert_eq!(empty.counts, [16]);
        let text = "bk05X16K4M2N2N2O0O2O000O2O00000001N10001N101N2N2N3L5JQo0";
        let disk = RunLengths::from_compressed([48, 64], text).expect("is intact");
        assert_eq!(disk.compressed(), text);
        let inside = |x: u32, y: u32| (x.abs_diff(30)).pow(2) + (y.abs_diff(20)).pow(2) < 150;
        assert_eq!(Mask::try_from(disk), Ok(Mask::from_fn(64, 48, inside)));
    }

    #[test]
    fn compressed_text_round_trips() {
        for bits in 0..1 << 9 {
            let mask = Mask::from_fn(3, 3, |x, y| bits >> (3 * y + x) & 1 == 1);
            let runs = RunLengths::from(mask);
            assert_eq!(RunLengths::from_compressed(runs.size, &runs.compressed()), Ok(runs));
        }
        let large = RunLengths { size: [60_000, 4_000], counts: vec![239_999_000, 1, 999] };
        assert_eq!(RunLengths::from_compressed(large.size, &large.compressed()), Ok(large));
    }

    #[test]
    fn from_compressed_rejects_hostile_texts() {
        for text in ["oooooooooooo", "o", "\u{7f}", "0 0", "é", "~~~~~~~~", "@", "00@", "?"] {
            let read = RunLengths::from_compressed([4, 4], text).and_then(Mask::try_from);
            assert_eq!(read, Err(InvalidRunLengths), "{text}");
        }
    }
}
