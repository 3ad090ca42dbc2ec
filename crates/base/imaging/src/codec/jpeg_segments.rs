//! Walks the segments of a JPEG file (ITU-T T.81, annex B) up to its end marker.
//!
//! Decoders fill what a file lacks with gray. The walk finds the missing end before they run, and drops profiles,
//! previews and comments, which change no pixel. Cost: one pass over the bytes.

use std::borrow::Cow;

use super::CodecError;
use super::kept_ranges::KeptRanges;

const START_OF_IMAGE: u8 = 0xd8;
const END_OF_IMAGE: u8 = 0xd9;
const START_OF_SCAN: u8 = 0xda;

/// The file from its start to its end marker, without segments that only describe it.
///
/// # Errors
///
/// [`CodecError::Truncated`] for a file without an end marker.
pub(super) fn still_jpeg(file: &[u8]) -> Result<Cow<'_, [u8]>, CodecError> {
    let mut kept = KeptRanges::new(file);
    let mut at = 0;
    loop {
        // Cameras pad segments, so bytes before a marker are skipped.
        let (start, code) = next_marker(file, at).ok_or(CodecError::Truncated)?;
        let end = match code {
            START_OF_IMAGE | 0x01 | 0xd0..=0xd7 => start + 2,
            END_OF_IMAGE => {
                kept.keep(start..start + 2);
                return Ok(kept.into_bytes());
            }
            _ => segment_end(file, start + 2)?,
        };
        if decides_pixels_or_orientation(code, &file[start + 2..end]) {
            kept.keep(start..end);
        }
        at = end;
        if code == START_OF_SCAN {
            at = scan_end(file, end).ok_or(CodecError::Truncated)?;
            kept.keep(end..at);
        }
    }
}

/// The position of the last 0xff before a marker's code, and the code.
fn next_marker(file: &[u8], from: usize) -> Option<(usize, u8)> {
    (from..file.len().saturating_sub(1))
        .find(|at| file[*at] == 0xff && !matches!(file[at + 1], 0 | 0xff))
        .map(|at| (at, file[at + 1]))
}

/// The end of a segment whose length stands at `at`.
fn segment_end(file: &[u8], at: usize) -> Result<usize, CodecError> {
    let length = file.get(at..at + 2).ok_or(CodecError::Truncated)?;
    let end = at + usize::from(u16::from_be_bytes([length[0], length[1]])).max(2);
    if end > file.len() { Err(CodecError::Truncated) } else { Ok(end) }
}

/// The first marker after entropy-coded data that is neither a stuffed byte nor a restart.
fn scan_end(file: &[u8], mut at: usize) -> Option<usize> {
    loop {
        let (start, code) = next_marker(file, at)?;
        if !matches!(code, 0xd0..=0xd7) {
            return Some(start);
        }
        at = start + 2;
    }
}

/// Whether a decoder needs a segment: all but comments and application data, of which JFIF, EXIF and Adobe's color
/// transform count. `segment` begins with its length.
fn decides_pixels_or_orientation(code: u8, segment: &[u8]) -> bool {
    match code {
        0xe1 => segment.get(2..8) == Some(b"Exif\0\0"),
        0xe0 | 0xee => true,
        0xe2..=0xef | 0xfe => false,
        _ => true,
    }
}
