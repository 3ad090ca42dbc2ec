//! Images from outside: PNG, JPEG or WebP by their first bytes. The media type of a data URI must not contradict these
//! (`api::data_uri`); that of a file in a form is not read.
//!
//! Dimensions are read from the header and checked before anything is decoded; then the whole image is
//! decoded once under memory limits, so that a broken file is refused here and not in a job. The same holds for the
//! depth image beside an image.

use std::io::Cursor;

use bytes::Bytes;
use exif::{Exif, In, Tag};
use imaging::DepthImage;
use imaging::codec::{
    CodecError, ImageHeader, MAX_SCENE_SIDE_RATIO, MAX_SIDE_PX, MIN_SCENE_SIDE_PX, read_header, verify_image,
};

use crate::problem::{Problem, ProblemType};
use store::Digest;

/// An image that was checked, but not stored.
#[derive(Debug)]
pub struct CheckedImage {
    pub bytes: Bytes,
    pub digest: Digest,
    pub media_type: &'static str,
    /// Horizontal, of the upright image, as its EXIF data state it.
    pub field_of_view_rad: Option<f64>,
    /// Width and height of the upright image.
    pub upright_px: [u32; 2],
}

/// A depth image that was checked, but not stored.
#[derive(Debug)]
pub struct CheckedDepth {
    pub bytes: Bytes,
    pub digest: Digest,
}

/// Pixels of one block of [`pixel_blocks`].
pub const PIXELS_PER_BLOCK: u64 = 1024;

/// Number of blocks of pixels that an image declares; at least 1. Memory of a decoder grows with them.
pub fn pixel_blocks(bytes: &[u8]) -> u32 {
    let pixels =
        read_header(bytes).map_or(0, |header| u64::from(header.width_px) * u64::from(header.height_px));
    u32::try_from(pixels.div_ceil(PIXELS_PER_BLOCK)).unwrap_or(u32::MAX).max(1)
}

/// Checks an image of at most so many bytes and pixels. Decodes it, so it blocks.
///
/// # Errors
///
/// A [`Problem`] that says what to change.
pub fn check(bytes: Bytes, max_bytes: usize, max_pixels: u64) -> Result<CheckedImage, Problem> {
    if bytes.len() > max_bytes {
        return Err(Problem::new(
            ProblemType::PayloadTooLarge,
            "image_too_large",
            format!("the image has {} bytes; send one of at most {max_bytes}", bytes.len()),
        ));
    }
    inspect(bytes, max_pixels)
}

fn inspect(bytes: Bytes, max_pixels: u64) -> Result<CheckedImage, Problem> {
    let ImageHeader { media_type, width_px: width, height_px: height } =
        read_header(&bytes).map_err(refused)?;
    if u64::from(width) * u64::from(height) > max_pixels {
        return Err(invalid(
            "image_dimensions",
            format!("the image is {width} x {height}; send one of at most {max_pixels} pixels"),
        ));
    }
    if width.max(height) > MAX_SIDE_PX {
        return Err(invalid(
            "image_dimensions",
            format!("the image is {width} x {height}; each side may have at most {MAX_SIDE_PX} pixels"),
        ));
    }
    if width.min(height) < MIN_SCENE_SIDE_PX {
        return Err(invalid(
            "image_dimensions",
            format!(
                "the image is {width} x {height}; each side must have at least {MIN_SCENE_SIDE_PX} pixels"
            ),
        ));
    }
    if width.max(height) > MAX_SCENE_SIDE_RATIO * width.min(height) {
        return Err(invalid(
            "image_dimensions",
            format!(
                "the image is {width} x {height}; its longer side may be at most {MAX_SCENE_SIDE_RATIO} times \
                 its shorter one"
            ),
        ));
    }
    verify_image(&bytes, max_pixels.saturating_mul(12)).map_err(refused)?;
    let exif = exif::Reader::new().read_from_container(&mut Cursor::new(&bytes)).ok();
    let field_of_view_rad = exif.as_ref().and_then(|exif| field_of_view_rad(exif, width, height));
    let upright_px = if exif.as_ref().is_some_and(is_turned) { [height, width] } else { [width, height] };
    Ok(CheckedImage { digest: Digest::of(&bytes), bytes, media_type, field_of_view_rad, upright_px })
}

