//! Textures ready to sample: a pyramid of halved pictures (averaged in linear light), looked up
//! trilinearly with repetition.

use std::sync::Arc;

use glam::Vec3;

use super::light_map::floor;
use super::tone::{LINEAR_OF_SRGB, encode_srgb};
use crate::geometry::{Image, Texture};

/// One texture and its halved versions.
pub struct TextureMap {
    levels: Vec<Arc<Image>>,
}

impl TextureMap {
    pub fn new(texture: &Texture) -> Self {
        let mut levels = vec![texture.clone()];
        while let Some(last) = levels.last()
            && (last.width_px() > 1 || last.height_px() > 1)
        {
            levels.push(Arc::new(halved(last)));
        }
        Self { levels }
    }

    /// Number of texels of the full picture.
    pub fn area_texels(&self) -> f32 {
        (self.levels[0].width_px() * self.levels[0].height_px()) as f32
    }

    /// Linear-light color at `uv` (v = 0 at the bottom); `level` 0 = full size, 1 = halved, ...
    pub fn sample(&self, uv: glam::Vec2, level: f32) -> Vec3 {
        let last = self.levels.len() - 1;
        let level = level.clamp(0.0, last as f32);
        let fine = level as usize;
        let blend = level - fine as f32;
        let color = bilinear(&self.levels[fine], uv);
        if blend < 0.02 || fine == last {
            return color;
        }
        color.lerp(bilinear(&self.levels[fine + 1], uv), blend)
    }
}

#[inline]
fn bilinear(image: &Image, uv: glam::Vec2) -> Vec3 {
    let (width, height) = (image.width_px() as usize, image.height_px() as usize);
    let x = (uv.x - floor(uv.x) as f32) * width as f32 - 0.5;
    let y = (1.0 - (uv.y - floor(uv.y) as f32)) * height as f32 - 0.5;
    let (fx, fy) = (floor(x), floor(y));
    let (tx, ty) = (x - fx as f32, y - fy as f32);
    let wrap = |c: i32, size: usize| {
        if c < 0 {
            size - 1
        } else if c as usize >= size {
            0
        } else {
            c as usize
        }
    };
    let (x0, x1) = (wrap(fx, width), wrap(fx + 1, width));
    let (y0, y1) = (wrap(fy, height), wrap(fy + 1, height));
    let bytes = image.as_rgba();
    let texel = |x: usize, y: usize| {
        let at = (y * width + x) * 4;
        Vec3::new(
            LINEAR_OF_SRGB[bytes[at] as usize],
            LINEAR_OF_SRGB[bytes[at + 1] as usize],
            LINEAR_OF_SRGB[bytes[at + 2] as usize],
        )
    };
    let upper = texel(x0, y0).lerp(texel(x1, y0), tx);
    let lower = texel(x0, y1).lerp(texel(x1, y1), tx);
    upper.lerp(lower, ty)
}

fn halved(image: &Image) -> Image {
    let (width, height) = (image.width_px() as usize, image.height_px() as usize);
    let (half_width, half_height) = ((width / 2).max(1), (height / 2).max(1));
    let bytes = image.as_rgba();
    let mut rgba = Vec::with_capacity(half_width * half_height * 4);
    for y in 0..half_height {
        for x in 0..half_width {
            let (x0, y0) = ((2 * x).min(width - 1), (2 * y).min(height - 1));
            let (x1, y1) = ((2 * x + 1).min(width - 1), (2 * y + 1).min(height - 1));
            let corners = [(x0, y0), (x1, y0), (x0, y1), (x1, y1)].map(|(x, y)| (y * width + x) * 4);
            for channel in 0..3 {
                let sum: f32 = corners.iter().map(|at| LINEAR_OF_SRGB[bytes[at + channel] as usize]).sum();
                rgba.push(encode_srgb(0.25 * sum));
            }
            rgba.push(255);
        }
    }
    Image::from_rgba(half_width as u32, half_height as u32, rgba).expect("exactly width x height x 4 bytes")
}
