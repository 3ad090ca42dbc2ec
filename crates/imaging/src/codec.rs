//! Pictures as PNG bytes and back.
//!
//! Lossless; opaque pictures are stored without an alpha channel. The encoder runs single-threaded
//! with fixed filters and the fast deflate level, so equal pictures give equal bytes.

use std::io::Cursor;

use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::metadata::Orientation;
use image::{DynamicImage, ExtendedColorType, ImageDecoder, ImageEncoder, ImageFormat, ImageReader, Limits};

use crate::Image;
use crate::animated_webp::is_moving_webp;

/// Largest side of a picture that is decoded, pixels.
pub const MAX_SIDE_PX: u32 = 16_384;
/// Largest amount of memory a decoder may ask for, bytes.
const MAX_DECODED_BYTES: u64 = 512 << 20;

/// Why bytes were not read as a picture.
#[derive(Debug, thiserror::Error)]
pub enum PictureError {
    #[error("these bytes are no picture of an accepted format (PNG, JPEG, WebP)")]
    UnknownFormat,
    #[error(
        "the picture is {width_px} x {height_px} pixels; decoding stops at {MAX_SIDE_PX} a side or \
         {budget_px} in all"
    )]
    TooLarge { width_px: u32, height_px: u32, budget_px: u64 },
    #[error("the picture moves; send a single one")]
    Moving,
    #[error("the picture could not be decoded; send an intact file")]
    Broken(#[source] image::ImageError),
}