/// Checks the depth image beside an image, of at most so many bytes and pixels. Decodes it, so it blocks.
///
/// # Errors
///
/// A [`Problem`] that says what to change.
pub fn check_depth(
    bytes: Bytes,
    image: &CheckedImage,
    max_bytes: usize,
    max_pixels: u64,
) -> Result<CheckedDepth, Problem> {
    if bytes.len() > max_bytes {
        return Err(Problem::new(
            ProblemType::PayloadTooLarge,
            "depth_too_large",
            format!("the depth image has {} bytes; send one of at most {max_bytes}", bytes.len()),
        ));
    }
    let depth = DepthImage::decode_png(&bytes, max_pixels)
        .map_err(|error| invalid("depth_unreadable", format!("the depth image cannot be used: {error}")))?;
    let [width, height] = image.upright_px;
    if !depth.has_aspect_of(width, height) {
        let (own_width, own_height) = (depth.width_px(), depth.height_px());
        return Err(invalid(
            "depth_dimensions",
            format!(
                "the depth image is {own_width} x {own_height} and the upright image {width} x {height}; send depths of \
                 the same view, with the same ratio of the sides"
            ),
        ));
    }
    Ok(CheckedDepth { digest: Digest::of(&bytes), bytes })
}

/// Diagonal of the frame that "35 mm" focal lengths refer to, millimeters (CIPA DCG-001).
const FULL_FRAME_DIAGONAL_MM: f64 = 43.27;

/// The horizontal field of view of the upright image by its EXIF data: the focal length in 35 mm film (Exif 2.32, tag
/// 0xA405). `None` where it is missing, or the stored size says that the image was cut.
fn field_of_view_rad(exif: &Exif, width_px: u32, height_px: u32) -> Option<f64> {
    let number = |tag: Tag| exif.get_field(tag, In::PRIMARY)?.value.get_uint(0);
    let focal_mm = number(Tag::FocalLengthIn35mmFilm).filter(|focal_mm| (8..2000).contains(focal_mm))?;
    let (width, height) = (f64::from(width_px), f64::from(height_px));
    if let (Some(x), Some(y)) = (number(Tag::PixelXDimension), number(Tag::PixelYDimension)) {
        let stored = f64::from(x.max(y)) / f64::from(x.min(y).max(1));
        if (stored / (width.max(height) / width.min(height)) - 1.0).abs() > MAX_ASPECT_CHANGE {
            return None;
        }
    }
    let focal_px = f64::from(focal_mm) / FULL_FRAME_DIAGONAL_MM * width.hypot(height);
    let across = if is_turned(exif) { height } else { width };
    Some(2.0 * (0.5 * across / focal_px).atan())
}

/// Whether the upright image is turned by a quarter: orientations from 5 on.
fn is_turned(exif: &Exif) -> bool {
    let orientation = exif.get_field(Tag::Orientation, In::PRIMARY).and_then(|field| field.value.get_uint(0));
    orientation.is_some_and(|orientation| orientation >= 5)
}

/// Largest relative change of the aspect of an image that is not taken for a cut, by rounding its sides.
const MAX_ASPECT_CHANGE: f64 = 0.01;

fn refused(error: CodecError) -> Problem {
    match error {
        CodecError::UnknownFormat => Problem::new(
            ProblemType::UnsupportedMediaType,
            "image_format",
            "the image is no PNG, JPEG or WebP (its first bytes decide); convert it to one of them",
        ),
        CodecError::Animated => {
            invalid("image_animated", "the image is animated; send a still image".to_owned())
        }
        CodecError::Broken(error) => unreadable(&error.to_string()),
        CodecError::Truncated => unreadable("the file ends early"),
        error @ CodecError::TooLarge { .. } => unreadable(&error.to_string()),
    }
}

/// An image whose bytes cannot be decoded.
pub fn unreadable(reason: &str) -> Problem {
    let reason: String = reason.chars().take(200).collect();
    invalid("image_unreadable", format!("the image is damaged ({reason}); save it again and send that"))
}

