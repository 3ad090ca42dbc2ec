//! Decodes JPEG files strictly: a file whose coded data end early or hold a foreign marker is refused, where browsers
//! show gray.
//!
//! The decoder reads zeros where data end before the end marker, and does not tell. The file is therefore decoded again
//! with more data before its end marker: a complete image does not change, since nothing is read after its last block.
//! Cost: two decodings. Memory: the pixels twice, and the coefficients of progressive files.

use image::error::DecodingError;
use image::metadata::Orientation;
use image::{DynamicImage, GrayImage, ImageError, ImageFormat, RgbImage};
use zune_core::bytestream::ZCursor;
use zune_core::colorspace::ColorSpace;
use zune_core::options::DecoderOptions;
use zune_jpeg::JpegDecoder;
use zune_jpeg::errors::DecodeErrors;

use super::{CodecError, out_of_memory};

/// The pixels and the EXIF orientation of a file without foreign segments.
///
/// # Errors
///
/// [`CodecError::Broken`] for damaged data, or for an image that needs more than `max_decoded_bytes` of memory.
pub(super) fn decode_jpeg(
    file: &[u8],
    max_decoded_bytes: u64,
) -> Result<(DynamicImage, Orientation), CodecError> {
    let mut decoder = decoder_of(file, true);
    decoder.decode_headers().map_err(broken)?;
    let info = decoder.info().ok_or(CodecError::Truncated)?;
    // A progressive image keeps its coefficients, two bytes each, until the last scan.
    let samples = u64::from(info.width) * u64::from(info.height) * u64::from(info.components);
    if samples.saturating_mul(4) > max_decoded_bytes {
        return Err(out_of_memory());
    }
    let orientation = decoder.exif().and_then(|exif| Orientation::from_exif_chunk(exif));
    let is_gray = decoder.input_colorspace() == Some(ColorSpace::Luma);
    let color = if is_gray { ColorSpace::Luma } else { ColorSpace::RGB };
    decoder.set_options(decoder.options().jpeg_set_out_colorspace(color));
    let pixels = decoder.decode().map_err(broken)?;
    let with_more = [&file[..file.len() - END_BYTES], &MORE_DATA, &file[file.len() - END_BYTES..]].concat();
    let mut again = decoder_of(&with_more, false);
    again.set_options(again.options().jpeg_set_out_colorspace(color));
    if again.decode().map_err(broken)? != pixels {
        return Err(CodecError::Truncated);
    }
    let (width_px, height_px) = (u32::from(info.width), u32::from(info.height));
    let image = match is_gray {
        true => GrayImage::from_raw(width_px, height_px, pixels).map(DynamicImage::from),
        false => RgbImage::from_raw(width_px, height_px, pixels).map(DynamicImage::from),
    };
    Ok((image.ok_or(CodecError::Truncated)?, orientation.unwrap_or(Orientation::NoTransforms)))
}

/// Bytes of the end marker, with which every file ends here.
const END_BYTES: usize = 2;
/// Coded data of no meaning, without marker bytes.
const MORE_DATA: [u8; 24] =
    *b"\x5a\x13\xc7\x2e\x91\x0b\x6d\xe4\x38\xa2\x55\x1f\x8c\x49\xf6\x70\x03\xbd\x67\xda\x24\x9e\x41\xb8";

fn decoder_of(file: &[u8], is_strict: bool) -> JpegDecoder<ZCursor<&[u8]>> {
    let options = DecoderOptions::default()
        .set_strict_mode(is_strict)
        .set_max_width(usize::MAX)
        .set_max_height(usize::MAX);
    JpegDecoder::new_with_options(ZCursor::new(file), options)
}

fn broken(error: DecodeErrors) -> CodecError {
    CodecError::Broken(ImageError::Decoding(DecodingError::new(ImageFormat::Jpeg.into(), error)))
}
