//! From triangles to pictures: bands of rows, each rasterized, then shaded, on its own thread.

use glam::Vec3;
use rayon::prelude::*;

use super::environment::Environment;
use super::prepare::{Binned, Keep, Prepared};
use super::projection::{Lens, Projection};
use super::raster::{Band, NOTHING};
use super::shade::Shader;
use super::tone::{compress, encode_srgb};
use super::{Frame, GeometryFrame, RenderObject, RenderScene, RenderSettings, View};
use crate::geometry::Image;

/// Pixel rows of a band.
const BAND_ROWS: usize = 16;

/// Depth and ids.
pub fn measure(objects: &[RenderObject], view: &View) -> GeometryFrame {
    let projection = Projection::new(view, 1);
    let prepared = Prepared::new(objects, &projection);
    let binned = prepared.bin(objects, &projection, BAND_ROWS, Keep::All);
    let (width, height) = (projection.width_px, projection.height_px);
    let mut depth_m = vec![f32::INFINITY; width * height];
    let mut ids = vec![0; width * height];
    depth_m
        .par_chunks_mut(BAND_ROWS * width.max(1))
        .zip(ids.par_chunks_mut(BAND_ROWS * width.max(1)))
        .enumerate()
        .for_each(|(index, (depth_m, ids))| {
            let band = draw(&binned, index, width, depth_m.len() / width, 1);
            for k in 0..ids.len() {
                let (source, key) = band.at(k % width, k / width);
                if source != NOTHING {
                    depth_m[k] = projection.lens.depth_of(key);
                    ids[k] = objects[prepared.sources[source as usize].object as usize].id;
                }
            }
        });
    GeometryFrame { width_px: width as u32, height_px: height as u32, depth_m, ids }
}

fn draw(binned: &Binned, index: usize, width: usize, rows: usize, samples: usize) -> Band {
    let mut band = Band::new(index * BAND_ROWS * samples, rows * samples, width * samples);
    binned.band(index).for_each(|t| band.draw(t, 0xffff));
    band
}

/// One band's share of a [`Frame`].
struct Strip {
    rgba: Vec<u8>,
    depth_m: Vec<f32>,
    normals: Vec<[f32; 3]>,
    ids: Vec<u32>,
}

/// Color, depth, normals and ids.
pub fn paint(scene: &RenderScene, view: &View, settings: &RenderSettings) -> Frame {
    let objects = &scene.objects[..];
    let samples = settings.supersampling.clamp(1, 4);
    let projection = Projection::new(view, 1);
    let fine = Projection::new(view, samples);
    let prepared = Prepared::new(objects, &projection);
    let geometry = prepared.bin(objects, &projection, BAND_ROWS, Keep::All);
    let fine_rows = BAND_ROWS * samples as usize;
    let glass = prepared.bin(objects, &fine, fine_rows, Keep::Transparent);
    let shares_geometry = samples == 1 && glass.is_empty();
    let opaque = (!shares_geometry).then(|| prepared.bin(objects, &fine, fine_rows, Keep::Opaque));
    let environment = Environment::new(objects, scene.lighting, settings);
    let shader = Shader::new(scene, &prepared, environment, projection.world_from_camera());
    let (width, height) = (projection.width_px, projection.height_px);
    let strips: Vec<Strip> = (0..height.div_ceil(BAND_ROWS))
        .into_par_iter()
        .map(|index| {
            let rows = BAND_ROWS.min(height - index * BAND_ROWS);
            let front = draw(&geometry, index, width, rows, 1);
            let mut strip = measured(&front, &projection.lens, &shader, &prepared, objects);
            let mut linear = match &opaque {
                Some(opaque) => {
                    let band = draw(opaque, index, width, rows, samples as usize);
                    let mut linear = shaded(&band, &fine, &shader, samples as usize);
                    blend_glass(&mut linear, &band, &glass, index, &fine.lens, &shader);
                    linear
                }
                None => shaded(&front, &fine, &shader, 1),
            };
            linear.iter_mut().for_each(|c| *c = compress(*c));
            strip.rgba = averaged(&linear, width, rows, samples as usize);
            strip
        })
        .collect();
    let mut rgba = Vec::with_capacity(width * height * 4);
    let mut depth_m = Vec::with_capacity(width * height);
    let mut normals = Vec::with_capacity(width * height);
    let mut ids = Vec::with_capacity(width * height);
    for strip in strips {
        rgba.extend_from_slice(&strip.rgba);
        depth_m.extend_from_slice(&strip.depth_m);
        normals.extend_from_slice(&strip.normals);
        ids.extend_from_slice(&strip.ids);
    }
    let color = Image::from_rgba(width as u32, height as u32, rgba).expect("the bands fill the picture");
    Frame { color, depth_m, normals, ids }
}

