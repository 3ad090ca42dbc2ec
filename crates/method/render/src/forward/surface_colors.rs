//! Own colors of surfaces: the materials of a scene's objects with their textures, mapped for sampling.

use rayon::prelude::*;

use super::relief::slope;
use super::shade::Surface;
use super::shading_materials::{ShadingMaterial, ShadingMaterials};
use super::texture_map::TextureMap;
use crate::RenderObject;
use glam::{Vec3, Vec3A};

/// Materials of all objects with their textures. They depend on neither view nor light.
pub struct SurfaceColors<'a> {
    pub materials: ShadingMaterials<'a>,
    textures: Vec<TextureMap<'a>>,
}

impl<'a> SurfaceColors<'a> {
    /// Lists the materials of the objects and halves their textures.
    pub fn new(objects: &[RenderObject<'a>]) -> Self {
        let materials = ShadingMaterials::new(objects);
        let textures = materials.textures.par_iter().map(|texture| TextureMap::new(texture)).collect();
        Self { materials, textures }
    }

    /// Material of a surface point.
    #[inline]
    pub fn material(&self, s: &Surface) -> &ShadingMaterial {
        self.materials.material(s.material)
    }

    /// Linear color of a surface point, its texture filtered to the size of the pixel.
    pub fn albedo(&self, s: &Surface, pixel_size_m: f32) -> Vec3 {
        let material = self.material(s);
        let Some(texture) = material.texture else { return material.base_color };
        let texture = &self.textures[texture];
        material.base_color * texture.sample(s.uv, level(texture, s, pixel_size_m))
    }

    /// Unit normal of a surface point with the relief of its material, filtered to the size of the pixel.
    pub fn normal(&self, s: &Surface, pixel_size_m: f32) -> Vec3A {
        let material = self.material(s);
        let Some(texture) = material.texture.filter(|_| material.relief > 0.0) else { return s.normal };
        let texture = &self.textures[texture];
        let slope = slope(texture, material.relief, s.uv, level(texture, s, pixel_size_m));
        s.texture_axes.leaned(s.normal, slope)
    }
}

/// Level of the mipmap for a pixel of that size.
fn level(texture: &TextureMap, s: &Surface, pixel_size_m: f32) -> f32 {
    // Bounded: at grazing angles the isotropic filter would blur the texture away.
    let facing = s.flat_normal.dot(s.toward_eye).max(0.05);
    let texels = s.uv_density * texture.area_texels() * pixel_size_m * pixel_size_m / facing;
    // Half the logarithm of the area is that of the side; a quarter of a level keeps the texture sharp.
    0.5 * texels.max(1.0).log2() - 0.25
}
