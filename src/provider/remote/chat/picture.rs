//! Pictures as they are sent: small enough, without transparency, as PNG.

use bytes::Bytes;
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder};

use crate::geometry::Image;
use crate::render::overlay::fitted;

/// The picture as a PNG file whose longer side is at most `longest_px`; larger ones are reduced, smaller ones stay.
/// Same picture, same bytes.
pub fn sent(picture: &Image, longest_px: u32) -> Result<Bytes, image::ImageError> {
    let reduced;
    let picture = match picture.width_px().max(picture.height_px()) > longest_px {
        true => {
            reduced = fitted(picture, longest_px, longest_px);
            &reduced
        }
        false => picture,
    };
    let rgb: Vec<u8> =
        picture.as_rgba().chunks_exact(4).flat_map(|pixel| [pixel[0], pixel[1], pixel[2]]).collect();
    let mut bytes = Vec::new();
    PngEncoder::new_with_quality(&mut bytes, CompressionType::Default, FilterType::Adaptive).write_image(
        &rgb,
        picture.width_px(),
        picture.height_px(),
        ExtendedColorType::Rgb8,
    )?;
    Ok(bytes.into())
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
}
