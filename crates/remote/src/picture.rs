//! Pictures as they are sent and as they come back.

use std::borrow::Cow;
use std::io::Cursor;

use bytes::Bytes;
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageDecoder, ImageEncoder, ImageError, ImageFormat, ImageReader, Limits};

use imaging::Image;
use imaging::animated_webp::is_moving_webp;
use render::overlay::fitted;

/// Longest side of a picture that is taken from a vendor, pixels.
const MAX_SIDE_PX: u32 = 4096;

/// Most memory that a decoder may ask for, bytes.
const MAX_DECODED_BYTES: u64 = 256 << 20;

/// Why an answer's bytes are no picture.
#[derive(Debug, thiserror::Error)]
pub enum PictureRefused {
    #[error("they are no PNG, JPEG or WebP file")]
    UnknownFormat,
    #[error("it moves")]
    Moving,
    #[error("it is {0} x {1} pixels, more than {MAX_SIDE_PX} a side")]
    TooLarge(u32, u32),
    #[error("it cannot be decoded: {0}")]
    Broken(ImageError),
}

/// The picture as a PNG file whose longer side is at most `longest_px`, without transparency; larger ones are reduced,
/// smaller ones stay. Same picture, same bytes.
pub fn sent(picture: &Image, longest_px: u32) -> Result<Bytes, ImageError> {
    let picture = &reduced(picture, longest_px);
    let rgb: Vec<u8> =
        picture.as_rgba().chunks_exact(4).flat_map(|pixel| [pixel[0], pixel[1], pixel[2]]).collect();
    png(&rgb, picture, ExtendedColorType::Rgb8)
}

/// The same with its transparency.
pub fn sent_cut_out(picture: &Image, longest_px: u32) -> Result<Bytes, ImageError> {
    let picture = &reduced(picture, longest_px);
    png(picture.as_rgba(), picture, ExtendedColorType::Rgba8)
}

fn reduced(picture: &Image, longest_px: u32) -> Cow<'_, Image> {
    match picture.width_px().max(picture.height_px()) > longest_px {
        true => Cow::Owned(fitted(picture, longest_px, longest_px)),
        false => Cow::Borrowed(picture),
    }
}

fn png(pixels: &[u8], picture: &Image, color: ExtendedColorType) -> Result<Bytes, ImageError> {
    let mut bytes = Vec::new();
    PngEncoder::new_with_quality(&mut bytes, CompressionType::Default, FilterType::Adaptive).write_image(
        pixels,
        picture.width_px(),
        picture.height_px(),
        color,
    )?;
    Ok(bytes.into())
}

/// A picture that a vendor sent: its size is looked at before anything is allocated for it.
pub fn received(bytes: &[u8]) -> Result<Image, PictureRefused> {
    let format = image::guess_format(bytes).map_err(|_| PictureRefused::UnknownFormat)?;
    if ![ImageFormat::Png, ImageFormat::Jpeg, ImageFormat::WebP].contains(&format) {
        return Err(PictureRefused::UnknownFormat);
    }
    if is_moving_webp(bytes) {
        return Err(PictureRefused::Moving);
    }
    let mut limits = Limits::default();
    limits.max_alloc = Some(MAX_DECODED_BYTES);
    let mut reader = ImageReader::with_format(Cursor::new(bytes), format);
    reader.limits(limits);
    let decoder = reader.into_decoder().map_err(PictureRefused::Broken)?;
    let (width_px, height_px) = decoder.dimensions();
    if width_px.max(height_px) > MAX_SIDE_PX {
        return Err(PictureRefused::TooLarge(width_px, height_px));
    }
    let rgba = image::DynamicImage::from_decoder(decoder).map_err(PictureRefused::Broken)?.into_rgba8();
    Image::from_rgba(rgba.width(), rgba.height(), rgba.into_raw()).ok_or(PictureRefused::UnknownFormat)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn large_pictures_are_reduced_and_small_ones_stay() {
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
    fn what_comes_back_is_read_and_transparency_survives() {
        let mut picture = Image::filled(9, 5, [0; 4]);
        picture.set_pixel(3, 2, [200, 10, 7, 255]);
        let png = sent_cut_out(&picture, 4096).expect("encodes");
        assert_eq!(received(&png).expect("is intact"), picture);
    }

    #[test]
    fn hostile_files_are_refused_before_they_cost_anything() {
        let mut picture = Image::filled(64, 64, [1, 2, 3, 255]);
        picture.as_rgba_mut().iter_mut().enumerate().for_each(|(k, byte)| *byte = (k * k % 251) as u8);
        let whole = sent_cut_out(&picture, 4096).expect("encodes");
        for length in [0, 7, 8, 20, 33, 40, whole.len() / 2] {
            assert!(received(&whole[..length]).is_err(), "{length} bytes of {}", whole.len());
        }
        // A header that promises 65535 x 65535 pixels, its checksum right.
        let mut bomb = whole.to_vec();
        bomb[16..24].copy_from_slice(&[0, 0, 255, 255, 0, 0, 255, 255]);
        let checksum = crc32(&bomb[12..29]);
        bomb[29..33].copy_from_slice(&checksum.to_be_bytes());
        assert!(matches!(received(&bomb), Err(PictureRefused::TooLarge(65535, 65535))));
        for text in ["<svg/>", "GIF89a", "<html>"] {
            assert!(matches!(received(text.as_bytes()), Err(PictureRefused::UnknownFormat)), "{text}");
        }
    }

    /// As PNG counts (ISO 3309).
    fn crc32(bytes: &[u8]) -> u32 {
        let step = |crc: u32, byte: &u8| {
            (0..8).fold(crc ^ u32::from(*byte), |crc, _| {
                if crc & 1 == 1 { (crc >> 1) ^ 0xedb8_8320 } else { crc >> 1 }
            })
        };
        !bytes.iter().fold(u32::MAX, step)
    }
}
