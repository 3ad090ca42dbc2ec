//! Shading of a rasterized band: surfaces and backdrop are shaded, glass is blended over them, light becomes sRGB.

use glam::Vec3;

use super::prepare::{ScreenTriangle, TriangleBins};
use super::projection::{Lens, Projection};
use super::raster::{Band, NOTHING};
use super::shade::{Shader, StillLight, Surface};
use super::sky::SkyNearby;
use super::tone_map::ToneMapper;

/// Maximum number of color samples along each side of a pixel, and per pixel.
pub const MAX_SUPERSAMPLING: u32 = 4;
pub const MAX_SAMPLES: usize = (MAX_SUPERSAMPLING * MAX_SUPERSAMPLING) as usize;
/// Pixels along each side of a block that shares sky light; bands are whole blocks high, so none is cut.
const SKY_BLOCK_PX: usize = 2;

/// Light at the samples of a pixel, linear.
pub enum PixelLight<'a, L = Vec3> {
    /// Light that is equal at all samples.
    Even(L),
    /// Row by row.
    Uneven(&'a [L]),
}

/// Result of shading at a sample.
pub trait SampleLight: Copy + Default {
    /// [`Shader::color`] or a form of it.
    fn of_surface(shader: &Shader, s: &Surface, pixel_size_m: f32, turn: f32, nearby: &mut SkyNearby)
    -> Self;
    /// [`Shader::backdrop`] or a form of it.
    fn of_backdrop(shader: &Shader, fraction: f32, lens: &Lens, at: (f32, f32), turn: f32) -> Self;
}

impl SampleLight for Vec3 {
    fn of_surface(
        shader: &Shader,
        s: &Surface,
        pixel_size_m: f32,
        turn: f32,
        nearby: &mut SkyNearby,
    ) -> Self {
        shader.color(s, pixel_size_m, turn, nearby)
    }

    fn of_backdrop(shader: &Shader, fraction: f32, lens: &Lens, (x, y): (f32, f32), turn: f32) -> Self {
        shader.backdrop(fraction, lens, x, y, turn)
    }
}

impl SampleLight for StillLight {
    fn of_surface(
        shader: &Shader,
        s: &Surface,
        pixel_size_m: f32,
        turn: f32,
        nearby: &mut SkyNearby,
    ) -> Self {
        shader.still_color(s, pixel_size_m, turn, nearby)
    }

    fn of_backdrop(shader: &Shader, fraction: f32, lens: &Lens, (x, y): (f32, f32), turn: f32) -> Self {
        shader.still_backdrop(fraction, lens, x, y, turn)
    }
}

/// A rasterized band with its projection and shader.
pub struct BandShader<'a> {
    pub band: &'a Band,
    pub projection: &'a Projection,
    pub shader: &'a Shader<'a>,
    /// Along each side of a pixel.
    pub samples: usize,
}

