//! Share of each pixel that a silhouette covers, and blocks of pixels with equal shares.

use std::ops::Range;

/// Pixels of a block: eight beside each other, that is sixteen bits.
pub const BLOCK_PX: usize = 8;
/// One bit for each block of a row, from the left: images up to 1024 pixels wide.
pub type BlockRow = u128;

/// Pixels before the first and after the last, so that eight beside any pixel can be read at once.
const MARGIN_PX: usize = 8;
const BLOCKS_PER_WORD: usize = 4;
/// Bits of a pixel in one row of bits, four pixels, to a quarter each.
const QUARTERS: [[f32; 4]; 256] = quarters();

/// Coverage of a square image. Content equal to the previous image's is not written again.
#[derive(Default)]
pub struct Coverage {
    side_px: usize,
    /// 0..1, row-major, between margins.
    pixels: Vec<f32>,
    /// Blocks of each row of which nothing is covered, and all.
    empty: Vec<BlockRow>,
    full: Vec<BlockRow>,
    /// Rows of which anything is covered.
    rows: Range<usize>,
}

impl Coverage {
    /// Covers what is set in an image of `2 side_px` rows of bits, `words` 64-bit words each, twice as fine
    /// as the pixels in both directions.
    pub fn cover(&mut self, side_px: usize, bits: &[u64], words: usize) {
        if self.side_px != side_px {
            *self = Self {
                side_px,
                pixels: vec![0.0; side_px * side_px + 2 * MARGIN_PX],
                empty: vec![BlockRow::MAX; side_px],
                full: vec![0; side_px],
                rows: 0..0,
            };
        }
        self.rows = side_px..0;
        for (y, pair) in bits.chunks_exact(2 * words).enumerate() {
            let (upper, lower) = pair.split_at(words);
            let (mut empty, mut full) = (BlockRow::MAX, 0);
            for (word, (&a, &b)) in upper.iter().zip(lower).enumerate() {
                if a | b == 0 {
                    continue;
                }
                if a & b == u64::MAX {
                    let blocks = ((1 << BLOCKS_PER_WORD) - 1) << (BLOCKS_PER_WORD * word);
                    (empty, full) = (empty & !blocks, full | blocks);
                    continue;
                }
                for k in 0..BLOCKS_PER_WORD {
                    let bit = 1 << (BLOCKS_PER_WORD * word + k);
                    let (a, b) = ((a >> (16 * k)) as u16, (b >> (16 * k)) as u16);
                    if a | b != 0 {
                        empty &= !bit;
                    }
                    if a & b == u16::MAX {
                        full |= bit;
                    } else if a | b != 0 {
                        let at = MARGIN_PX + y * side_px + (BLOCKS_PER_WORD * word + k) * BLOCK_PX;
                        mix(a, b, &mut self.pixels[at..at + BLOCK_PX]);
                    }
                }
            }
            let row = &mut self.pixels[MARGIN_PX + y * side_px..];
            let mut fill = |which: BlockRow, value| {
                each(which, |block| row[block * BLOCK_PX..(block + 1) * BLOCK_PX].fill(value));
            };
            fill(empty & !self.empty[y] & first_blocks(side_px), 0.0);
            fill(full & !self.full[y], 1.0);
            (self.empty[y], self.full[y]) = (empty, full);
            if empty != BlockRow::MAX {
                self.rows = self.rows.start.min(y)..y + 1;
            }
        }
    }

    /// Rows of which anything is covered.
    pub fn rows(&self) -> Range<usize> {
        self.rows.clone()
    }

    /// Blocks of the row of which anything is covered.
    pub fn covered(&self, y: usize) -> BlockRow {
        !self.empty[y]
    }

    /// Blocks of the row where the coverage of pixels or of their neighbors, in the rows beside it too,
    /// differs.
    pub fn outline(&self, y: usize) -> BlockRow {
        let last = first_blocks(self.side_px) & !(first_blocks(self.side_px) >> 1);
        let even = |blocks: &[BlockRow]| {
            let alike = blocks[y.saturating_sub(1)] & blocks[y] & blocks[(y + 1).min(self.side_px - 1)];
            alike & (alike << 1 | 1) & (alike >> 1 | last)
        };
        first_blocks(self.side_px) & !even(&self.empty) & !even(&self.full)
    }

    /// Coverage from a pixel on, which may be one before the row's first, and at least eight more.
    #[inline]
    pub fn from(&self, y: usize, x_plus_1: usize) -> &[f32] {
        &self.pixels[MARGIN_PX - 1 + y * self.side_px + x_plus_1..]
    }
}

/// Bits of all blocks of a row.
fn first_blocks(side_px: usize) -> BlockRow {
    BlockRow::MAX >> (BlockRow::BITS as usize - side_px / BLOCK_PX)
}

/// Calls `visit` with each block whose bit is set, from the left.
#[inline]
pub fn each(mut blocks: BlockRow, mut visit: impl FnMut(usize)) {
    while blocks != 0 {
        visit(blocks.trailing_zeros() as usize);
        blocks &= blocks - 1;
    }
}

/// Coverage of eight pixels from their two rows of bits.
#[inline]
fn mix(a: u16, b: u16, pixels: &mut [f32]) {
    for (half, pixels) in pixels.chunks_exact_mut(4).enumerate() {
        let (upper, lower) =
            (&QUARTERS[usize::from(a >> (8 * half)) & 255], &QUARTERS[usize::from(b >> (8 * half)) & 255]);
        pixels.iter_mut().zip(upper.iter().zip(lower)).for_each(|(pixel, (a, b))| *pixel = a + b);
    }
}

const fn quarters() -> [[f32; 4]; 256] {
    let mut all = [[0.0; 4]; 256];
    let mut bits = 0;
    while bits < 256 {
        let mut pixel = 0;
        while pixel < 4 {
            all[bits][pixel] = 0.25 * (bits >> (2 * pixel) & 3).count_ones() as f32;
            pixel += 1;
        }
        bits += 1;
    }
    all
}
