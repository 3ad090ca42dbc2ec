//! Image of everything that does not move, drawn once for all images of a sequence from a camera that does not move.
//!
//! An image then needs the objects that move, drawn over the layer; the light of their pixels; and for the other pixels
//! the shadows of what moves. Most of those have none, and keep their color.

use std::ops::Range;

use glam::Vec3;
use rayon::prelude::*;

use super::bands::{BAND_ROWS, VisibleSurfaces, bands_of_a_task, draw, note_front};
use super::environment::Environment;
use super::prepare::{TriangleBins, ViewGeometry};
use super::projection::Projection;
use super::raster::Band;
use super::scene_buffers::{SceneBuffers, TriangleFilter};
use super::shade::{Shader, StillLight, Surroundings};
use super::shade_band::{BandShader, MAX_SAMPLES, MAX_SUPERSAMPLING, PixelLight};
use super::sky::SkyNearby;
use super::tone_map::ToneMapper;
use crate::View;
use imaging::Image;

/// The still part of the images of one view.
pub struct StillLayer {
    raster: StillRaster,
    /// One sample a pixel, for depth and ids; drawn when they are first asked for.
    measured: Option<StillRaster>,
    view: View,
    bands: Vec<LitBand>,
}

/// Colors and light of the pixels of a band.
struct LitBand {
    rgba: Vec<u8>,
    /// Of all pixels, one after the other: one where they are even, else as many as samples.
    lights: Vec<StillLight>,
    /// Index of each pixel's first light, and at the end the number of lights.
    first_light: Vec<u32>,
}

/// Rasterized bands of the objects that do not move.
struct StillRaster {
    projection: Projection,
    samples: usize,
    /// Of all objects; those of what moves are renewed for each image.
    camera_points: Vec<Vec3>,
    bands: Vec<Band>,
}

impl StillRaster {
    fn new(
        scene_buffers: &SceneBuffers,
        still: &Range<usize>,
        view: &View,
        samples: u32,
        keep: TriangleFilter,
    ) -> Self {
        let projection = Projection::new(view, samples);
        let samples = samples as usize;
        let prepared = ViewGeometry::new(scene_buffers, &projection);
        let binned = prepared.projected_part(&projection, still).bin(BAND_ROWS * samples, keep);
        let (width, height) = (projection.width_px / samples, projection.height_px / samples);
        let rows = |index: usize| BAND_ROWS.min(height - index * BAND_ROWS);
        let bands = (0..height.div_ceil(BAND_ROWS))
            .into_par_iter()
            .with_min_len(bands_of_a_task(width, samples))
            .map(|index| draw(&binned, index, width, rows(index), samples))
            .collect();
        Self { projection, samples, camera_points: prepared.camera_points, bands }
    }

    /// The band with more triangles.
    fn with(&self, index: usize, more: &TriangleBins) -> Band {
        let mut band = self.bands[index].clone();
        more.band(index).for_each(|t| band.draw(t, 0xffff));
        band
    }

    fn width_px(&self) -> usize {
        self.projection.width_px / self.samples
    }

    fn height_px(&self) -> usize {
        self.projection.height_px / self.samples
    }
}

impl StillLayer {
    /// Draws consecutive objects that do not move. `surroundings` have no shadows of others.
    pub(crate) fn new(
        scene_buffers: &SceneBuffers,
        still: &Range<usize>,
        surroundings: &Surroundings,
        view: &View,
        supersampling: u32,
    ) -> Self {
        let samples = supersampling.clamp(1, MAX_SUPERSAMPLING);
        let mut raster = StillRaster::new(scene_buffers, still, view, samples, TriangleFilter::Opaque);
        let points = std::mem::take(&mut raster.camera_points);
        let prepared = ViewGeometry::refreshed(scene_buffers, &raster.projection, points, &(0..0));
        let world_from_camera = raster.projection.world_from_camera();
        let shader = Shader::new(scene_buffers, &prepared, surroundings, world_from_camera);
        let lit = |band: &Band| {
            LitBand::new(&BandShader {
                band,
                projection: &raster.projection,
                shader: &shader,
                samples: raster.samples,
            })
        };
        let bands = raster.bands.par_iter().map(lit).collect();
        raster.camera_points = prepared.camera_points;
        Self { raster, measured: None, view: *view, bands }
    }

    /// The image with the objects that move where they are now. `surroundings` have their shadows.
    pub(crate) fn color(
        &mut self,
        scene_buffers: &SceneBuffers,
        moving: &Range<usize>,
        surroundings: &Surroundings,
    ) -> Image {
        let raster = &mut self.raster;
        let points = std::mem::take(&mut raster.camera_points);
        let prepared = ViewGeometry::refreshed(scene_buffers, &raster.projection, points, moving);
        let projection = &raster.projection;
        let rows = BAND_ROWS * raster.samples;
        let opaque = prepared.projected_part(projection, moving).bin(rows, TriangleFilter::Opaque);
        let all = scene_buffers.all();
        let has_glass = scene_buffers.drawn(TriangleFilter::Transparent, &all).len() > 0;
        let glassy = if has_glass { all } else { 0..0 };
        let glass = prepared.projected_part(projection, &glassy).bin(rows, TriangleFilter::Transparent);
        let shader = Shader::new(scene_buffers, &prepared, surroundings, projection.world_from_camera());
        let (width, height) = (raster.width_px(), raster.height_px());
        let mut rgba = vec![0; width * height * 4];
        rgba.par_chunks_mut((4 * BAND_ROWS * width).max(1))
            .enumerate()
            .with_min_len(bands_of_a_task(width, raster.samples))
            .for_each(|(index, rgba)| {
                let band = raster.with(index, &opaque);
                let shading =
                    BandShader { band: &band, projection, shader: &shader, samples: raster.samples };
                match glass.band(index).next() {
                    // What is behind glass is mixed with it in every sample.
                    Some(_) => shading.shade(&glass, index, rgba),
                    None => {
                        let environment = &surroundings.environment;
                        self.bands[index].shade(&shading, &raster.bands[index], environment, rgba);
                    }
                }
            });
        raster.camera_points = prepared.camera_points;
        Image::from_rgba(width as u32, height as u32, rgba).expect("the bands fill the image")
    }