impl BandShader<'_> {
    /// Writes the band's pixels as sRGB. `glass` holds the transparent triangles of the image, `index` is the band's
    /// number.
    pub fn shade(&self, glass: &TriangleBins, index: usize, rgba: &mut [u8]) {
        let (samples, stride) = (self.samples, self.band.width_px);
        let width = stride / samples;
        let mut tone_mapper = ToneMapper::new(self.shader.tone_curve());
        let mut expose = |x: usize, row: usize, light: &PixelLight, rgba: &mut [u8]| {
            rgba[4 * (row * width + x)..][..4].copy_from_slice(&tone_mapper.encode(row, light));
        };
        if glass.band(index).next().is_none() {
            self.each_pixel(|x, row, light: PixelLight| expose(x, row, &light, rgba));
            return;
        }
        let mut linear = vec![Vec3::ZERO; stride * self.band.rows];
        self.each_pixel(|x, row, light: PixelLight| {
            for v in 0..samples {
                let line = &mut linear[(row * samples + v) * stride + x * samples..][..samples];
                match light {
                    PixelLight::Even(color) => line.fill(color),
                    PixelLight::Uneven(colors) => line.copy_from_slice(&colors[v * samples..][..samples]),
                }
            }
        });
        self.blend_glass(&mut linear, glass, index);
        let mut seen = [Vec3::ZERO; MAX_SAMPLES];
        for (row, x) in (0..self.band.rows / samples).flat_map(|row| (0..width).map(move |x| (row, x))) {
            for v in 0..samples {
                let line = &linear[(row * samples + v) * stride + x * samples..][..samples];
                seen[v * samples..][..samples].copy_from_slice(line);
            }
            expose(x, row, &PixelLight::Uneven(&seen[..samples * samples]), rgba);
        }
    }

    /// Calls `visit` with column, row and light of each pixel, without glass. Sky light varies slowly: blocks of pixels
    /// share it.
    pub fn each_pixel<L: SampleLight>(&self, mut visit: impl FnMut(usize, usize, PixelLight<L>)) {
        let (width, rows) = (self.band.width_px / self.samples, self.band.rows / self.samples);
        let blocks = |count: usize| (0..count).step_by(SKY_BLOCK_PX);
        let mut seen = [L::default(); MAX_SAMPLES];
        for (top, left) in blocks(rows).flat_map(|top| blocks(width).map(move |left| (top, left))) {
            let mut nearby = SkyNearby::default();
            for row in top..(top + SKY_BLOCK_PX).min(rows) {
                for x in left..(left + SKY_BLOCK_PX).min(width) {
                    visit(x, row, self.pixel(x, row, &mut nearby, &mut seen));
                }
            }
        }
    }

    /// The light of a pixel, without glass. Light and texture vary slowly over one surface and textures are filtered to
    /// a pixel's size, so each surface in a pixel is shaded once.
    pub fn pixel<'s, L: SampleLight>(
        &self,
        x: usize,
        row: usize,
        nearby: &mut SkyNearby,
        seen: &'s mut [L; MAX_SAMPLES],
    ) -> PixelLight<'s, L> {
        let Self { band, shader, samples, .. } = *self;
        let (u0, v0) = (x * samples, row * samples);
        if samples == 1 || shows_one_surface(band, shader, u0, v0, samples) {
            return PixelLight::Even(self.sample(u0, v0, samples, nearby));
        }
        let mut sources = [NOTHING; MAX_SAMPLES];
        for k in 0..samples * samples {
            let (u, v) = (u0 + k % samples, v0 + k / samples);
            sources[k] = band.at(u, v).0;
            let known = (0..k).find(|&j| is_one_surface(shader, sources[j], sources[k]));
            seen[k] = known.map_or_else(|| self.sample(u, v, 1, nearby), |j| seen[j]);
        }
        PixelLight::Uneven(&seen[..samples * samples])
    }

    /// The light of `across` samples each way, or of one.
    fn sample<L: SampleLight>(&self, x: usize, row: usize, across: usize, nearby: &mut SkyNearby) -> L {
        let Self { band, projection, shader, .. } = *self;
        let lens = &projection.lens;
        let y = band.first_row + row;
        // The sample nearest the pixel center, which its triangle certainly covers.
        let center = across / 2;
        let (px, py) = ((x + center) as f32 + 0.5, (y + center) as f32 + 0.5);
        let (source, key) = band.at(x + center, row + center);
        let turn = grain(x / across, y / across);
        if source == NOTHING {
            L::of_backdrop(shader, py / projection.height_px as f32, lens, (px, py), turn)
        } else {
            let surface = shader.surface(source, lens, px, py);
            L::of_surface(
                shader,
                &surface,
                across as f32 * lens.pixel_size_m(lens.depth_of(key)),
                turn,
                nearby,
            )
        }
    }

    /// Blends the transparent triangles over the samples, farthest first. A triangle is shaded once in a pixel.
    fn blend_glass(&self, linear: &mut [Vec3], glass: &TriangleBins, index: usize) {
        let Self { band, projection, shader, samples } = *self;
        let lens = &projection.lens;
        let mut triangles: Vec<_> = glass.band(index).collect();
        let nearness = |t: &ScreenTriangle| t.key[0] + t.key[1] + t.key[2];
        triangles.sort_by(|a, b| nearness(a).total_cmp(&nearness(b)));
        // For each pixel of a row: row and triangle it was shaded for, and the result.
        let nothing = (usize::MAX, usize::MAX, Vec3::ZERO, Vec3::ZERO);
        let mut known = vec![nothing; band.width_px / samples];
        for (number, t) in triangles.into_iter().enumerate() {
            band.each_pixel_in_front(t, |x, row, key| {
                let known = &mut known[x / samples];
                if (known.0, known.1) != (row / samples, number) {
                    let y = band.first_row + row;
                    let surface = shader.surface(t.source, lens, x as f32 + 0.5, y as f32 + 0.5);
                    let pixel_size_m = samples as f32 * lens.pixel_size_m(lens.depth_of(key));
                    let turn = grain(x / samples, y / samples);
                    let (added, passed) = shader.glass(&surface, pixel_size_m, turn);
                    *known = (row / samples, number, added, passed);
                }
                let behind = &mut linear[row * band.width_px + x];
                *behind = *behind * known.3 + known.2;
            });
        }
    }
}

/// Whether all samples of the pixel see the backdrop, or one smooth piece of one material.
#[inline]
fn shows_one_surface(band: &Band, shader: &Shader, x: usize, row: usize, samples: usize) -> bool {
    let (first, _) = band.at(x, row);
    (row..row + samples).all(|row| {
        let sources = band.sources(x, row, samples);
        sources.iter().all(|source| is_one_surface(shader, first, source.to_bits()))
    })
}

/// Whether two samples see the backdrop, or one smooth piece of one material.
#[inline]
fn is_one_surface(shader: &Shader, a: u32, b: u32) -> bool {
    a == b || (a != NOTHING && b != NOTHING && shader.continues(a, b))
}

/// A pixel's own turn of the sampling pattern, 0..1 (interleaved gradient noise, Jimenez 2014).
#[inline]
pub fn grain(x: usize, y: usize) -> f32 {
    // Positive and small: without SSE 4.1 the library's `fract` is a call.
    let fract = |c: f32| c - (c as i32) as f32;
    fract(52.982_918 * fract(0.067_110_56 * (x & 1023) as f32 + 0.005_837_15 * (y & 1023) as f32))
}
