//! Pictures from outside: PNG, JPEG or WebP by their first bytes, whatever the sender calls them.
//!
//! Dimensions are read from the header and checked before anything is decoded; then the whole picture is
//! decoded once under memory limits, so that a broken file is refused here and not in a job.

use std::io::Cursor;

use bytes::Bytes;
use image::{ImageFormat, ImageReader, Limits};

use super::Settings;
use super::error::{Problem, ProblemType};
use store::Digest;

/// Smallest side of a picture somebody could see a table in, pixels.
const MIN_SIDE_PX: u32 = 32;

/// Largest side that is decoded, pixels.
const MAX_SIDE_PX: u32 = 16_384;

/// A picture that was checked, but not stored.
#[derive(Clone, Debug)]
pub struct Picture {
    pub bytes: Bytes,
    pub digest: Digest,
    pub media_type: &'static str,
}

/// Checks a picture (decoding it, so it blocks); refuses with what to change.
pub fn check(bytes: Bytes, settings: &Settings) -> Result<Picture, Problem> {
    let limit = settings.max_image_bytes;
    if bytes.len() > limit {
        return Err(Problem::new(
            ProblemType::PayloadTooLarge,
            "image_too_large",
            format!("the picture has {} bytes; send one of at most {limit}", bytes.len()),
        ));
    }
    look(bytes, settings.max_image_pixels)
}

fn look(bytes: Bytes, max_pixels: u64) -> Result<Picture, Problem> {
    let (format, media_type) = sniff(&bytes).ok_or_else(|| {
        Problem::new(
            ProblemType::UnsupportedMediaType,
            "image_format",
            "the picture is no PNG, JPEG or WebP (its first bytes decide); convert it to one of them",
        )
    })?;
    if is_moving_webp(&bytes) {
        return Err(invalid("image_moves", "the picture moves; send a single one".to_owned()));
    }
    let reader = || ImageReader::with_format(Cursor::new(&bytes[..]), format);
    let (width, height) = reader().into_dimensions().map_err(|error| unreadable(&error.to_string()))?;
    if u64::from(width) * u64::from(height) > max_pixels {
        return Err(invalid(
            "image_dimensions",
            format!("the picture is {width} x {height}; send one of at most {max_pixels} pixels"),
        ));
    }
    if width.max(height) > MAX_SIDE_PX {
        return Err(invalid(
            "image_dimensions",
            format!("the picture is {width} x {height}; each side may have at most {MAX_SIDE_PX} pixels"),
        ));
    }
    if width.min(height) < MIN_SIDE_PX {
        return Err(invalid(
            "image_dimensions",
            format!("the picture is {width} x {height}; each side must have at least {MIN_SIDE_PX} pixels"),
        ));
    }
    let mut decoder = reader();
    let mut limits = Limits::default();
    limits.max_alloc = Some(max_pixels.saturating_mul(12));
    decoder.limits(limits);
    decoder.decode().map_err(|error| unreadable(&error.to_string()))?;
    Ok(Picture { digest: Digest::of(&bytes), bytes, media_type })
}

/// The format the first bytes announce.
fn sniff(bytes: &[u8]) -> Option<(ImageFormat, &'static str)> {
    if bytes.starts_with(b"\x89PNG\r\n\x1a\n") {
        Some((ImageFormat::Png, "image/png"))
    } else if bytes.starts_with(b"\xff\xd8\xff") {
        Some((ImageFormat::Jpeg, "image/jpeg"))
    } else if bytes.starts_with(b"RIFF") && bytes.get(8..12) == Some(b"WEBP") {
        Some((ImageFormat::WebP, "image/webp"))
    } else {
        None
    }
}

/// Whether it is a WebP file that says it is animated (RFC 9649, 2.7): decoders of those are tried on few files.
fn is_moving_webp(bytes: &[u8]) -> bool {
    bytes.get(8..16) == Some(b"WEBPVP8X") && bytes.get(20).is_some_and(|flags| flags & 0b10 != 0)
}

/// A picture whose bytes cannot be decoded.
pub(super) fn unreadable(reason: &str) -> Problem {
    let reason: String = reason.chars().take(200).collect();
    invalid("image_unreadable", format!("the picture is damaged ({reason}); save it again and send that"))
}

fn invalid(code: &'static str, detail: String) -> Problem {
    Problem::new(ProblemType::InvalidRequest, code, detail)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn png(width: u32, height: u32) -> Vec<u8> {
        let mut bytes = Cursor::new(Vec::new());
        image::RgbImage::new(width, height).write_to(&mut bytes, ImageFormat::Png).expect("encodes");
        bytes.into_inner()
    }

    fn code(bytes: Vec<u8>, max_pixels: u64) -> &'static str {
        look(bytes.into(), max_pixels).map_or_else(|problem| problem.code, |_| "fine")
    }

    #[test]
    fn good_pictures_pass_and_bad_ones_are_named() {
        let good = png(64, 48);
        assert_eq!(code(good.clone(), 10_000), "fine");
        assert_eq!(code(good.clone(), 3_000), "image_dimensions");
        assert_eq!(code(png(8, 200), 10_000), "image_dimensions");
        assert_eq!(code(png(16_500, 32), 10_000_000), "image_dimensions");
        assert_eq!(code(good[..good.len() / 2].to_vec(), 10_000), "image_unreadable");
        assert_eq!(code(b"GIF89a................".to_vec(), 10_000), "image_format");
        assert_eq!(code(b"<svg onload=alert(1)>".to_vec(), 10_000), "image_format");
        assert_eq!(code(b"\xff\xd8\xff\xe0 no jpeg at all".to_vec(), 10_000), "image_unreadable");
        assert_eq!(code(Vec::new(), 10_000), "image_format");
        let moving = b"RIFF\x5a\0\0\0WEBPVP8X\x0a\0\0\0\x12\0\0\0\x3f\0\0\x3f\0\0";
        assert_eq!(code(moving.to_vec(), 10_000), "image_moves");

        // A header that claims 60,000 x 60,000 pixels is refused before anything of it is decoded.
        let mut bomb = good;
        bomb[16..24].copy_from_slice(&[0, 0, 0xEA, 0x60, 0, 0, 0xEA, 0x60]);
        assert_ne!(code(bomb, 64_000_000), "fine");
    }
}
