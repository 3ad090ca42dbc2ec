//! Image degradation of rendered radiance: exposure, color, cartoon lines, blur, noise, JPEG.

use std::io::Cursor;

use glam::Vec3;
use image::codecs::jpeg::JpegEncoder;
use image::{ExtendedColorType, ImageFormat};
use rand::RngExt;

use super::sampling::{chance, uniform};
use imaging::Image;
use imaging::srgb::SrgbEncoder;
use runtime::seed::Rng;

/// Sampled degradation of one image.
#[derive(Clone, Debug)]
pub(super) struct ImageDegradation {
    /// Gain per channel, on linear radiance.
    gain: Vec3,
    /// Contrast on sRGB, around the mid-tone.
    contrast: f32,
    saturation: f32,
    gamma: f32,
    vignette: f32,
    pub cartoon: bool,
    levels: f32,
    blur_px: f32,
    noise: f32,
    jpeg_quality: u8,
}

impl ImageDegradation {
    /// `size_px`: longer side of the image, which scales the blur.
    pub(super) fn draw(size_px: u32, rng: &mut Rng) -> Self {
        let strong = chance(rng, 0.5);
        let spread = if strong { 1.0 } else { 0.35 };
        let gain = (1.04 + spread * uniform(rng, -0.2, 0.35)) as f32;
        let tint = (spread * uniform(rng, -0.07, 0.07)) as f32;
        let cartoon = chance(rng, 0.05);
        let blur = if chance(rng, 0.35) { uniform(rng, 0.3, 1.1) } else { 0.0 };
        Self {
            gain: gain * Vec3::new(1.0 + tint, 1.0, 1.0 - tint),
            contrast: (1.0 + spread * uniform(rng, -0.2, 0.3)) as f32,
            saturation: (1.0 + spread * uniform(rng, -0.4, 0.4)) as f32,
            gamma: (1.0 + spread * uniform(rng, -0.25, 0.25)) as f32,
            vignette: if !cartoon && chance(rng, 0.12) { uniform(rng, 0.1, 0.5) as f32 } else { 0.0 },
            cartoon,
            levels: uniform(rng, 4.0, 12.0).round() as f32,
            blur_px: (blur * f64::from(size_px) / 512.0) as f32,
            noise: if chance(rng, 0.4) { uniform(rng, 0.002, 0.03) as f32 } else { 0.0 },
            jpeg_quality: if chance(rng, 0.5) { rng.random_range(85..98) } else { rng.random_range(40..90) },
        }
    }

    /// Degrades linear radiance to JPEG bytes; `lines` marks the outline pixels of a cartoon.
    pub(super) fn apply(
        &self,
        light: &[Vec3],
        width: usize,
        lines: impl Fn(usize) -> bool,
        rng: &mut Rng,
    ) -> Vec<u8> {
        let height = light.len() / width.max(1);
        let mut pixels: Vec<Vec3> = (0..light.len())
            .map(|k| {
                let (x, y) = (k % width, k / width);
                let (dx, dy) = (x as f32 / width as f32 - 0.5, y as f32 / height as f32 - 0.5);
                let shade = 1.0 - self.vignette * 2.0 * (dx * dx + dy * dy);
                self.toned(light[k] * shade)
            })
            .collect();
        if self.cartoon {
            for (k, pixel) in pixels.iter_mut().enumerate() {
                *pixel =
                    if lines(k) { Vec3::splat(0.06) } else { (*pixel * self.levels).round() / self.levels };
            }
        }
        if self.blur_px > 0.0 {
            pixels = blurred(&pixels, width, self.blur_px);
        }
        let mut rgb = Vec::with_capacity(3 * pixels.len());
        for pixel in &pixels {
            for c in pixel.to_array() {
                // The sum of three uniform draws approximates a normal one.
                let grain = if self.noise > 0.0 {
                    self.noise * 2.0 * (0..3).map(|_| rng.random_range(-0.5..0.5_f32)).sum::<f32>()
                } else {
                    0.0
                };
                rgb.push(((c + grain).clamp(0.0, 1.0) * 255.0 + 0.5) as u8);
            }
        }
        let mut bytes = Vec::new();
        JpegEncoder::new_with_quality(&mut bytes, self.jpeg_quality)
            .encode(&rgb, width as u32, height as u32, ExtendedColorType::Rgb8)
            .expect("the buffer matches the size and memory accepts every write");
        bytes
    }

    /// Maps linear radiance to sRGB 0..1.
    fn toned(&self, light: Vec3) -> Vec3 {
        let srgb = SrgbEncoder::default();
        let lit = light * self.gain;
        let encoded = Vec3::new(lit.x, lit.y, lit.z).to_array().map(|c| f32::from(srgb.byte(c)) / 255.0);
        let curved = Vec3::from(encoded.map(|c| c.powf(self.gamma)));
        let gray = curved.dot(Vec3::new(0.3, 0.59, 0.11));
        let colored = Vec3::splat(gray) + self.saturation * (curved - Vec3::splat(gray));
        // Contrast pivots at a light gray, so that white stays white.
        (Vec3::splat(0.75) + self.contrast * (colored - Vec3::splat(0.75))).clamp(Vec3::ZERO, Vec3::ONE)
    }
}

/// Decodes JPEG bytes that this module wrote.
pub(super) fn decoded(jpeg: &[u8]) -> Image {
    let read = image::ImageReader::with_format(Cursor::new(jpeg), ImageFormat::Jpeg).decode();
    let image = read.expect("what was just encoded decodes").to_rgba8();
    let (width, height) = image.dimensions();
    Image::from_rgba(width, height, image.into_raw()).expect("four bytes a pixel")
}

/// Gaussian blur of standard deviation `sigma_px`, edges repeated.
fn blurred(pixels: &[Vec3], width: usize, sigma_px: f32) -> Vec<Vec3> {
    let reach = (2.5 * sigma_px).ceil().max(1.0) as isize;
    let weights: Vec<f32> = (-reach..=reach).map(|k| (-0.5 * (k as f32 / sigma_px).powi(2)).exp()).collect();
    let total: f32 = weights.iter().sum();
    let height = pixels.len() / width;
    let pass = |from: &[Vec3], at: &dyn Fn(isize, isize, isize) -> usize| -> Vec<Vec3> {
        (0..from.len())
            .map(|k| {
                let (x, y) = ((k % width) as isize, (k / width) as isize);
                (-reach..=reach).zip(&weights).map(|(d, w)| *w * from[at(x, y, d)]).sum::<Vec3>() / total
            })
            .collect()
    };
    let clamp = |c: isize, size: usize| c.clamp(0, size as isize - 1) as usize;
    let rows = pass(pixels, &|x, y, d| y as usize * width + clamp(x + d, width));
    pass(&rows, &|x, y, d| clamp(y + d, height) * width + x as usize)
}
