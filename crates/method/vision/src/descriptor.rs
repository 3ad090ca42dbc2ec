//! Feature extractor `Phi`, classical form: an image as a unit vector.
//!
//! The opaque part is cropped, squared and divided into patches. Each patch holds a histogram of gradient
//! orientations (Dalal and Triggs, "Histograms of oriented gradients", 2005; unsigned, votes by magnitude, linear
//! between bins) and a small color histogram in CIELAB. Orientation and color halves are normalized separately,
//! then weighted. Transparent pixels do not count, nor do gradients that touch one. It describes shape and color,
//! not meaning; its scores are not comparable with those of DINOv2.

use serde::{Deserialize, Serialize};

use super::pixels::Pixels;
use imaging::Image;
use imaging::sobel::sobel;

/// Settings of [`describe`].
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct DescriptorSettings {
    /// Patches along each side of the squared crop, 1..16. More is more sensitive to positions.
    pub patches: u32,
    /// Side of the squared crop, pixels, a multiple of `patches`. More is more sensitive to fine texture.
    pub side_px: u32,
    /// Orientation bins over half a turn, 4..18.
    pub orientations: u32,
    /// Share of the vector's squared length that is color, 0..1. More weighs color over shape.
    pub color_share: f64,
}

/// Color bins a patch: soft votes over lightness, green to red, blue to yellow, four each.
const COLOR_BINS: usize = 12;

/// The unit-length descriptor of an image; all zeros if nothing is opaque.
pub fn describe(image: &Image, settings: &DescriptorSettings) -> Vec<f32> {
    let patches = settings.patches.max(1) as usize;
    let side = (settings.side_px as usize).max(2 * patches);
    let bins = settings.orientations.max(2) as usize;
    let mut shape = vec![0.0_f32; patches * patches * bins];
    let mut color = vec![0.0_f32; patches * patches * COLOR_BINS];
    if let Some((crop, opaque)) = squared(image, side as u32) {
        let pixels = Pixels::new(&crop, side as u32);
        let lightness: Vec<f32> = pixels.lab.iter().map(|lab| lab[0]).collect();
        let (dx, dy) = sobel(&lightness, side, side);
        for (index, &inside) in opaque.iter().enumerate() {
            if !inside {
                continue;
            }
            let (x, y) = (index % side, index / side);
            let patch = (y * patches / side) * patches + x * patches / side;
            for (channel, value) in pixels.lab[index].iter().enumerate() {
                let (low, high) = if channel == 0 { (0.0, 100.0) } else { (-60.0, 60.0) };
                let place = 3.0 * ((value - low) / (high - low)).clamp(0.0, 1.0);
                let first = (place as usize).min(2);
                let rest = place - first as f32;
                color[patch * COLOR_BINS + 4 * channel + first] += 1.0 - rest;
                color[patch * COLOR_BINS + 4 * channel + first + 1] += rest;
            }
            let interior = x > 0
                && y > 0
                && x + 1 < side
                && y + 1 < side
                && [index - 1, index + 1, index - side, index + side].iter().all(|&k| opaque[k]);
            if interior {
                let strength = dx[index].hypot(dy[index]);
                let angle = dy[index].atan2(dx[index]).rem_euclid(std::f32::consts::PI);
                let place = angle / std::f32::consts::PI * bins as f32;
                let first = place as usize % bins;
                let rest = place - place.floor();
                shape[patch * bins + first] += strength * (1.0 - rest);
                shape[patch * bins + (first + 1) % bins] += strength * rest;
            }
        }
    }
    // Square roots limit the weight of one strong patch.
    shape.iter_mut().chain(&mut color).for_each(|v| *v = v.sqrt());
    let share = settings.color_share.clamp(0.0, 1.0) as f32;
    normalize(&mut shape, (1.0 - share).sqrt());
    normalize(&mut color, share.sqrt());
    shape.extend(color);
    normalize(&mut shape, 1.0);
    shape
}

fn normalize(vector: &mut [f32], to: f32) {
    let length = vector.iter().map(|v| v * v).sum::<f32>().sqrt();
    if length > 1e-12 {
        vector.iter_mut().for_each(|v| *v *= to / length);
    }
}

