//! Pixels as files: RGB and 16-bit gray as PNG, numbers as zlib streams. Row 0 is the top everywhere.

use std::io::{Read, Write};

use flate2::Compression;
use flate2::read::ZlibDecoder;
use flate2::write::ZlibEncoder;
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder};
use imaging::Image;

/// Level of the streams: HDF5 files state it, so it must not change without them.
pub const ZLIB_LEVEL: u32 = 3;

/// Red, green and blue of every pixel, row by row.
pub fn rgb_of(image: &Image) -> Vec<u8> {
    image.as_rgba().chunks_exact(4).flat_map(|pixel| [pixel[0], pixel[1], pixel[2]]).collect()
}

/// A PNG file with 8 bits for each of red, green and blue.
pub fn rgb_png(rgb: &[u8], width_px: u32, height_px: u32) -> Vec<u8> {
    png(rgb, width_px, height_px, ExtendedColorType::Rgb8)
}

/// A PNG file with 16 bits a pixel.
pub fn gray_png(values: &[u16], width_px: u32, height_px: u32) -> Vec<u8> {
    // `image` takes numbers of 16 bits in the order of the machine.
    let bytes: Vec<u8> = values.iter().flat_map(|value| value.to_ne_bytes()).collect();
    png(&bytes, width_px, height_px, ExtendedColorType::L16)
}

fn png(bytes: &[u8], width_px: u32, height_px: u32, color: ExtendedColorType) -> Vec<u8> {
    let mut file = Vec::new();
    PngEncoder::new_with_quality(&mut file, CompressionType::Fast, FilterType::Adaptive)
        .write_image(bytes, width_px, height_px, color)
        .expect("the buffer matches the size and memory accepts every write");
    file
}

/// Meters as whole millimeters, to the nearest.
pub fn millimeters(depth_m: &[f32]) -> Vec<u16> {
    depth_m.iter().map(|depth| (depth * 1000.0).round() as u16).collect()
}

/// A zlib stream.
pub fn zlib(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::new(ZLIB_LEVEL));
    encoder.write_all(bytes).and_then(|()| encoder.finish()).expect("memory accepts every write")
}

/// The bytes of a zlib stream, at most `limit` of them; `None` where it is damaged or longer.
pub fn unzlib(stream: &[u8], limit: usize) -> Option<Vec<u8>> {
    let mut bytes = Vec::new();
    ZlibDecoder::new(stream).take(limit as u64 + 1).read_to_end(&mut bytes).ok()?;
    (bytes.len() <= limit).then_some(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn streams_come_back() {
        let bytes: Vec<u8> = (0..2000_u32).map(|i| (i * i % 251) as u8).collect();
        assert_eq!(unzlib(&zlib(&bytes), 2000).as_deref(), Some(bytes.as_slice()));
        assert_eq!(unzlib(&zlib(&bytes), 1999), None);
        assert_eq!(unzlib(b"no stream", 1999), None);
    }

    #[test]
    fn gray_values_come_back_in_full_depth() {
        let values = [0, 1, 255, 256, 40_000, 65_535];
        let file = image::load_from_memory(&gray_png(&values, 3, 2)).expect("an image").into_luma16();
        assert_eq!(file.as_raw().as_slice(), values);
        assert_eq!(millimeters(&[0.0, 0.0004, 0.0006, 1.2345, 65.535]), [0, 0, 1, 1235, 65_535]);
    }
}
