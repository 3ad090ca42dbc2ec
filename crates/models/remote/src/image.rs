//! Encoding of images for requests, and decoding of images in responses.

use std::borrow::Cow;

use bytes::Bytes;
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder, ImageError};

use imaging::Image;
use imaging::codec::{CodecError, DecodeLimits, decode_image_within};
use render::annotate::fitted;

/// Largest side of an image that is taken from a vendor, pixels.
const MAX_SIDE_PX: u32 = 4096;

/// Bounds of the decoder for files of vendors.
const LIMITS: DecodeLimits =
    DecodeLimits { max_side_px: MAX_SIDE_PX, max_pixels: u64::MAX, max_decoded_bytes: 256 << 20 };

/// Reason why the bytes of a response are not accepted as an image.
#[derive(Debug, thiserror::Error)]
pub enum ImageRefused {
    #[error("they are no PNG, JPEG or WebP file")]
    UnknownFormat,
    #[error("it moves")]
    Animated,
    #[error("its file ends early")]
    Truncated,
    #[error("it is {0} x {1} pixels, more than {MAX_SIDE_PX} a side")]
    TooLarge(u32, u32),
    #[error("it cannot be decoded: {0}")]
    Broken(ImageError),
}

impl From<CodecError> for ImageRefused {
    fn from(error: CodecError) -> Self {
        match error {
            CodecError::UnknownFormat => Self::UnknownFormat,
            CodecError::Animated => Self::Animated,
            CodecError::Truncated => Self::Truncated,
            CodecError::TooLarge { width_px, height_px, .. } => Self::TooLarge(width_px, height_px),
            CodecError::Broken(error) => Self::Broken(error),
        }
    }
}

/// The image as an opaque PNG file whose longer side is at most `longest_px`; larger images are reduced. Equal images
/// give equal bytes.
///
/// # Errors
///
/// An image without pixels has no PNG form.
pub fn sent(image: &Image, longest_px: u32) -> Result<Bytes, ImageError> {
    let image = &reduced(image, longest_px);
    let rgb: Vec<u8> =
        image.as_rgba().chunks_exact(4).flat_map(|pixel| [pixel[0], pixel[1], pixel[2]]).collect();
    png(&rgb, image, ExtendedColorType::Rgb8)
}

/// As [`sent`], with transparency.
///
/// # Errors
///
/// As [`sent`].
pub fn sent_cut_out(image: &Image, longest_px: u32) -> Result<Bytes, ImageError> {
    let image = &reduced(image, longest_px);
    png(image.as_rgba(), image, ExtendedColorType::Rgba8)
}

fn reduced(image: &Image, longest_px: u32) -> Cow<'_, Image> {
    match image.width_px().max(image.height_px()) > longest_px {
        true => Cow::Owned(fitted(image, longest_px, longest_px)),
        false => Cow::Borrowed(image),
    }
}

fn png(pixels: &[u8], image: &Image, color: ExtendedColorType) -> Result<Bytes, ImageError> {
    let mut bytes = Vec::new();
    PngEncoder::new_with_quality(&mut bytes, CompressionType::Default, FilterType::Adaptive).write_image(
        pixels,
        image.width_px(),
        image.height_px(),
        color,
    )?;
    Ok(bytes.into())
}

/// Decodes an image of a vendor, within [`MAX_SIDE_PX`] a side and 256 MiB. Its EXIF orientation is ignored.
///
/// # Errors
///
/// [`ImageRefused`] for another format, an animation, a larger image or damaged bytes.
pub fn received(bytes: &[u8]) -> Result<Image, ImageRefused> {
    Ok(decode_image_within(bytes, &LIMITS)?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sent_reduces_only_large_images() {
        let size = |width, height| {
            let png = sent(&Image::filled(width, height, [10, 20, 30, 255]), 256).expect("encodes");
            let read = image::load_from_memory(&png).expect("is a picture");
            assert_eq!(read.to_rgb8().get_pixel(0, 0).0, [10, 20, 30]);
            (read.width(), read.height())
        };
        assert_eq!(size(512, 256), (256, 128));
        assert_eq!(size(100, 50), (100, 50));
    }

    #[test]
    fn received_keeps_transparency() {
        let mut image = Image::filled(9, 5, [0; 4]);
        image.set_pixel(3, 2, [200, 10, 7, 255]);
        let png = sent_cut_out(&image, 4096).expect("encodes");
        assert_eq!(received(&png).expect("is intact"), image);
    }

    #[test]
    fn received_rejects_hostile_files_before_allocating() {
        let mut image = Image::filled(64, 64, [1, 2, 3, 255]);
        image.as_rgba_mut().iter_mut().enumerate().for_each(|(k, byte)| *byte = (k * k % 251) as u8);
        let whole = sent_cut_out(&image, 4096).expect("encodes");
        for length in [0, 7, 8, 20, 33, 40, whole.len() / 2] {
            assert!(received(&whole[..length]).is_err(), "{length} bytes of {}", whole.len());
        }
        // A header that promises 65535 x 65535 pixels, its checksum right.
        let mut bomb = whole.to_vec();
        bomb[16..24].copy_from_slice(&[0, 0, 255, 255, 0, 0, 255, 255]);
        let checksum = crc32(&bomb[12..29]);
        bomb[29..33].copy_from_slice(&checksum.to_be_bytes());
        assert!(matches!(received(&bomb), Err(ImageRefused::TooLarge(65535, 65535))));
        for text in ["<svg/>", "GIF89a", "<html>"] {
            assert!(matches!(received(text.as_bytes()), Err(ImageRefused::UnknownFormat)), "{text}");
        }
    }

    /// CRC-32 of a PNG chunk (ISO 3309).
    fn crc32(bytes: &[u8]) -> u32 {
        let step = |crc: u32, byte: &u8| {
            (0..8).fold(crc ^ u32::from(*byte), |crc, _| {
                if crc & 1 == 1 { (crc >> 1) ^ 0xedb8_8320 } else { crc >> 1 }
            })
        };
        !bytes.iter().fold(u32::MAX, step)
    }
}
