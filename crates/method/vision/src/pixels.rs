//! Working copy of an image: reduced, opaque, in CIELAB and in linear light.

use glam::DVec2;

use geometry::Rgb;
use imaging::{Image, Mask};
use render::annotate::fitted;

/// Row-major color planes.
pub(crate) struct Pixels {
    pub width: usize,
    pub height: usize,
    /// Pixels of the copy per pixel of the image, at most 1.
    pub scale: f64,
    /// The copy itself.
    pub copy: Image,
    /// CIELAB (D65): lightness 0..100, a, b.
    pub lab: Vec<[f32; 3]>,
    /// Natural logarithm of the linear light of each channel, floored at -7.
    pub log_light: Vec<[f32; 3]>,
}

impl Pixels {
    /// Reduces the image so that its longer side is at most `work_px`; transparent parts become white.
    pub fn new(image: &Image, work_px: u32) -> Self {
        let longer = image.width_px().max(image.height_px()).max(1);
        let copy = if longer > work_px { fitted(image, work_px, work_px) } else { image.clone() };
        let (width, height) = (copy.width_px() as usize, copy.height_px() as usize);
        let linear = LinearLight::new();
        let (mut lab, mut log_light) =
            (Vec::with_capacity(width * height), Vec::with_capacity(width * height));
        for p in copy.as_rgba().chunks_exact(4) {
            let light = linear.of([p[0], p[1], p[2], p[3]]);
            lab.push(lab_of(light));
            log_light.push(light.map(|c| c.max(9e-4).ln()));
        }
        let scale = width as f64 / f64::from(image.width_px().max(1));
        Self { width, height, scale, copy, lab, log_light }
    }

    pub fn len(&self) -> usize {
        self.width * self.height
    }

    /// Column and row of an index.
    pub fn xy(&self, index: usize) -> (usize, usize) {
        (index % self.width, index / self.width)
    }

    /// Index of the pixel that contains a position, if it lies inside.
    pub fn index_at(&self, p: DVec2) -> Option<usize> {
        let inside = p.x >= 0.0 && p.y >= 0.0 && p.x < self.width as f64 && p.y < self.height as f64;
        inside.then(|| p.y as usize * self.width + p.x as usize)
    }

    /// A mask of the copy at the size of the image.
    pub fn upscale_mask(&self, bits: &[bool], width_px: u32, height_px: u32) -> Mask {
        let x_of = |x: u32| (((f64::from(x) + 0.5) * self.scale) as usize).min(self.width - 1);
        let rows = self.height as f64 / f64::from(height_px);
        let y_of = |y: u32| (((f64::from(y) + 0.5) * rows) as usize).min(self.height - 1);
        Mask::from_fn(width_px, height_px, |x, y| bits[y_of(y) * self.width + x_of(x)])
    }
}

/// Linear light of sRGB bytes.
pub(crate) struct LinearLight(Vec<f32>);

impl LinearLight {
    pub fn new() -> Self {
        Self((0..256).map(|v| linear(v as f32 / 255.0)).collect())
    }

    /// Linear light of a pixel on white.
    pub fn of(&self, [r, g, b, alpha]: [u8; 4]) -> [f32; 3] {
        let opacity = f32::from(alpha) / 255.0;
        let on_white = |level: u8| opacity * self.0[usize::from(level)] + 1.0 - opacity;
        [on_white(r), on_white(g), on_white(b)]
    }
}

fn linear(c: f32) -> f32 {
    if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
}

/// CIELAB of linear sRGB light, white point D65.
pub(crate) fn lab_of([r, g, b]: [f32; 3]) -> [f32; 3] {
    let x = (0.4124 * r + 0.3576 * g + 0.1805 * b) / 0.9505;
    let y = 0.2126 * r + 0.7152 * g + 0.0722 * b;
    let z = (0.0193 * r + 0.1192 * g + 0.9505 * b) / 1.089;
    let f = |t: f32| if t > 0.008856 { t.cbrt() } else { 7.787 * t + 16.0 / 116.0 };
    let (fx, fy, fz) = (f(x), f(y), f(z));
    [116.0 * fy - 16.0, 500.0 * (fx - fy), 200.0 * (fy - fz)]
}

/// CIELAB of a color.
pub(crate) fn lab_of_srgb(color: Rgb) -> [f32; 3] {
    lab_of(color.to_linear())
}

/// Euclidean distance of two colors.
pub(crate) fn distance(a: [f32; 3], b: [f32; 3]) -> f32 {
    ((a[0] - b[0]).powi(2) + (a[1] - b[1]).powi(2) + (a[2] - b[2]).powi(2)).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn upscaled_mask_keeps_its_position() {
        let mut image = Image::filled(200, 100, [255; 4]);
        (100..140).for_each(|x| (40..60).for_each(|y| image.set_pixel(x, y, [0, 0, 0, 255])));
        let pixels = Pixels::new(&image, 50);
        assert_eq!((pixels.copy.width_px(), pixels.scale), (50, 0.25));
        let dark: Vec<bool> = pixels.lab.iter().map(|lab| lab[0] < 50.0).collect();
        assert_eq!(pixels.upscale_mask(&dark, 200, 100).bbox_px(), Some([100, 40, 140, 60]));
    }

    #[test]
    fn white_gray_and_red_have_reference_lab_values() {
        let lab = |rgb: [u8; 3]| Pixels::new(&Image::filled(4, 4, [rgb[0], rgb[1], rgb[2], 255]), 64).lab[0];
        assert!(distance(lab([255, 255, 255]), [100.0, 0.0, 0.0]) < 0.2);
        assert!(distance(lab([119, 119, 119]), [50.0, 0.0, 0.0]) < 0.3);
        assert!(distance(lab([255, 0, 0]), [53.2, 80.1, 67.2]) < 0.5);
    }
}
