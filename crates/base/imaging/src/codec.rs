//! Image files: a PNG encoder, and one bounded decoder of PNG, JPEG and WebP.
//!
//! The encoder is lossless; opaque images are stored without an alpha channel. It runs single-threaded with fixed
//! filters and the fast deflate level, so equal images give equal bytes.
//!
//! One rule holds for all formats: a damaged, incomplete or animated file is refused. The decoder walks the parts of
//! the file before it decodes, drops those that only describe the image, and checks the size before it allocates
//! pixels. Its memory is bounded by the declared pixels, whatever else the file holds.

mod jpeg;
mod jpeg_segments;
mod kept_ranges;
mod png_chunks;
#[cfg(test)]
mod tests;
mod webp_chunks;

use std::borrow::Cow;
use std::io::Cursor;

use image::codecs::jpeg::JpegEncoder;
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::error::{LimitError, LimitErrorKind};
use image::imageops::thumbnail;
use image::metadata::Orientation;
use image::{
    DynamicImage, ExtendedColorType, ImageDecoder, ImageEncoder, ImageError, ImageFormat, ImageReader,
    Limits, RgbImage,
};

use self::jpeg::decode_jpeg;
use self::jpeg_segments::still_jpeg;
use self::png_chunks::still_png;
use self::webp_chunks::check_still_webp;
use crate::Image;

/// Smallest side of an image of a scene, pixels: with fewer, objects cannot be distinguished.
pub const MIN_SCENE_SIDE_PX: u32 = 160;

/// Largest ratio of the sides of an image of a scene: reduced to 1280 pixels, its shorter side keeps
/// [`MIN_SCENE_SIDE_PX`].
pub const MAX_SCENE_SIDE_RATIO: u32 = 8;

/// Quality of JPEG files for lists, of 100: about 20 kB at 320 pixels.
const THUMBNAIL_QUALITY: u8 = 82;

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
    /// At most `max_pixels` pixels, [`MAX_SIDE_PX`] a side and 768 MiB.
    pub fn with_max_pixels(max_pixels: u64) -> Self {
        Self { max_side_px: MAX_SIDE_PX, max_pixels, max_decoded_bytes: 768 << 20 }
    }
}

/// Content of the header of an image file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ImageHeader {
    pub media_type: &'static str,
    pub width_px: u32,
    pub height_px: u32,
}

/// Reason why bytes were not decoded as an image.
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
    #[error("the file ends before its image does; send the whole file")]
    Truncated,
    #[error("the image could not be decoded; send an intact file")]
    Broken(#[source] ImageError),
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

/// A JPEG file of the image for lists, at most `width_px` pixels wide: each pixel is the mean of those that it covers.
/// Transparent parts are white. An image without pixels becomes one white pixel.
pub fn encode_thumbnail(image: &Image, width_px: u32) -> Vec<u8> {
    let (from_width, from_height) = (image.width_px(), image.height_px());
    if from_width == 0 || from_height == 0 {
        return encode_thumbnail(&Image::filled(1, 1, [255; 4]), width_px);
    }
    let over_white = |pixel: &[u8]| {
        let alpha = u32::from(pixel[3]);
        [0, 1, 2].map(|channel| ((u32::from(pixel[channel]) * alpha + 255 * (255 - alpha) + 127) / 255) as u8)
    };
    let rgb: Vec<u8> = image.as_rgba().chunks_exact(4).flat_map(over_white).collect();
    let full = RgbImage::from_raw(from_width, from_height, rgb).expect("the buffer matches the size");
    let width = width_px.clamp(1, from_width);
    let height = (u64::from(from_height) * u64::from(width) / u64::from(from_width)).max(1) as u32;
    let small = if width == from_width { full } else { thumbnail(&full, width, height) };
    let mut bytes = Vec::new();
    let encoder = JpegEncoder::new_with_quality(&mut bytes, THUMBNAIL_QUALITY);
    let written = encoder.write_image(&small, small.width(), small.height(), ExtendedColorType::Rgb8);
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
    let still = StillImage::of(bytes, ACCEPTED_FORMATS)?;
    let (width_px, height_px) = still.size_px()?;
    Ok(ImageHeader { media_type: still.format.to_mime_type(), width_px, height_px })
}

/// The media type by the first bytes, if it is an accepted one.
pub fn media_type_of(bytes: &[u8]) -> Option<&'static str> {
    let format = image::guess_format(bytes).ok()?;
    ACCEPTED_FORMATS.contains(&format).then(|| format.to_mime_type())
}