fn measured(
    band: &Band,
    lens: &Lens,
    shader: &Shader,
    prepared: &Prepared,
    objects: &[RenderObject],
) -> Strip {
    let count = band.width_px * band.rows;
    let mut strip = Strip {
        rgba: Vec::new(),
        depth_m: vec![f32::INFINITY; count],
        normals: vec![[0.0; 3]; count],
        ids: vec![0; count],
    };
    for row in 0..band.rows {
        for x in 0..band.width_px {
            let (source, key) = band.at(x, row);
            if source == NOTHING {
                continue;
            }
            let at = row * band.width_px + x;
            let y = (band.first_row + row) as f32 + 0.5;
            strip.depth_m[at] = lens.depth_of(key);
            strip.ids[at] = objects[prepared.sources[source as usize].object as usize].id;
            strip.normals[at] = shader.surface(source, lens, x as f32 + 0.5, y).normal.to_array();
        }
    }
    strip
}

/// Linear color of each sample of the band, glass left out. Light and texture vary slowly over one surface
/// and textures are filtered to a pixel's size, so a pixel that shows one surface is shaded once; only pixels
/// on an edge are shaded at every sample.
fn shaded(band: &Band, projection: &Projection, shader: &Shader, samples: usize) -> Vec<Vec3> {
    let lens = &projection.lens;
    let (width, stride) = (band.width_px / samples, band.width_px);
    let mut linear = vec![Vec3::ZERO; stride * band.rows];
    let color = |x: usize, row: usize, across: usize| {
        let y = band.first_row + row;
        // The sample nearest the middle: its triangle is sure to be hit there.
        let middle = across / 2;
        let (px, py) = ((x + middle) as f32 + 0.5, (y + middle) as f32 + 0.5);
        let (source, key) = band.at(x + middle, row + middle);
        let turn_rad = grain(x / across, y / across);
        if source == NOTHING {
            shader.backdrop(py / projection.height_px as f32, lens, px, py, turn_rad)
        } else {
            let surface = shader.surface(source, lens, px, py);
            shader.color(&surface, across as f32 * lens.pixel_size_m(lens.depth_of(key)), turn_rad)
        }
    };
    for row in (0..band.rows).step_by(samples) {
        for x in (0..width).map(|x| x * samples) {
            let once = samples > 1 && shows_one_surface(band, shader, x, row, samples);
            let whole = once.then(|| color(x, row, samples));
            for v in row..row + samples {
                for u in x..x + samples {
                    linear[v * stride + u] = whole.unwrap_or_else(|| color(u, v, 1));
                }
            }
        }
    }
    linear
}

/// Whether all samples of the pixel see the backdrop, or one smooth piece of one material.
fn shows_one_surface(band: &Band, shader: &Shader, x: usize, row: usize, samples: usize) -> bool {
    let (first, _) = band.at(x, row);
    (row..row + samples).all(|v| {
        (x..x + samples).all(|u| {
            let (source, _) = band.at(u, v);
            source == first || (source != NOTHING && first != NOTHING && shader.continues(first, source))
        })
    })
}

/// Lays the see-through triangles over the samples, farthest first.
fn blend_glass(linear: &mut [Vec3], band: &Band, glass: &Binned, index: usize, lens: &Lens, shader: &Shader) {
    let mut triangles: Vec<_> = glass.band(index).collect();
    triangles.sort_by(|a, b| (a.key[0] + a.key[1] + a.key[2]).total_cmp(&(b.key[0] + b.key[1] + b.key[2])));
    for t in triangles {
        band.each_pixel_in_front(t, |x, row, key| {
            let y = band.first_row + row;
            let surface = shader.surface(t.source, lens, x as f32 + 0.5, y as f32 + 0.5);
            let pixel_size_m = lens.pixel_size_m(lens.depth_of(key));
            let (added, passed) = shader.glass(&surface, pixel_size_m, grain(x, y));
            let behind = &mut linear[row * band.width_px + x];
            *behind = *behind * passed + added;
        });
    }
}

/// A pixel's own turn of the sampling pattern (interleaved gradient noise, Jimenez 2014).
#[inline]
fn grain(x: usize, y: usize) -> f32 {
    let mixed = 0.067_110_56 * (x & 1023) as f32 + 0.005_837_15 * (y & 1023) as f32;
    let noise = (52.982_918 * mixed.fract()).fract();
    noise * std::f32::consts::TAU
}

fn averaged(linear: &[Vec3], width: usize, rows: usize, samples: usize) -> Vec<u8> {
    let scale = 1.0 / (samples * samples) as f32;
    let mut rgba = Vec::with_capacity(width * rows * 4);
    for row in 0..rows {
        for x in 0..width {
            let mut sum = Vec3::ZERO;
            for v in 0..samples {
                let start = (row * samples + v) * width * samples + x * samples;
                linear[start..start + samples].iter().for_each(|c| sum += *c);
            }
            let mean = sum * scale;
            rgba.extend([encode_srgb(mean.x), encode_srgb(mean.y), encode_srgb(mean.z), 255]);
        }
    }
    rgba
}
