//! Image files: a PNG encoder, and one bounded decoder of PNG, JPEG and WebP.
//!
//! The encoder is lossless; opaque images are stored without an alpha channel. It runs single-threaded with fixed
//! filters and the fast deflate level, so equal images give equal bytes. The decoder checks format, animation and
//! size by the header before it allocates pixels.

mod animated_webp;

use std::io::Cursor;

use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::metadata::Orientation;
use image::{DynamicImage, ExtendedColorType, ImageDecoder, ImageEncoder, ImageFormat, ImageReader, Limits};

use self::animated_webp::is_animated_webp;
use crate::Image;

/// Largest side of an image that is decoded, pixels.
pub const MAX_SIDE_PX: u32 = 16_384;

const ACCEPTED_FORMATS: &[ImageFormat] = &[ImageFormat::Png, ImageFormat::Jpeg, ImageFormat::WebP];

/// Bounds of the decoder, checked before pixels are allocated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DecodeLimits {
    /// Largest width and height, pixels.
    pub max_side_px: u32,
    /// Largest product of width and height, pixels.
    pub max_pixels: u64,
    /// Memory that the decoder may allocate, bytes.
    pub max_decoded_bytes: u64,
}

impl DecodeLimits {
    /// At most `max_pixels` pixels, [`MAX_SIDE_PX`] a side and 512 MiB.
    pub fn with_max_pixels(max_pixels: u64) -> Self {
        Self { max_side_px: MAX_SIDE_PX, max_pixels, max_decoded_bytes: 512 << 20 }
    }
}

/// What the header of an image file declares.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ImageHeader {
    pub media_type: &'static str,
    pub width_px: u32,
    pub height_px: u32,
}

/// Why bytes were not decoded as an image.
#[derive(Debug, thiserror::Error)]
pub enum CodecError {
    #[error("these bytes are no image of an accepted format (PNG, JPEG, WebP)")]
    UnknownFormat,
    #[error(
        "the image is {width_px} x {height_px} pixels; decoding stops at {max_side_px} a side or \
         {max_pixels} in all"
    )]
    TooLarge { width_px: u32, height_px: u32, max_side_px: u32, max_pixels: u64 },
    #[error("the image is animated; send a still image")]
    Animated,
    #[error("the image could not be decoded; send an intact file")]
    Broken(#[source] image::ImageError),
}

/// The image as a PNG file. An image without pixels, which PNG cannot express, becomes one transparent pixel.
pub fn encode_png(image: &Image) -> Vec<u8> {
    let (width_px, height_px) = (image.width_px(), image.height_px());
    if width_px == 0 || height_px == 0 {
        return encode_png(&Image::filled(1, 1, [0; 4]));
    }
    let mut bytes = Vec::new();
    let encoder = PngEncoder::new_with_quality(&mut bytes, CompressionType::Fast, FilterType::Adaptive);
    let rgba = image.as_rgba();
    let written = if rgba.chunks_exact(4).all(|pixel| pixel[3] == 255) {
        let mut rgb = vec![0; rgba.len() / 4 * 3];
        rgb.chunks_exact_mut(3)
            .zip(rgba.chunks_exact(4))
            .for_each(|(to, from)| to.copy_from_slice(&from[..3]));
        encoder.write_image(&rgb, width_px, height_px, ExtendedColorType::Rgb8)
    } else {
        encoder.write_image(rgba, width_px, height_px, ExtendedColorType::Rgba8)
    };
    written.expect("the buffer matches the size and memory accepts every write");
    bytes
}

/// Decodes a PNG file; other formats are refused.
///
/// # Errors
///
/// [`CodecError`] for another format, an image larger than [`MAX_SIDE_PX`] a side, or damaged bytes.
pub fn decode_png(bytes: &[u8]) -> Result<Image, CodecError> {
    let (decoded, _) = decode(bytes, &[ImageFormat::Png], &DecodeLimits::with_max_pixels(u64::MAX))?;
    rgba_image(decoded)
}

/// Decodes a PNG, JPEG or WebP file of at most `max_pixels` pixels. The EXIF orientation is ignored, as glTF requires
/// for textures.
///
/// # Errors
///
/// [`CodecError`] for another format, an animation, an image beyond the limits, or damaged bytes.
pub fn decode_image(bytes: &[u8], max_pixels: u64) -> Result<Image, CodecError> {
    decode_image_within(bytes, &DecodeLimits::with_max_pixels(max_pixels))
}

