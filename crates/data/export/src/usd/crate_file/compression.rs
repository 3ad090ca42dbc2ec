//! Compression of crate files: LZ4 blocks, after delta coding for integers.

use std::collections::BTreeMap;

/// The longest input of one LZ4 block.
const MAX_BLOCK_BYTES: usize = 0x7e00_0000;

/// One LZ4 block. The leading byte 0 marks a single block.
pub fn compressed(bytes: &[u8]) -> Vec<u8> {
    assert!(bytes.len() <= MAX_BLOCK_BYTES, "{} bytes in one table of a crate file", bytes.len());
    let mut packed = vec![0];
    packed.extend(lz4_flex::block::compress(bytes));
    packed
}

/// Delta coding: the most common difference between neighbors in 32 bits; a two-bit code per integer for the width of
/// its difference (none if it is the most common one, or 8, 16 or 32 bits); the differences. All little-endian, then
/// compressed. Empty for no integers.
pub fn compressed_integers(integers: &[i32]) -> Vec<u8> {
    if integers.is_empty() {
        return Vec::new();
    }
    let before = std::iter::once(&0).chain(integers);
    let differences: Vec<i32> =
        integers.iter().zip(before).map(|(now, before)| now.wrapping_sub(*before)).collect();
    let common = mode(&differences);
    let mut bytes = common.to_le_bytes().to_vec();
    let codes_at = bytes.len();
    bytes.resize(codes_at + differences.len().div_ceil(4), 0);
    for (k, difference) in differences.into_iter().enumerate() {
        let code = if difference == common {
            0
        } else if let Ok(small) = i8::try_from(difference) {
            bytes.extend(small.to_le_bytes());
            1
        } else if let Ok(medium) = i16::try_from(difference) {
            bytes.extend(medium.to_le_bytes());
            2
        } else {
            bytes.extend(difference.to_le_bytes());
            3
        };
        bytes[codes_at + k / 4] |= code << (2 * (k % 4));
    }
    compressed(&bytes)
}

/// The mode, that is, the most common value; the largest among equally common values.
fn mode(values: &[i32]) -> i32 {
    let mut counts = BTreeMap::new();
    values.iter().for_each(|value| *counts.entry(*value).or_insert(0_usize) += 1);
    counts.into_iter().max_by_key(|(value, count)| (*count, *value)).map_or(0, |(value, _)| value)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn integers_are_delta_coded() {
        // Example of OpenUSD's source: differences 123 1 1 1 1 1 -127 -100000; the most common is 1.
        let packed = compressed_integers(&[123, 124, 125, 126, 127, 128, 1, -99999]);
        let bytes = lz4_flex::block::decompress(&packed[1..], 64).expect("one block");
        let mut expected = vec![1, 0, 0, 0, 0b00_00_00_01, 0b11_01_00_00, 123, (-127_i8) as u8];
        expected.extend((-100_000_i32).to_le_bytes());
        assert_eq!((packed[0], bytes), (0, expected));
        assert!(compressed_integers(&[]).is_empty());
    }

    #[test]
    fn mode_prefers_the_largest_of_equals() {
        assert_eq!(mode(&[1, 2, 2, 1, -7]), 2);
    }
}