/// Losslessly compressed bytes. A picture without pixels, which PNG cannot express, becomes one
/// transparent pixel.
pub fn encode_png(picture: &Image) -> Vec<u8> {
    let (width_px, height_px) = (picture.width_px(), picture.height_px());
    if width_px == 0 || height_px == 0 {
        return encode_png(&Image::filled(1, 1, [0; 4]));
    }
    let mut bytes = Vec::new();
    let encoder = PngEncoder::new_with_quality(&mut bytes, CompressionType::Fast, FilterType::Adaptive);
    let rgba = picture.as_rgba();
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

/// The picture in PNG bytes; other formats are refused.
pub fn decode_png(bytes: &[u8]) -> Result<Image, PictureError> {
    decode(bytes, &[ImageFormat::Png], u64::MAX)
}

/// The picture in PNG, JPEG or WebP bytes, at most `budget_px` pixels, as it is stored (textures of glTF ignore EXIF).
pub fn decode_picture(bytes: &[u8], budget_px: u64) -> Result<Image, PictureError> {
    decode(bytes, &[ImageFormat::Png, ImageFormat::Jpeg, ImageFormat::WebP], budget_px)
}

/// As [`decode_picture`], turned as the EXIF orientation says, which is how people see it.
pub fn decode_photograph(bytes: &[u8], budget_px: u64) -> Result<Image, PictureError> {
    let (decoded, orientation) =
        decoded(bytes, &[ImageFormat::Png, ImageFormat::Jpeg, ImageFormat::WebP], budget_px)?;
    picture(decoded, orientation)
}

fn decode(bytes: &[u8], accepted: &[ImageFormat], budget_px: u64) -> Result<Image, PictureError> {
    let (decoded, _) = decoded(bytes, accepted, budget_px)?;
    picture(decoded, Orientation::NoTransforms)
}

fn picture(mut decoded: DynamicImage, orientation: Orientation) -> Result<Image, PictureError> {
    decoded.apply_orientation(orientation);
    let rgba = decoded.into_rgba8();
    Image::from_rgba(rgba.width(), rgba.height(), rgba.into_raw()).ok_or(PictureError::UnknownFormat)
}

fn decoded(
    bytes: &[u8],
    accepted: &[ImageFormat],
    budget_px: u64,
) -> Result<(DynamicImage, Orientation), PictureError> {
    let format = image::guess_format(bytes).map_err(|_| PictureError::UnknownFormat)?;
    if !accepted.contains(&format) {
        return Err(PictureError::UnknownFormat);
    }
    if is_moving_webp(bytes) {
        return Err(PictureError::Moving);
    }
    let mut limits = Limits::default();
    limits.max_alloc = Some(MAX_DECODED_BYTES);
    let mut reader = ImageReader::with_format(Cursor::new(bytes), format);
    reader.limits(limits);
    let mut decoder = reader.into_decoder().map_err(PictureError::Broken)?;
    let (width_px, height_px) = decoder.dimensions();
    if width_px > MAX_SIDE_PX
        || height_px > MAX_SIDE_PX
        || u64::from(width_px) * u64::from(height_px) > budget_px
    {
        return Err(PictureError::TooLarge { width_px, height_px, budget_px });
    }
    // Damaged metadata are no reason to refuse intact pixels.
    let orientation = decoder.orientation().unwrap_or(Orientation::NoTransforms);
    Ok((DynamicImage::from_decoder(decoder).map_err(PictureError::Broken)?, orientation))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_survive_with_and_without_alpha() {
        for alpha in [255, 128] {
            let mut picture = Image::filled(7, 5, [10, 20, 30, alpha]);
            picture.set_pixel(3, 2, [255, 0, 7, 255]);
            let bytes = encode_png(&picture);
            assert_eq!(bytes, encode_png(&picture));
            assert_eq!(decode_png(&bytes).expect("our own file"), picture);
            assert!(matches!(decode_picture(&bytes, 34), Err(PictureError::TooLarge { .. })));
        }
    }

    /// A JPEG of `picture` whose EXIF block has that orientation.
    fn jpeg(picture: &Image, orientation: u8) -> Vec<u8> {
        let rgb: Vec<u8> = picture.as_rgba().chunks_exact(4).flat_map(|p| [p[0], p[1], p[2]]).collect();
        let mut bytes = Vec::new();
        image::codecs::jpeg::JpegEncoder::new_with_quality(&mut bytes, 100)
            .encode(&rgb, picture.width_px(), picture.height_px(), ExtendedColorType::Rgb8)
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
    fn a_picture_taken_with_a_turned_camera_stands_upright() {
        let mut picture = Image::filled(32, 16, [250, 250, 250, 255]);
        (0..16).for_each(|y| (0..8).for_each(|x| picture.set_pixel(x, y, [5, 5, 5, 255])));
        let upright = decode_photograph(&jpeg(&picture, 1), 1_000).expect("intact");
        assert_eq!((upright.width_px(), upright.height_px()), (32, 16));
        assert!(upright.pixel(2, 8)[0] < 60 && upright.pixel(28, 8)[0] > 200);
        // 6: the first row is the right side, the first column the top.
        let turned = decode_photograph(&jpeg(&picture, 6), 1_000).expect("intact");
        assert_eq!(decode_picture(&jpeg(&picture, 6), 1_000).expect("intact").width_px(), 32);
        assert_eq!((turned.width_px(), turned.height_px()), (16, 32));
        assert!(turned.pixel(8, 2)[0] < 60 && turned.pixel(8, 28)[0] > 200);
    }

    #[test]
    fn broken_bytes_are_errors() {
        let bytes = encode_png(&Image::filled(9, 9, [1, 2, 3, 255]));
        for length in 0..bytes.len() - 12 {
            assert!(decode_png(&bytes[..length]).is_err(), "{length} bytes");
        }
        assert!(matches!(decode_png(b"GIF89a"), Err(PictureError::UnknownFormat)));
        // A header alone decides: no pixel of 20,000 x 20,000 is ever asked for.
        let mut bomb = bytes;
        bomb[16..24].copy_from_slice(&[0, 0, 0x4e, 0x20, 0, 0, 0x4e, 0x20]);
        let checksum = crc32(&bomb[12..29]);
        bomb[29..33].copy_from_slice(&checksum.to_be_bytes());
        let refused = decode_photograph(&bomb, 100_000_000);
        assert!(matches!(refused, Err(PictureError::TooLarge { width_px: 20_000, .. })), "{refused:?}");
    }

    /// Of a PNG chunk (PNG 1.2, appendix D).
    fn crc32(bytes: &[u8]) -> u32 {
        !bytes.iter().fold(!0, |sum: u32, byte| {
            (0..8)
                .fold(sum ^ u32::from(*byte), |sum, _| (sum >> 1) ^ (0xedb8_8320 & (sum & 1).wrapping_neg()))
        })
    }
}