/// As [`decode_image`], with limits of the caller.
///
/// # Errors
///
/// As [`decode_image`].
pub fn decode_image_within(bytes: &[u8], limits: &DecodeLimits) -> Result<Image, CodecError> {
    let (decoded, _) = decode(bytes, ACCEPTED_FORMATS, limits)?;
    rgba_image(decoded)
}

/// As [`decode_image`], rotated and mirrored as the EXIF orientation says.
///
/// # Errors
///
/// As [`decode_image`].
pub fn decode_oriented_image(bytes: &[u8], max_pixels: u64) -> Result<Image, CodecError> {
    let limits = DecodeLimits::with_max_pixels(max_pixels);
    let (mut decoded, orientation) = decode(bytes, ACCEPTED_FORMATS, &limits)?;
    decoded.apply_orientation(orientation);
    rgba_image(decoded)
}

/// Reads the header of a PNG, JPEG or WebP file; no pixel is decoded.
///
/// # Errors
///
/// [`CodecError`] for another format, an animation, or a damaged header.
pub fn read_header(bytes: &[u8]) -> Result<ImageHeader, CodecError> {
    let format = still_image_format(bytes, ACCEPTED_FORMATS)?;
    let reader = ImageReader::with_format(Cursor::new(bytes), format);
    let (width_px, height_px) = reader.into_dimensions().map_err(CodecError::Broken)?;
    Ok(ImageHeader { media_type: format.to_mime_type(), width_px, height_px })
}

/// Decodes every pixel of a PNG, JPEG or WebP file and discards them. Pixels and decoder together may take
/// `max_decoded_bytes` of memory.
///
/// # Errors
///
/// [`CodecError`] for another format, an animation, an image that needs more memory, or damaged bytes.
pub fn verify_image(bytes: &[u8], max_decoded_bytes: u64) -> Result<(), CodecError> {
    let format = still_image_format(bytes, ACCEPTED_FORMATS)?;
    bounded_reader(bytes, format, max_decoded_bytes).decode().map(drop).map_err(CodecError::Broken)
}

/// The format by the first bytes, if it is an accepted one and the image is not animated.
fn still_image_format(bytes: &[u8], accepted: &[ImageFormat]) -> Result<ImageFormat, CodecError> {
    let format = image::guess_format(bytes).map_err(|_| CodecError::UnknownFormat)?;
    if !accepted.contains(&format) {
        return Err(CodecError::UnknownFormat);
    }
    if is_animated_webp(bytes) {
        return Err(CodecError::Animated);
    }
    Ok(format)
}

fn bounded_reader(bytes: &[u8], format: ImageFormat, max_decoded_bytes: u64) -> ImageReader<Cursor<&[u8]>> {
    let mut limits = Limits::default();
    limits.max_alloc = Some(max_decoded_bytes);
    let mut reader = ImageReader::with_format(Cursor::new(bytes), format);
    reader.limits(limits);
    reader
}

/// The stored pixels and the EXIF orientation.
fn decode(
    bytes: &[u8],
    accepted: &[ImageFormat],
    limits: &DecodeLimits,
) -> Result<(DynamicImage, Orientation), CodecError> {
    let format = still_image_format(bytes, accepted)?;
    let reader = bounded_reader(bytes, format, limits.max_decoded_bytes);
    let mut decoder = reader.into_decoder().map_err(CodecError::Broken)?;
    let (width_px, height_px) = decoder.dimensions();
    let DecodeLimits { max_side_px, max_pixels, .. } = *limits;
    if width_px > max_side_px
        || height_px > max_side_px
        || u64::from(width_px) * u64::from(height_px) > max_pixels
    {
        return Err(CodecError::TooLarge { width_px, height_px, max_side_px, max_pixels });
    }
    // Damaged metadata are no reason to refuse intact pixels.
    let orientation = decoder.orientation().unwrap_or(Orientation::NoTransforms);
    Ok((DynamicImage::from_decoder(decoder).map_err(CodecError::Broken)?, orientation))
}