/// Decodes every pixel of a PNG, JPEG or WebP file and discards them. Pixels and decoder together may take
/// `max_decoded_bytes` of memory.
///
/// # Errors
///
/// [`CodecError`] for another format, an animation, an image that needs more memory, or damaged bytes.
pub fn verify_image(bytes: &[u8], max_decoded_bytes: u64) -> Result<(), CodecError> {
    let limits = DecodeLimits { max_side_px: u32::MAX, max_pixels: u64::MAX, max_decoded_bytes };
    decode(bytes, ACCEPTED_FORMATS, &limits).map(drop)
}

/// A complete file of a still image, without parts that only describe it.
struct StillImage<'a> {
    format: ImageFormat,
    file: Cow<'a, [u8]>,
}

impl<'a> StillImage<'a> {
    /// The format is that of the first bytes.
    fn of(bytes: &'a [u8], accepted: &[ImageFormat]) -> Result<Self, CodecError> {
        let format = image::guess_format(bytes).map_err(|_| CodecError::UnknownFormat)?;
        if !accepted.contains(&format) {
            return Err(CodecError::UnknownFormat);
        }
        let file = match format {
            ImageFormat::Png => still_png(bytes)?,
            ImageFormat::Jpeg => still_jpeg(bytes)?,
            _ => check_still_webp(bytes).map(|()| Cow::Borrowed(bytes))?,
        };
        Ok(Self { format, file })
    }

    fn size_px(&self) -> Result<(u32, u32), CodecError> {
        let reader = ImageReader::with_format(Cursor::new(self.file.as_ref()), self.format);
        reader.into_dimensions().map_err(CodecError::Broken)
    }
}

/// The stored pixels, in their own type, and the EXIF orientation.
pub(crate) fn decode(
    bytes: &[u8],
    accepted: &[ImageFormat],
    limits: &DecodeLimits,
) -> Result<(DynamicImage, Orientation), CodecError> {
    let still = StillImage::of(bytes, accepted)?;
    let (width_px, height_px) = still.size_px()?;
    let DecodeLimits { max_side_px, max_pixels, max_decoded_bytes } = *limits;
    if width_px > max_side_px
        || height_px > max_side_px
        || u64::from(width_px) * u64::from(height_px) > max_pixels
    {
        return Err(CodecError::TooLarge { width_px, height_px, max_side_px, max_pixels });
    }
    if still.format == ImageFormat::Jpeg {
        return decode_jpeg(&still.file, max_decoded_bytes);
    }
    let mut memory = Limits::default();
    memory.max_alloc = Some(max_decoded_bytes);
    let mut reader = ImageReader::with_format(Cursor::new(still.file.as_ref()), still.format);
    reader.limits(memory);
    let mut decoder = reader.into_decoder().map_err(CodecError::Broken)?;
    if decoder.total_bytes() > max_decoded_bytes {
        return Err(out_of_memory());
    }
    // Damaged metadata are no reason to refuse intact pixels.
    let orientation = decoder.orientation().unwrap_or(Orientation::NoTransforms);
    Ok((DynamicImage::from_decoder(decoder).map_err(CodecError::Broken)?, orientation))
}

fn out_of_memory() -> CodecError {
    CodecError::Broken(ImageError::Limits(LimitError::from_kind(LimitErrorKind::InsufficientMemory)))
}

fn rgba_image(decoded: DynamicImage) -> Result<Image, CodecError> {
    let rgba = decoded.into_rgba8();
    Image::from_rgba(rgba.width(), rgba.height(), rgba.into_raw()).ok_or(CodecError::UnknownFormat)
}
