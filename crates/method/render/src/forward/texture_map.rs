//! Textures sampled trilinearly with repetition.

use glam::Vec3;

use imaging::rounding::floor;
use imaging::srgb::LINEAR_OF_SRGB;
use imaging::{Image, Texture};

/// One texture and its halved versions.
pub struct TextureMap<'a> {
    levels: Vec<&'a Image>,
    /// Linear light of each sRGB byte.
    linear: &'static [f32; 256],
}

impl<'a> TextureMap<'a> {
    pub fn new(texture: &'a Texture) -> Self {
        let levels = std::iter::once(&**texture).chain(texture.halved()).collect();
        Self { levels, linear: &LINEAR_OF_SRGB }
    }

    /// Width and height of the full image, texels.
    pub fn side_texels(&self) -> glam::Vec2 {
        glam::Vec2::new(self.levels[0].width_px() as f32, self.levels[0].height_px() as f32)
    }

    /// Number of texels of the full image.
    pub fn area_texels(&self) -> f32 {
        (self.levels[0].width_px() * self.levels[0].height_px()) as f32
    }

    /// Linear-light color at `uv` (v = 0 at the bottom); `level` 0 = full size, 1 = halved, ...
    pub fn sample(&self, uv: glam::Vec2, level: f32) -> Vec3 {
        let last = self.levels.len() - 1;
        let level = level.clamp(0.0, last as f32);
        let fine = level as usize;
        let blend = level - fine as f32;
        let color = bilinear(self.levels[fine], self.linear, uv);
        if blend < 0.02 || fine == last {
            return color;
        }
        color.lerp(bilinear(self.levels[fine + 1], self.linear, uv), blend)
    }
}

#[inline]
fn bilinear(image: &Image, linear: &[f32; 256], uv: glam::Vec2) -> Vec3 {
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
        let rgb = &bytes[(y * width + x) * 4..][..3];
        Vec3::new(linear[rgb[0] as usize], linear[rgb[1] as usize], linear[rgb[2] as usize])
    };
    let upper = texel(x0, y0).lerp(texel(x1, y0), tx);
    let lower = texel(x0, y1).lerp(texel(x1, y1), tx);
    upper.lerp(lower, ty)
}