/// The opaque part, centered in a square, resized to `side` pixels, and its opacity flags.
fn squared(image: &Image, side: u32) -> Option<(Image, Vec<bool>)> {
    let mut bounds: Option<[u32; 4]> = None;
    for y in 0..image.height_px() {
        for x in 0..image.width_px() {
            if image.pixel(x, y)[3] >= 128 {
                let b = bounds.unwrap_or([x, y, x, y]);
                bounds = Some([b[0].min(x), b[1].min(y), b[2].max(x), b[3].max(y)]);
            }
        }
    }
    let [x0, y0, x1, y1] = bounds?;
    let extent = f64::from((x1 - x0 + 1).max(y1 - y0 + 1));
    let corner = [0.5 * (f64::from(x0 + x1 + 1) - extent), 0.5 * (f64::from(y0 + y1 + 1) - extent)];
    let step = extent / f64::from(side);
    let samples = step.ceil().clamp(1.0, 8.0) as u32;
    let mut crop = Image::filled(side, side, [255; 4]);
    let mut opaque = vec![false; (side * side) as usize];
    for y in 0..side {
        for x in 0..side {
            let (mut sum, mut count) = ([0_u32; 3], 0_u32);
            for k in 0..samples * samples {
                let at = |corner: f64, cell: u32, sub: u32| {
                    corner + (f64::from(cell) + (f64::from(sub) + 0.5) / f64::from(samples)) * step
                };
                let (px, py) = (at(corner[0], x, k % samples), at(corner[1], y, k / samples));
                let inside = px >= 0.0
                    && py >= 0.0
                    && px < f64::from(image.width_px())
                    && py < f64::from(image.height_px());
                if inside {
                    let p = image.pixel(px as u32, py as u32);
                    if p[3] >= 128 {
                        (0..3).for_each(|c| sum[c] += u32::from(p[c]));
                        count += 1;
                    }
                }
            }
            if 2 * count >= samples * samples {
                let [r, g, b] = sum.map(|s| (s / count) as u8);
                crop.set_pixel(x, y, [r, g, b, 255]);
                opaque[(y * side + x) as usize] = true;
            }
        }
    }
    Some((crop, opaque))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn settings() -> DescriptorSettings {
        DescriptorSettings { patches: 6, side_px: 96, orientations: 9, color_share: 0.5 }
    }

    fn striped(flip: bool, tint: [u8; 3]) -> Image {
        let mut image = Image::filled(120, 80, [0; 4]);
        for y in 10..70 {
            for x in 20..100 {
                let bright = (if flip { y } else { x }) / 8 % 2 == 0;
                let [r, g, b] = if bright { tint } else { tint.map(|c| c / 2) };
                image.set_pixel(x, y, [r, g, b, 255]);
            }
        }
        image
    }

    fn alike(a: &Image, b: &Image) -> f32 {
        let (a, b) = (describe(a, &settings()), describe(b, &settings()));
        a.iter().zip(&b).map(|(x, y)| x * y).sum()
    }

    #[test]
    fn similarity_decreases_with_color_and_direction() {
        let plain = striped(false, [200, 60, 40]);
        assert!((alike(&plain, &plain) - 1.0).abs() < 1e-5);
        let turned = alike(&plain, &striped(true, [200, 60, 40]));
        let recolored = alike(&plain, &striped(false, [40, 60, 200]));
        assert!(turned < 0.9 && recolored < 0.9, "{turned} {recolored}");
        assert!(describe(&Image::filled(9, 9, [10, 10, 10, 0]), &settings()).iter().all(|v| *v == 0.0));
    }

    #[test]
    fn transparent_pixels_do_not_affect_descriptor() {
        let plain = striped(false, [200, 60, 40]);
        let mut noisy = plain.clone();
        for y in 0..80 {
            for x in 0..120 {
                if plain.pixel(x, y)[3] == 0 {
                    noisy.set_pixel(x, y, [(x * 37 % 256) as u8, (y * 91 % 256) as u8, 77, 0]);
                }
            }
        }
        assert_eq!(describe(&plain, &settings()), describe(&noisy, &settings()));
    }
}
