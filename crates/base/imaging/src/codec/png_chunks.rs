//! Walks the chunks of a PNG file (PNG 1.2, chapter 3) and keeps those that decide pixels and orientation.
//!
//! Compressed profiles and texts expand to hundreds of times their size in a decoder and change no pixel, so no decoder
//! sees them. Cost: one pass over the chunk headers.

use std::borrow::Cow;

use super::CodecError;
use super::kept_ranges::KeptRanges;

const SIGNATURE_BYTES: usize = 8;
/// Length, type and checksum around the data of a chunk.
const FRAME_BYTES: usize = 12;
/// Longest EXIF chunk that is read; JPEG files cannot hold a longer one either.
const MAX_EXIF_BYTES: usize = 1 << 16;

/// The file without chunks that only describe it, and without what follows its end.
///
/// # Errors
///
/// [`CodecError::Animated`] for an animation, [`CodecError::Truncated`] for a file without its last chunk.
pub(super) fn still_png(file: &[u8]) -> Result<Cow<'_, [u8]>, CodecError> {
    let mut kept = KeptRanges::new(file);
    kept.keep(0..SIGNATURE_BYTES.min(file.len()));
    let mut at = SIGNATURE_BYTES;
    loop {
        let header = file.get(at..at + 8).ok_or(CodecError::Truncated)?;
        let length = u32::from_be_bytes([header[0], header[1], header[2], header[3]]) as usize;
        let end = at.saturating_add(length).saturating_add(FRAME_BYTES);
        if end > file.len() {
            return Err(CodecError::Truncated);
        }
        let kind = &header[4..];
        // Bit 5 of the first letter marks chunks that a decoder may ignore.
        let is_critical = kind[0] & 0x20 == 0;
        match kind {
            b"acTL" => return Err(CodecError::Animated),
            b"tRNS" => kept.keep(at..end),
            b"eXIf" if length <= MAX_EXIF_BYTES => kept.keep(at..end),
            _ if is_critical => kept.keep(at..end),
            _ => {}
        }
        if kind == b"IEND" {
            return Ok(kept.into_bytes());
        }
        at = end;
    }
}