fn rgba_image(decoded: DynamicImage) -> Result<Image, CodecError> {
    let rgba = decoded.into_rgba8();
    Image::from_rgba(rgba.width(), rgba.height(), rgba.into_raw()).ok_or(CodecError::UnknownFormat)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn png_round_trip_preserves_opaque_and_transparent_images() {
        for alpha in [255, 128] {
            let mut image = Image::filled(7, 5, [10, 20, 30, alpha]);
            image.set_pixel(3, 2, [255, 0, 7, 255]);
            let bytes = encode_png(&image);
            assert_eq!(bytes, encode_png(&image));
            assert_eq!(decode_png(&bytes).expect("our own file"), image);
            assert!(matches!(decode_image(&bytes, 34), Err(CodecError::TooLarge { .. })));
        }
    }

    /// A JPEG of `image` whose EXIF block has that orientation.
    fn jpeg(image: &Image, orientation: u8) -> Vec<u8> {
        let rgb: Vec<u8> = image.as_rgba().chunks_exact(4).flat_map(|p| [p[0], p[1], p[2]]).collect();
        let mut bytes = Vec::new();
        image::codecs::jpeg::JpegEncoder::new_with_quality(&mut bytes, 100)
            .encode(&rgb, image.width_px(), image.height_px(), ExtendedColorType::Rgb8)
            .expect("encodes");
        // Exif 2.32, 4.5: one big-endian directory with the tag 0x0112 of type SHORT.
        let mut exif = b"Exif\0\0MM\0\x2a\0\0\0\x08\0\x01\x01\x12\0\x03\0\0\0\x01\0".to_vec();
        exif.extend([orientation, 0, 0, 0, 0, 0, 0]);
        let mut marked = bytes[..2].to_vec();
        marked.extend([0xff, 0xe1, 0, exif.len() as u8 + 2]);
        marked.extend(exif);
        marked.extend(&bytes[2..]);
        marked
    }

    #[test]
    fn decode_oriented_image_applies_the_exif_orientation() {
        let mut image = Image::filled(32, 16, [250, 250, 250, 255]);
        (0..16).for_each(|y| (0..8).for_each(|x| image.set_pixel(x, y, [5, 5, 5, 255])));
        let upright = decode_oriented_image(&jpeg(&image, 1), 1_000).expect("intact");
        assert_eq!((upright.width_px(), upright.height_px()), (32, 16));
        assert!(upright.pixel(2, 8)[0] < 60 && upright.pixel(28, 8)[0] > 200);
        // 6: the first row is the right side, the first column the top.
        let turned = decode_oriented_image(&jpeg(&image, 6), 1_000).expect("intact");
        assert_eq!(decode_image(&jpeg(&image, 6), 1_000).expect("intact").width_px(), 32);
        assert_eq!((turned.width_px(), turned.height_px()), (16, 32));
        assert!(turned.pixel(8, 2)[0] < 60 && turned.pixel(8, 28)[0] > 200);
    }

    #[test]
    fn decoders_reject_truncated_foreign_and_oversized_files() {
        let bytes = encode_png(&Image::filled(9, 9, [1, 2, 3, 255]));
        for length in 0..bytes.len() - 12 {
            assert!(decode_png(&bytes[..length]).is_err(), "{length} bytes");
        }
        assert!(matches!(decode_png(b"GIF89a"), Err(CodecError::UnknownFormat)));
        // A header alone decides: no pixel of 20,000 x 20,000 is ever asked for.
        let mut bomb = bytes;
        bomb[16..24].copy_from_slice(&[0, 0, 0x4e, 0x20, 0, 0, 0x4e, 0x20]);
        let checksum = crc32(&bomb[12..29]);
        bomb[29..33].copy_from_slice(&checksum.to_be_bytes());
        let refused = decode_oriented_image(&bomb, 100_000_000);
        assert!(matches!(refused, Err(CodecError::TooLarge { width_px: 20_000, .. })), "{refused:?}");
    }

    /// Checksum of a PNG chunk (PNG 1.2, appendix D).
    fn crc32(bytes: &[u8]) -> u32 {
        !bytes.iter().fold(!0, |sum: u32, byte| {
            (0..8)
                .fold(sum ^ u32::from(*byte), |sum, _| (sum >> 1) ^ (0xedb8_8320 & (sum & 1).wrapping_neg()))
        })
    }
}
