//! Images inside the page: downscaled JPEG as data URIs, so that the page shows them without other files. A dozen
//! objects take about half a megabyte. The lossless images lie under `preview/`.

use std::collections::BTreeMap;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use image::codecs::jpeg::JpegEncoder;
use image::{ExtendedColorType, ImageEncoder};
use rayon::prelude::*;

use crate::Images;
use imaging::Image;
use imaging::codec::decode_png;

/// Widths of embedded images, pixels.
const HERO_PX: u32 = 960;
const VIEW_PX: u32 = 480;
const BESIDE_PX: u32 = 1460;
const THUMBNAIL_PX: u32 = 128;

/// JPEG quality, 1..100. Compression artifacts are invisible at these sizes.
const QUALITY: u8 = 82;

/// A data URI for an `src` attribute, with the image's size in pixels.
pub struct Embedded {
    pub uri: String,
    pub width_px: u32,
    pub height_px: u32,
}

/// The images of the page; absent images are `None` or left out.
pub struct EmbeddedImages {
    pub hero: Option<Embedded>,
    pub beside: Option<Embedded>,
    pub top: Option<Embedded>,
    /// By the side's name.
    pub sides: Vec<(String, Embedded)>,
    /// By the body's name.
    pub thumbnails: BTreeMap<String, Embedded>,
}

impl EmbeddedImages {
    /// Converts all images in parallel.
    pub fn of(images: &Images) -> Self {
        let side = |(name, png): &(String, Vec<u8>)| Some((name.clone(), embedded(png, VIEW_PX)?));
        let thumbnail = |(name, png): (&String, &Vec<u8>)| Some((name.clone(), embedded(png, THUMBNAIL_PX)?));
        let ((hero, (beside, top)), (sides, thumbnails)) = rayon::join(
            || {
                rayon::join(
                    || embedded(&images.hero_png, HERO_PX),
                    || {
                        rayon::join(
                            || embedded(&images.beside_png, BESIDE_PX),
                            || embedded(&images.top_png, VIEW_PX),
                        )
                    },
                )
            },
            || {
                rayon::join(
                    || images.sides_png.par_iter().filter_map(side).collect(),
                    || images.thumbnails.par_iter().filter_map(thumbnail).collect(),
                )
            },
        );
        Self { hero, beside, top, sides, thumbnails }
    }
}

/// The PNG as a JPEG of at most `max_width_px`; `None` if the bytes are not an image.
fn embedded(png: &[u8], max_width_px: u32) -> Option<Embedded> {
    let image = decode_png(png).ok()?;
    // Box filter over whole pixels: no ringing.
    let factor = image.width_px().div_ceil(max_width_px).max(1);
    let (width_px, height_px) = (image.width_px() / factor, image.height_px() / factor);
    if width_px == 0 || height_px == 0 {
        return None;
    }
    let rgb = reduced(&image, factor as usize);
    let mut jpeg = Vec::new();
    JpegEncoder::new_with_quality(&mut jpeg, QUALITY)
        .write_image(&rgb, width_px, height_px, ExtendedColorType::Rgb8)
        .ok()?;
    Some(Embedded { uri: format!("data:image/jpeg;base64,{}", STANDARD.encode(jpeg)), width_px, height_px })
}

/// Mean colors of square blocks of `side` pixels, composited on white, RGB. What is left at the right and below is cut.
fn reduced(image: &Image, side: usize) -> Vec<u8> {
    let (width, height) = (image.width_px() as usize / side, image.height_px() as usize / side);
    let count = (side * side) as u32;
    let on_white = |level: u8, alpha: u32| (u32::from(level) * alpha + 255 * (255 - alpha) + 127) / 255;
    let mut rgb = Vec::with_capacity(width * height * 3);
    let mut sums = vec![[0_u32; 3]; width];
    for rows in image.as_rgba().chunks_exact(4 * image.width_px() as usize * side).take(height) {
        sums.fill([0; 3]);
        for row in rows.chunks_exact(4 * image.width_px() as usize) {
            for (sum, pixels) in sums.iter_mut().zip(row.chunks_exact(4 * side)) {
                for pixel in pixels.chunks_exact(4) {
                    let alpha = u32::from(pixel[3]);
                    sum.iter_mut().zip(pixel).for_each(|(sum, level)| *sum += on_white(*level, alpha));
                }
            }
        }
        rgb.extend(sums.iter().flatten().map(|sum| ((sum + count / 2) / count) as u8));
    }
    rgb
}

#[cfg(test)]
mod tests {
    use super::*;
    use imaging::codec::{decode_image, encode_png};

    #[test]
    fn embedded_image_fits_the_width_and_keeps_its_colors() {
        let mut image = Image::filled(301, 200, [200, 40, 30, 255]);
        (0..200).for_each(|y| (0..150).for_each(|x| image.set_pixel(x, y, [0, 0, 0, 0])));
        let found = embedded(&encode_png(&image), 160).expect("a picture");
        assert_eq!((found.width_px, found.height_px), (150, 100));
        let base64 = found.uri.strip_prefix("data:image/jpeg;base64,").expect("a data URI");
        let back = decode_image(&STANDARD.decode(base64).expect("base64"), u64::MAX).expect("a JPEG");
        let near =
            |found: [u8; 4], wanted: [u8; 3]| found.iter().zip(wanted).all(|(a, b)| a.abs_diff(b) < 12);
        assert!(near(back.pixel(20, 50), [255; 3]) && near(back.pixel(120, 50), [200, 40, 30]));
        assert!(embedded(b"no picture", 160).is_none());
    }

    #[test]
    fn reduced_pixels_are_means_of_blocks_on_white() {
        let mut image = Image::filled(11, 7, [0; 4]);
        let bytes = image.as_rgba_mut();
        bytes.iter_mut().enumerate().for_each(|(k, byte)| *byte = (k * 89 % 256) as u8);
        for side in [1, 2, 3] {
            let mean = |x: u32, y: u32, channel: usize| {
                let pixels = (0..side * side).map(|k| image.pixel(x * side + k % side, y * side + k / side));
                let on_white = |p: [u8; 4]| {
                    let alpha = u32::from(p[3]);
                    (u32::from(p[channel]) * alpha + 255 * (255 - alpha) + 127) / 255
                };
                ((pixels.map(on_white).sum::<u32>() + side * side / 2) / (side * side)) as u8
            };
            let (width, height) = (11 / side, 7 / side);
            let places = (0..width * height).map(|k| (k % width, k / width));
            let expected: Vec<u8> = places.flat_map(|(x, y)| [0, 1, 2].map(|c| mean(x, y, c))).collect();
            assert_eq!(reduced(&image, side as usize), expected, "blocks of {side}");
        }
    }
}