    /// Depth and ids at the pixel centers.
    pub(crate) fn measure(&mut self, scene_buffers: &SceneBuffers, moving: &Range<usize>) -> VisibleSurfaces {
        let view = &self.view;
        let still = 0..moving.start;
        let raster = self
            .measured
            .get_or_insert_with(|| StillRaster::new(scene_buffers, &still, view, 1, TriangleFilter::All));
        let points = std::mem::take(&mut raster.camera_points);
        let prepared = ViewGeometry::refreshed(scene_buffers, &raster.projection, points, moving);
        let projection = &raster.projection;
        let drawn = prepared.projected_part(projection, moving).bin(BAND_ROWS, TriangleFilter::All);
        let (width, height) = (raster.width_px(), raster.height_px());
        let mut seen = VisibleSurfaces {
            depth_m: vec![f32::INFINITY; width * height],
            ids: vec![0; width * height],
            normals: Vec::new(),
        };
        let chunk = (BAND_ROWS * width).max(1);
        let chunks = seen.depth_m.par_chunks_mut(chunk).zip(seen.ids.par_chunks_mut(chunk)).enumerate();
        chunks.with_min_len(bands_of_a_task(width, 1)).for_each(|(index, (depth_m, ids))| {
            note_front(&raster.with(index, &drawn), &projection.lens, scene_buffers, depth_m, ids);
        });
        raster.camera_points = prepared.camera_points;
        seen
    }
}

impl LitBand {
    fn new(shading: &BandShader) -> Self {
        let width = shading.band.width_px / shading.samples;
        let pixels = width * (shading.band.rows / shading.samples);
        // Pixels come in blocks; they are kept row by row.
        let mut of_pixels: Vec<Vec<StillLight>> = vec![Vec::new(); pixels];
        shading.each_pixel(|x, row, light: PixelLight<StillLight>| {
            of_pixels[row * width + x] = match light {
                PixelLight::Even(light) => vec![light],
                PixelLight::Uneven(lights) => lights.to_vec(),
            };
        });
        let mut band = Self { rgba: vec![0; 4 * pixels], lights: Vec::new(), first_light: Vec::new() };
        let mut tone_mapper = ToneMapper::new(shading.shader.tone_curve());
        for (pixel, lights) in of_pixels.into_iter().enumerate() {
            band.first_light.push(band.lights.len() as u32);
            let bytes = exposed(&mut tone_mapper, pixel / width, &lights, &[1.0; MAX_SAMPLES]);
            band.rgba[4 * pixel..][..4].copy_from_slice(&bytes);
            band.lights.extend(lights);
        }
        band.first_light.push(band.lights.len() as u32);
        band
    }

    /// Writes the pixels of the band: `shading` has what moves drawn over `still`.
    fn shade(&self, shading: &BandShader, still: &Band, environment: &Environment, rgba: &mut [u8]) {
        let samples = shading.samples;
        let width = shading.band.width_px / samples;
        let mut tone_mapper = ToneMapper::new(shading.shader.tone_curve());
        let mut seen = [Vec3::ZERO; MAX_SAMPLES];
        for (pixel, bytes) in rgba.chunks_exact_mut(4).enumerate() {
            let (row, x) = (pixel / width, pixel % width);
            if !shows_the_same(shading.band, still, x * samples, row * samples, samples) {
                let light = shading.pixel(x, row, &mut SkyNearby::default(), &mut seen);
                bytes.copy_from_slice(&tone_mapper.encode(row, &light));
                continue;
            }
            let lights = &self.lights[self.first_light[pixel] as usize..self.first_light[pixel + 1] as usize];
            let mut passing = [1.0; MAX_SAMPLES];
            for (passing, light) in
                passing.iter_mut().zip(lights).filter(|(_, light)| light.key != Vec3::ZERO)
            {
                *passing = environment.past_moving(light.point, light.flat_normal, light.turn);
            }
            if passing == [1.0; MAX_SAMPLES] {
                bytes.copy_from_slice(&self.rgba[4 * pixel..][..4]);
            } else {
                bytes.copy_from_slice(&exposed(&mut tone_mapper, row, lights, &passing));
            }
        }
    }
}

/// The color of a pixel where these shares of the key light pass what moves, one for each of its lights.
fn exposed(
    tone_mapper: &mut ToneMapper,
    row: usize,
    lights: &[StillLight],
    passing: &[f32; MAX_SAMPLES],
) -> [u8; 4] {
    let mut seen = [Vec3::ZERO; MAX_SAMPLES];
    for ((seen, light), passing) in seen.iter_mut().zip(lights).zip(passing) {
        *seen = light.base + light.key * *passing;
    }
    tone_mapper.encode(row, &PixelLight::Uneven(&seen[..lights.len()]))
}

/// Whether the samples of a pixel show the same triangles.
#[inline]
fn shows_the_same(a: &Band, b: &Band, x: usize, row: usize, samples: usize) -> bool {
    (row..row + samples).all(|row| {
        let pairs = a.sources(x, row, samples).iter().zip(b.sources(x, row, samples));
        pairs.into_iter().all(|(a, b)| a.to_bits() == b.to_bits())
    })
}