fn invalid(code: &'static str, detail: String) -> Problem {
    Problem::new(ProblemType::InvalidRequest, code, detail)
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use image::ImageFormat;

    use super::*;

    fn png(width: u32, height: u32) -> Vec<u8> {
        let mut bytes = Cursor::new(Vec::new());
        image::RgbImage::new(width, height).write_to(&mut bytes, ImageFormat::Png).expect("encodes");
        bytes.into_inner()
    }

    /// A JPEG with numbers in its EXIF data.
    fn photograph(width: u32, height: u32, numbers: &[(Tag, u16)]) -> Vec<u8> {
        let mut jpeg = Cursor::new(Vec::new());
        image::RgbImage::new(width, height).write_to(&mut jpeg, ImageFormat::Jpeg).expect("encodes");
        let field = |&(tag, number): &(Tag, u16)| exif::Field {
            tag,
            ifd_num: In::PRIMARY,
            value: exif::Value::Short(vec![number]),
        };
        let fields: Vec<exif::Field> = numbers.iter().map(field).collect();
        let mut writer = exif::experimental::Writer::new();
        fields.iter().for_each(|field| writer.push_field(field));
        let mut data = Cursor::new(Vec::new());
        writer.write(&mut data, false).expect("writes");
        let data = [b"Exif\0\0", &data.into_inner()[..]].concat();
        let length = u16::try_from(data.len() + 2).expect("a short segment").to_be_bytes();
        let jpeg = jpeg.into_inner();
        [&jpeg[..2], &[0xff, 0xe1], &length, &data, &jpeg[2..]].concat()
    }

    #[test]
    fn field_of_view_follows_from_exif_data() {
        let known = |width, height, numbers: &[(Tag, u16)]| {
            let bytes = photograph(width, height, numbers);
            inspect(bytes.into(), 1_000_000).expect("fine").field_of_view_rad
        };
        // 36 mm of a full frame before a lens of 26 mm.
        let wide = 2.0 * (18.0_f64 / 26.0).atan();
        let found = known(600, 400, &[(Tag::FocalLengthIn35mmFilm, 26)]).expect("stated");
        assert!((found - wide).abs() < 1e-3, "{found}");
        let sides = [(Tag::PixelXDimension, 3000), (Tag::PixelYDimension, 2000)];
        let upright = [(Tag::FocalLengthIn35mmFilm, 26), (Tag::Orientation, 6), sides[0], sides[1]];
        let found = known(600, 400, &upright).expect("stated");
        assert!((found - 2.0 * (12.0_f64 / 26.0).atan()).abs() < 1e-3, "{found}");
        assert_eq!(known(400, 400, &[upright[0], sides[0], sides[1]]), None, "the image was cut");
        assert_eq!(known(600, 400, &[(Tag::FocalLengthIn35mmFilm, 0)]), None, "0 is unknown");
        assert_eq!(known(600, 400, &[(Tag::Orientation, 1)]), None);
    }

    #[test]
    fn depths_have_the_aspect_of_the_upright_image() {
        let turned = photograph(320, 240, &[(Tag::Orientation, 6)]);
        let turned = inspect(turned.into(), 1_000_000).expect("fine");
        assert_eq!(turned.upright_px, [240, 320]);
        let level = inspect(png(320, 240).into(), 1_000_000).expect("fine");
        let depth = |width_px: u32, height_px: u32| -> Bytes {
            let depths_mm = vec![900; (width_px * height_px) as usize];
            DepthImage::new(width_px, height_px, depths_mm).expect("a depth a pixel").encode_png().into()
        };
        let code = |bytes: Bytes, image: &CheckedImage, max_bytes: usize| {
            check_depth(bytes, image, max_bytes, 100_000)
                .map_or_else(|problem| problem.own_code(), |_| "fine")
        };
        assert_eq!(code(depth(160, 120), &level, 10_000), "fine", "half the size");
        assert_eq!(code(depth(160, 120), &turned, 10_000), "depth_dimensions");
        assert_eq!(code(depth(120, 160), &turned, 10_000), "fine");
        assert_eq!(code(depth(160, 120), &level, 20), "depth_too_large");
        assert_eq!(code(depth(640, 480), &level, 1_000_000), "depth_unreadable", "too many pixels");
        assert_eq!(code(png(320, 240).into(), &level, 10_000), "depth_unreadable", "colors");
        let cut = depth(160, 120);
        assert_eq!(code(cut.slice(..cut.len() / 2), &level, 10_000), "depth_unreadable");
    }

    fn code(bytes: Vec<u8>, max_pixels: u64) -> &'static str {
        inspect(bytes.into(), max_pixels).map_or_else(|problem| problem.own_code(), |_| "fine")
    }

    #[test]
    fn valid_images_pass_and_invalid_ones_get_their_code() {
        let good = png(200, 160);
        assert_eq!(code(good.clone(), 40_000), "fine");
        assert_eq!(code(png(200, 159), 40_000), "image_dimensions");
        assert_eq!(code(png(1_290, 160), 1_000_000), "image_dimensions");
        assert_eq!(code(good.clone(), 3_000), "image_dimensions");
        assert_eq!(code(png(8, 200), 10_000), "image_dimensions");
        assert_eq!(code(png(16_500, 32), 10_000_000), "image_dimensions");
        assert_eq!(code(good[..good.len() / 2].to_vec(), 40_000), "image_unreadable");
        assert_eq!(code(b"GIF89a................".to_vec(), 10_000), "image_format");
        assert_eq!(code(b"<svg onload=alert(1)>".to_vec(), 10_000), "image_format");
        assert_eq!(code(b"\xff\xd8\xff\xe0 no jpeg at all".to_vec(), 10_000), "image_unreadable");
        assert_eq!(code(Vec::new(), 10_000), "image_format");
        let moving = b"RIFF\x5a\0\0\0WEBPVP8X\x0a\0\0\0\x12\0\0\0\x3f\0\0\x3f\0\0";
        assert_eq!(code(moving.to_vec(), 10_000), "image_animated");

        // A header that claims 60,000 x 60,000 pixels is refused before anything of it is decoded.
        let mut bomb = good;
        bomb[16..24].copy_from_slice(&[0, 0, 0xEA, 0x60, 0, 0, 0xEA, 0x60]);
        assert_ne!(code(bomb, 64_000_000), "fine");
    }
}
