//! Walks the chunks of a WebP file (RFC 9649, 2.3) before a decoder reads them.
//!
//! Every caller needs a single image, and decoders of animations are far less tested than those of still images.

use super::CodecError;

const HEADER_BYTES: usize = 12;
const ANIMATION_FLAG: u8 = 0b10;

/// Checks that the file is complete and shows one image.
///
/// # Errors
///
/// [`CodecError::Animated`] for an animation, [`CodecError::Truncated`] for a file shorter than it declares.
pub(super) fn check_still_webp(file: &[u8]) -> Result<(), CodecError> {
    let declared = size_at(file, 4).ok_or(CodecError::Truncated)?.saturating_add(8);
    // The flag and the frames may lie before the end of a shortened file: an animation is reported as such.
    let mut at = HEADER_BYTES;
    while at < declared.min(file.len()) {
        let kind = file.get(at..at + 4).ok_or(CodecError::Truncated)?;
        let length = size_at(file, at + 4).ok_or(CodecError::Truncated)?;
        let flags = file.get(at + 8).copied().unwrap_or(0);
        let is_animated = matches!(kind, b"ANIM" | b"ANMF") || kind == b"VP8X" && flags & ANIMATION_FLAG != 0;
        if is_animated {
            return Err(CodecError::Animated);
        }
        let end = at.saturating_add(8).saturating_add(length);
        if end > file.len() {
            return Err(CodecError::Truncated);
        }
        // Chunks are padded to even sizes; the pad byte of the last one is often missing.
        at = end + length % 2;
    }
    if at < declared { Err(CodecError::Truncated) } else { Ok(()) }
}

fn size_at(file: &[u8], at: usize) -> Option<usize> {
    let bytes = file.get(at..at + 4)?;
    Some(u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]) as usize)
}
