//! Depth images: distances along the optical axis, in whole millimeters, as depth cameras store them.

use std::io::Cursor;

use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{DynamicImage, ExtendedColorType, ImageEncoder, ImageFormat};

use crate::codec::{CodecError, DecodeLimits, decode};

/// Largest relative difference of the aspects of a depth image and its image. Sides that are rounded differ by less.
pub const MAX_ASPECT_DIFFERENCE: f64 = 0.02;

/// A depth image, row by row from the top.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DepthImage {
    width_px: u32,
    height_px: u32,
    /// 0 = not measured.
    depths_mm: Vec<u16>,
}

/// Reason why a file is no depth image.
#[derive(Debug, thiserror::Error)]
pub enum DepthError {
    #[error("it is no PNG file; send a PNG with one channel of 16 bits")]
    Format,
    #[error(
        "its pixels are {found}, not gray of 16 bits; save millimeters as a PNG with one channel of 16 bits"
    )]
    PixelType { found: &'static str },
    #[error("its file cannot be decoded ({0}); save it again and send that")]
    Unreadable(#[source] CodecError),
    #[error("no pixel has a measurement (all are 0); send another, or leave the depth image out")]
    Empty,
}

impl DepthImage {
    /// `None` unless there is one depth a pixel.
    pub fn new(width_px: u32, height_px: u32, depths_mm: Vec<u16>) -> Option<Self> {
        let pixels = u64::from(width_px) * u64::from(height_px);
        (pixels > 0 && depths_mm.len() as u64 == pixels).then_some(Self { width_px, height_px, depths_mm })
    }

    /// Decodes a PNG file of one 16-bit channel with at most `max_pixels` pixels.
    ///
    /// # Errors
    ///
    /// [`DepthError`] for other files, other pixels, and an image without a measurement.
    pub fn decode_png(bytes: &[u8], max_pixels: u64) -> Result<Self, DepthError> {
        let limits = DecodeLimits::with_max_pixels(max_pixels);
        let decoded = match decode(bytes, &[ImageFormat::Png], &limits) {
            Ok((decoded, _)) => decoded,
            Err(CodecError::UnknownFormat) => return Err(DepthError::Format),
            Err(error) => return Err(DepthError::Unreadable(error)),
        };
        let gray = match decoded {
            DynamicImage::ImageLuma16(gray) => gray,
            other => return Err(DepthError::PixelType { found: pixel_type(&other) }),
        };
        let (width_px, height_px) = gray.dimensions();
        let depth = Self::new(width_px, height_px, gray.into_raw()).ok_or(DepthError::Empty)?;
        if depth.measured_share() == 0.0 { Err(DepthError::Empty) } else { Ok(depth) }
    }

    /// The depths as a PNG file of one 16-bit channel.
    pub fn encode_png(&self) -> Vec<u8> {
        let mut bytes = Cursor::new(Vec::new());
        let encoder = PngEncoder::new_with_quality(&mut bytes, CompressionType::Fast, FilterType::Adaptive);
        // The encoder takes 16-bit samples in native order.
        let samples: Vec<u8> = self.depths_mm.iter().flat_map(|depth_mm| depth_mm.to_ne_bytes()).collect();
        encoder
            .write_image(&samples, self.width_px, self.height_px, ExtendedColorType::L16)
            .expect("the buffer matches the size and memory accepts every write");
        bytes.into_inner()
    }

    pub fn width_px(&self) -> u32 {
        self.width_px
    }

    pub fn height_px(&self) -> u32 {
        self.height_px
    }

    /// Row by row from the top, millimeters; 0 = not measured.
    pub fn depths_mm(&self) -> &[u16] {
        &self.depths_mm
    }

    /// Share of the pixels with a measurement, 0..1.
    pub fn measured_share(&self) -> f64 {
        let measured = self.depths_mm.iter().filter(|depth_mm| **depth_mm > 0).count();
        measured as f64 / self.depths_mm.len() as f64
    }

    /// Whether it has the aspect of an image of that size, so that pixels correspond.
    pub fn has_aspect_of(&self, width_px: u32, height_px: u32) -> bool {
        let aspect = |width_px: u32, height_px: u32| f64::from(width_px) / f64::from(height_px.max(1));
        (aspect(self.width_px, self.height_px) / aspect(width_px, height_px) - 1.0).abs()
            <= MAX_ASPECT_DIFFERENCE
    }

    /// The depths in another size. Each pixel gets the depth of the pixel that holds its center: means over edges
    /// would be surfaces that do not exist.
    pub fn resampled(&self, width_px: u32, height_px: u32) -> Self {
        let (width_px, height_px) = (width_px.max(1), height_px.max(1));
        let nearest = |at: u32, of: u32, size: u32| {
            (((f64::from(at) + 0.5) * f64::from(size) / f64::from(of)) as u32).min(size - 1)
        };
        let columns: Vec<usize> =
            (0..width_px).map(|x| nearest(x, width_px, self.width_px) as usize).collect();
        let rows = (0..height_px).map(|y| nearest(y, height_px, self.height_px) as usize);
        let depths_mm =
            rows.flat_map(|y| columns.iter().map(move |x| self.depths_mm[y * self.width_px as usize + x]));
        Self { width_px, height_px, depths_mm: depths_mm.collect() }
    }
}

fn pixel_type(decoded: &DynamicImage) -> &'static str {
    match decoded {
        DynamicImage::ImageLuma8(_) => "gray of 8 bits",
        DynamicImage::ImageLumaA8(_) | DynamicImage::ImageLumaA16(_) => "gray with transparency",
        DynamicImage::ImageRgb8(_) | DynamicImage::ImageRgba8(_) => "colors of 8 bits",
        _ => "colors of 16 bits",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Image;
    use crate::codec::encode_png;

    fn ramp() -> DepthImage {
        DepthImage::new(6, 4, (0..24).map(|index| 500 * (index % 6)).collect()).expect("24 depths")
    }

    #[test]
    fn depths_survive_their_file() {
        let decoded = DepthImage::decode_png(&ramp().encode_png(), 100).expect("a depth image");
        assert_eq!(decoded, ramp());
        assert!((decoded.measured_share() - 20.0 / 24.0).abs() < 1e-12);
    }

    #[test]
    fn other_files_are_refused_with_a_reason() {
        let refusal = |bytes: &[u8]| DepthImage::decode_png(bytes, 100).expect_err("is refused").to_string();
        let colors = encode_png(&Image::filled(6, 4, [9, 8, 7, 255]));
        assert!(refusal(&colors).contains("colors of 8 bits, not gray of 16 bits"), "{}", refusal(&colors));
        let mut gray = Cursor::new(Vec::new());
        image::GrayImage::new(6, 4).write_to(&mut gray, ImageFormat::Png).expect("encodes");
        assert!(refusal(gray.get_ref()).contains("gray of 8 bits"));
        assert!(refusal(b"\xff\xd8\xff\xe0 a JPEG").contains("no PNG"));
        let whole = ramp().encode_png();
        assert!(refusal(&whole[..whole.len() - 20]).contains("cannot be decoded"));
        let empty = DepthImage::new(6, 4, vec![0; 24]).expect("24 depths").encode_png();
        assert!(refusal(&empty).contains("no pixel has a measurement"));
        assert!(DepthImage::decode_png(&ramp().encode_png(), 23).is_err(), "more pixels than allowed");
    }

    #[test]
    fn resampling_keeps_depths_and_columns() {
        let twice = ramp().resampled(12, 8);
        assert_eq!(twice.depths_mm()[..4], [0, 0, 500, 500]);
        assert_eq!(twice.resampled(6, 4), ramp());
        assert_eq!(ramp().resampled(3, 2).depths_mm(), [500, 1500, 2500, 500, 1500, 2500]);
    }

    #[test]
    fn aspect_may_differ_by_rounding_alone() {
        assert!(ramp().has_aspect_of(600, 402));
        assert!(!ramp().has_aspect_of(600, 450));
    }
}
