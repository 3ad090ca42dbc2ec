//! Colors of objects at some pixels of a small image, for several sets of materials at once.
//!
//! One rasterization, one intersection and one lighting serve all sets: only base colors and textures differ. Other
//! pixels, and the backdrop, are not shaded. Everything runs on the calling thread, because callers
//! compare many such images in parallel. A color is that of [`super::bands::render`] with one sample for each pixel.

use glam::Vec3;

use super::prepare::{ScreenTriangle, ViewGeometry};
use super::projection::Projection;
use super::raster::{Band, NOTHING};
use super::scene_buffers::{SceneBuffers, TriangleFilter};
use super::shade::{Shader, Surroundings};
use super::shade_band::{PixelLight, grain};
use super::surface_colors::SurfaceColors;
use super::tone_map::ToneMapper;
use crate::View;
use crate::object_colors::PixelColors;

/// Colors at the pixels where `is_wanted` is set, row by row from the top. `surroundings` have no sky shadows.
pub fn shaded<const SETS: usize>(
    scene_buffers: &SceneBuffers,
    surroundings: &Surroundings,
    sets: [&SurfaceColors; SETS],
    view: &View,
    is_wanted: &[bool],
) -> [PixelColors; SETS] {
    let projection = Projection::new(view, 1);
    let (width, height) = (projection.width_px, projection.height_px);
    let mut colors = [(); SETS].map(|()| vec![None; width * height]);
    let Some(first) = is_wanted.iter().position(|wanted| *wanted) else { return colors };
    let last = is_wanted.iter().rposition(|wanted| *wanted).unwrap_or(first);
    let (first_row, last_row) = (first / width, last / width);
    let prepared = ViewGeometry::new(scene_buffers, &projection);
    let projected = prepared.projected(&projection);
    let mut band = Band::new(first_row, last_row - first_row + 1, width);
    projected.bin(height, TriangleFilter::Opaque).band(0).for_each(|t| band.draw(t, 0xffff));
    let glass = projected.bin(height, TriangleFilter::Transparent);
    let mut glass: Vec<&ScreenTriangle> = glass.band(0).collect();
    let nearness = |t: &ScreenTriangle| t.key[0] + t.key[1] + t.key[2];
    glass.sort_by(|a, b| nearness(a).total_cmp(&nearness(b)));

    let shader = Shader::new(scene_buffers, &prepared, surroundings, projection.world_from_camera());
    let pixel = Pixel { projection: &projection, shader: &shader, sets };
    let mut light = vec![Vec3::ZERO; if glass.is_empty() { 0 } else { SETS * band.rows * width }];
    let mut shows_glass = vec![false; light.len() / SETS.max(1)];
    for t in glass {
        band.each_pixel_in_front(t, |x, row, key| {
            let at = row * width + x;
            if !is_wanted[first_row * width + at] {
                return;
            }
            let behind = &mut light[SETS * at..][..SETS];
            if !std::mem::replace(&mut shows_glass[at], true) {
                behind.copy_from_slice(&pixel.behind_glass(&band, x, row));
            }
            let blended = pixel.glass(t.source, key, x, first_row + row);
            for (behind, (added, passed)) in behind.iter_mut().zip(blended) {
                *behind = *behind * passed + added;
            }
        });
    }

    let mut tone_mappers = [(); SETS].map(|()| ToneMapper::new(shader.tone_curve()));
    for at in first..=last {
        if !is_wanted[at] {
            continue;
        }
        let (x, row) = (at % width, at / width - first_row);
        let in_band = row * width + x;
        let seen = if shows_glass.get(in_band).is_some_and(|shows| *shows) {
            std::array::from_fn(|set| light[SETS * in_band + set])
        } else if band.at(x, row).0 != NOTHING {
            pixel.opaque(&band, x, row)
        } else {
            continue;
        };
        for ((colors, tone_mapper), seen) in colors.iter_mut().zip(&mut tone_mappers).zip(seen) {
            let [r, g, b, _] = tone_mapper.encode(row, &PixelLight::Even(seen));
            colors[at] = Some([r, g, b]);
        }
    }
    colors
}

/// Shading of single pixels.
struct Pixel<'a, const SETS: usize> {
    projection: &'a Projection,
    shader: &'a Shader<'a>,
    sets: [&'a SurfaceColors<'a>; SETS],
}

impl<const SETS: usize> Pixel<'_, SETS> {
    /// Light from the opaque surface at a pixel of the band that has one.
    fn opaque(&self, band: &Band, x: usize, row: usize) -> [Vec3; SETS] {
        let (lens, y) = (&self.projection.lens, band.first_row + row);
        let (source, key) = band.at(x, row);
        let surface = self.shader.surface(source, lens, x as f32 + 0.5, y as f32 + 0.5);
        let pixel_size_m = lens.pixel_size_m(lens.depth_of(key));
        self.shader.colors_in(self.sets, &surface, pixel_size_m, grain(x, y))
    }

    /// Light that arrives from behind all glass.
    fn behind_glass(&self, band: &Band, x: usize, row: usize) -> [Vec3; SETS] {
        if band.at(x, row).0 != NOTHING {
            return self.opaque(band, x, row);
        }
        let y = band.first_row + row;
        let (px, py) = (x as f32 + 0.5, y as f32 + 0.5);
        let fraction = py / self.projection.height_px as f32;
        [self.shader.backdrop(fraction, &self.projection.lens, px, py, grain(x, y)); SETS]
    }

    /// Light that a transparent triangle adds, and the factor on the light from behind.
    fn glass(&self, source: u32, key: f32, x: usize, y: usize) -> [(Vec3, Vec3); SETS] {
        let lens = &self.projection.lens;
        let surface = self.shader.surface(source, lens, x as f32 + 0.5, y as f32 + 0.5);
        let pixel_size_m = lens.pixel_size_m(lens.depth_of(key));
        self.shader.glass_in(self.sets, &surface, pixel_size_m, grain(x, y))
    }
}
