//! Sequential reader of a crate file's bytes, and decompression.

use super::{LayerError, LayerResult};

/// The bytes not yet read.
pub struct Bytes<'a>(&'a [u8]);

impl<'a> Bytes<'a> {
    pub fn at(bytes: &'a [u8], offset: usize) -> LayerResult<Self> {
        bytes.get(offset..).map(Self).ok_or(LayerError::EndsBefore(offset))
    }

    pub fn take(&mut self, count: usize) -> LayerResult<&'a [u8]> {
        let (taken, rest) = self.0.split_at_checked(count).ok_or(LayerError::EndsEarly)?;
        self.0 = rest;
        Ok(taken)
    }

    pub fn array<const N: usize>(&mut self) -> LayerResult<[u8; N]> {
        Ok(self.take(N)?.try_into().expect("as many as were taken"))
    }

    /// A 64-bit count or file offset.
    pub fn length(&mut self) -> LayerResult<usize> {
        let length = u64::from_le_bytes(self.array()?);
        usize::try_from(length).map_err(|_| LayerError::Length(length))
    }
}

/// Decompresses a block that is preceded by its compressed size, to at most `size` bytes.
pub fn unpacked(bytes: &mut Bytes<'_>, size: usize) -> LayerResult<Vec<u8>> {
    let length = bytes.length()?;
    let (chunks, block) = bytes.take(length)?.split_first().ok_or(LayerError::EmptyBlock)?;
    if *chunks != 0 {
        return Err(LayerError::BlockCount(*chunks));
    }
    Ok(lz4_flex::block::decompress(block, size)?)
}

/// Decompresses delta-coded integers: the most common difference, a two-bit width code per integer, the differences.
pub fn integers(bytes: &mut Bytes<'_>, count: usize) -> LayerResult<Vec<i32>> {
    if count == 0 {
        bytes.length()?;
        return Ok(Vec::new());
    }
    let longest =
        count.checked_mul(5).and_then(|bytes| bytes.checked_add(5)).ok_or(LayerError::TooMany("integers"))?;
    let plain = unpacked(bytes, longest)?;
    let mut head = Bytes::at(&plain, 0)?;
    let common = i32::from_le_bytes(head.array()?);
    let codes = head.take(count.div_ceil(4))?;
    let mut value = 0_i32;
    let next = |k: usize| {
        let difference = match codes[k / 4] >> (2 * (k % 4)) & 3 {
            0 => common,
            1 => i8::from_le_bytes(head.array()?).into(),
            2 => i16::from_le_bytes(head.array()?).into(),
            _ => i32::from_le_bytes(head.array()?),
        };
        value = value.wrapping_add(difference);
        Ok(value)
    };
    (0..count).map(next).collect()
}
