//! From triangles to pictures: bands of rows, each rasterized, then shaded, on its own thread.

use glam::Vec3;
use rayon::prelude::*;

use super::environment::Environment;
use super::lighting::{Background, Lighting};
use super::prepare::{Binned, Prepared};
use super::projection::{Lens, Projection};
use super::raster::{Band, NOTHING};
use super::scenery::{Keep, Scenery};
use super::shade::Shader;
use super::sky::{Sky, SkyNearby};
use super::tone::compress;
use super::{GeometryFrame, RenderSettings, View};
use crate::geometry::Image;
use crate::geometry::srgb::encode_srgb;

/// Pixel rows of a band.
const BAND_ROWS: usize = 16;
/// Samples of color, depth or id that are worth a task of their own: handing out less costs more than it
/// gains.
const TASK_SAMPLES: usize = 1 << 14;
/// Pixels along each side of a block that shares sky light; divides [`BAND_ROWS`].
const SKY_BLOCK_PX: usize = 2;
/// Color samples along each side of a pixel, and in all.
pub const MOST_SUPERSAMPLING: u32 = 4;
const MOST_SAMPLES: usize = (MOST_SUPERSAMPLING * MOST_SUPERSAMPLING) as usize;

/// What light there is, and what is seen beyond the objects.
pub struct Light<'a> {
    pub sky: &'a Sky,
    pub lighting: Lighting,
    pub background: Background,
}

/// What is wanted of a picture besides its color.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Besides {
    Nothing,
    Geometry,
    GeometryAndNormals,
}

/// What is in front at the pixel centers, row by row from the top; a list that was not wanted is empty.
#[derive(Default)]
pub struct Front {
    /// Meters along the optical axis, infinite where there is background.
    pub depth_m: Vec<f32>,
    /// Id of the object, 0 = background.
    pub ids: Vec<u32>,
    /// Unit, in the world, turned toward the eye; zero where there is background.
    pub normals: Vec<[f32; 3]>,
}

/// Depth and ids.
pub fn measure(scenery: &Scenery, view: &View) -> GeometryFrame {
    let projection = Projection::new(view, 1);
    let binned = Prepared::new(scenery, &projection).bin(&projection, BAND_ROWS, Keep::All);
    let (width, height) = (projection.width_px, projection.height_px);
    let mut frame = GeometryFrame {
        width_px: width as u32,
        height_px: height as u32,
        depth_m: vec![f32::INFINITY; width * height],
        ids: vec![0; width * height],
    };
    frame
        .depth_m
        .par_chunks_mut(BAND_ROWS * width.max(1))
        .zip(frame.ids.par_chunks_mut(BAND_ROWS * width.max(1)))
        .enumerate()
        .with_min_len(bands_of_a_task(width, 1))
        .for_each(|(index, (depth_m, ids))| {
            let band = draw(&binned, index, width, depth_m.len() / width, 1);
            note_front(&band, &projection.lens, scenery, depth_m, ids);
        });
    frame
}

fn bands_of_a_task(width: usize, samples: usize) -> usize {
    TASK_SAMPLES.div_ceil((BAND_ROWS * width * samples * samples).max(1))
}

fn draw(binned: &Binned, index: usize, width: usize, rows: usize, samples: usize) -> Band {
    let mut band = Band::new(index * BAND_ROWS * samples, rows * samples, width * samples);
    binned.band(index).for_each(|t| band.draw(t, 0xffff));
    band
}

/// Writes depth and id of what is in front at each of the band's pixels; the others stay as they are.
fn note_front(band: &Band, lens: &Lens, scenery: &Scenery, depth_m: &mut [f32], ids: &mut [u32]) {
    for k in 0..ids.len() {
        let (source, key) = band.at(k % band.width_px, k / band.width_px);
        if source != NOTHING {
            depth_m[k] = lens.depth_of(key);
            ids[k] = scenery.objects[scenery.triangles[source as usize].object as usize].id;
        }
    }
}

/// Color, and what is wanted besides.
pub fn paint(
    scenery: &Scenery,
    light: &Light,
    view: &View,
    settings: &RenderSettings,
    besides: Besides,
) -> (Image, Front) {
    let samples = settings.supersampling.clamp(1, MOST_SUPERSAMPLING);
    let projection = Projection::new(view, 1);
    let fine = Projection::new(view, samples);
    let prepared = Prepared::new(scenery, &projection);
    let samples = samples as usize;
    let opaque = prepared.bin(&fine, BAND_ROWS * samples, Keep::Opaque);
    let glass = prepared.bin(&fine, BAND_ROWS * samples, Keep::Transparent);
    // Where color is sampled at pixel centers and nothing is see-through, one drawing serves both.
    let apart = besides != Besides::Nothing && (samples > 1 || !glass.is_empty());
    let all = apart.then(|| prepared.bin(&projection, BAND_ROWS, Keep::All));
    let (width, height) = (projection.width_px, projection.height_px);
    let environment = Environment::new(scenery, light.sky, light.lighting, shadow_map_px(settings, view));
    let world_from_camera = projection.world_from_camera();
    let shader = Shader::new(scenery, &prepared, environment, light.background, world_from_camera);
    let mut rgba = vec![0; width * height * 4];
    let bands: Vec<Front> = rgba
        .par_chunks_mut(4 * BAND_ROWS * width.max(1))
        .enumerate()
        .with_min_len(bands_of_a_task(width, samples))
        .map(|(index, rgba)| {
            let rows = rgba.len() / (4 * width);
            let band = draw(&opaque, index, width, rows, samples);
            let mut linear = shaded(&band, &fine, &shader, samples);
            blend_glass(&mut linear, &band, &glass, index, &fine, &shader, samples);
            average(&linear, width, samples, rgba);
            if besides == Besides::Nothing {
                return Front::default();
            }
            let drawn = all.as_ref().map(|all| draw(all, index, width, rows, 1));
            let band = drawn.as_ref().unwrap_or(&band);
            let (mut depth_m, mut ids) = (vec![f32::INFINITY; rows * width], vec![0; rows * width]);
            note_front(band, &projection.lens, scenery, &mut depth_m, &mut ids);
            let normals = match besides {
                Besides::GeometryAndNormals => normals_of(band, &projection.lens, &shader),
                _ => Vec::new(),
            };
            Front { depth_m, ids, normals }
        })
        .collect();
    let mut front = Front::default();
    for band in bands {
        front.depth_m.extend(band.depth_m);
        front.ids.extend(band.ids);
        front.normals.extend(band.normals);
    }
    (Image::from_rgba(width as u32, height as u32, rgba).expect("the bands fill the picture"), front)
}

/// Side of the key light's map for that picture: one finer than the picture shows nothing more.
pub fn shadow_map_px(settings: &RenderSettings, view: &View) -> u32 {
    settings.shadow_map_px.min(view.width_px().max(view.height_px()))
}

/// The band's normals, zero where there is background.
fn normals_of(band: &Band, lens: &Lens, shader: &Shader) -> Vec<[f32; 3]> {
    (0..band.width_px * band.rows)
        .map(|k| {
            let (x, row) = (k % band.width_px, k / band.width_px);
            match band.at(x, row) {
                (NOTHING, _) => [0.0; 3],
                (source, _) => {
                    let y = (band.first_row + row) as f32 + 0.5;
                    shader.normal(source, lens, x as f32 + 0.5, y).to_array()
                }
            }
        })
        .collect()
}

/// Linear color of each sample of the band, glass left out. Light and texture vary slowly over one surface
/// and textures are filtered to a pixel's size, so each surface in a pixel is shaded once. Sky light varies
/// more slowly still: blocks of pixels share it.
fn shaded(band: &Band, projection: &Projection, shader: &Shader, samples: usize) -> Vec<Vec3> {
    let lens = &projection.lens;
    let stride = band.width_px;
    let mut linear = vec![Vec3::ZERO; stride * band.rows];
    let color = |x: usize, row: usize, across: usize, nearby: &mut SkyNearby| {
        let y = band.first_row + row;
        // The sample nearest the middle: its triangle is sure to be hit there.
        let middle = across / 2;
        let (px, py) = ((x + middle) as f32 + 0.5, (y + middle) as f32 + 0.5);
        let (source, key) = band.at(x + middle, row + middle);
        let turn = grain(x / across, y / across);
        if source == NOTHING {
            shader.backdrop(py / projection.height_px as f32, lens, px, py, turn)
        } else {
            let surface = shader.surface(source, lens, px, py);
            shader.color(&surface, across as f32 * lens.pixel_size_m(lens.depth_of(key)), turn, nearby)
        }
    };
    let block = SKY_BLOCK_PX * samples;
    for (top, left) in
        (0..band.rows).step_by(block).flat_map(|y| (0..stride).step_by(block).map(move |x| (y, x)))
    {
        let mut nearby = SkyNearby::default();
        for row in (top..(top + block).min(band.rows)).step_by(samples) {
            for x in (left..(left + block).min(stride)).step_by(samples) {
                if samples == 1 {
                    linear[row * stride + x] = color(x, row, 1, &mut nearby);
                } else if shows_one_surface(band, shader, x, row, samples) {
                    let whole = color(x, row, samples, &mut nearby);
                    (row..row + samples).for_each(|v| linear[v * stride + x..][..samples].fill(whole));
                } else {
                    let mut known: [(u32, Vec3); MOST_SAMPLES] = [(NOTHING, Vec3::ZERO); MOST_SAMPLES];
                    for k in 0..samples * samples {
                        let (u, v) = (x + k % samples, row + k / samples);
                        let (source, _) = band.at(u, v);
                        let alike = |other: &&(u32, Vec3)| is_one_surface(shader, other.0, source);
                        let shown = known[..k].iter().find(alike).map(|(_, shown)| *shown);
                        known[k] = (source, shown.unwrap_or_else(|| color(u, v, 1, &mut nearby)));
                        linear[v * stride + u] = known[k].1;
                    }
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
            is_one_surface(shader, first, source)
        })
    })
}

/// Whether two samples see the backdrop, or one smooth piece of one material.
fn is_one_surface(shader: &Shader, a: u32, b: u32) -> bool {
    a == b || (a != NOTHING && b != NOTHING && shader.continues(a, b))
}

/// Lays the see-through triangles over the samples, farthest first. A triangle is shaded once in a pixel.
fn blend_glass(
    linear: &mut [Vec3],
    band: &Band,
    glass: &Binned,
    index: usize,
    projection: &Projection,
    shader: &Shader,
    samples: usize,
) {
    let lens = &projection.lens;
    let mut triangles: Vec<_> = glass.band(index).collect();
    triangles.sort_by(|a, b| (a.key[0] + a.key[1] + a.key[2]).total_cmp(&(b.key[0] + b.key[1] + b.key[2])));
    // For each pixel of a row: row and triangle it was shaded for, and the result.
    let nothing = (usize::MAX, usize::MAX, Vec3::ZERO, Vec3::ZERO);
    let mut known = vec![nothing; if triangles.is_empty() { 0 } else { band.width_px / samples }];
    for (number, t) in triangles.into_iter().enumerate() {
        band.each_pixel_in_front(t, |x, row, key| {
            let known = &mut known[x / samples];
            if (known.0, known.1) != (row / samples, number) {
                let y = band.first_row + row;
                let surface = shader.surface(t.source, lens, x as f32 + 0.5, y as f32 + 0.5);
                let pixel_size_m = samples as f32 * lens.pixel_size_m(lens.depth_of(key));
                let (added, passed) = shader.glass(&surface, pixel_size_m, grain(x / samples, y / samples));
                *known = (row / samples, number, added, passed);
            }
            let behind = &mut linear[row * band.width_px + x];
            *behind = *behind * known.3 + known.2;
        });
    }
}

/// A pixel's own turn of the sampling pattern, 0..1 (interleaved gradient noise, Jimenez 2014).
#[inline]
fn grain(x: usize, y: usize) -> f32 {
    let mixed = 0.067_110_56 * (x & 1023) as f32 + 0.005_837_15 * (y & 1023) as f32;
    (52.982_918 * mixed.fract()).fract()
}

/// Means of each pixel's samples as sRGB, highlights bent first.
fn average(linear: &[Vec3], width: usize, samples: usize, rgba: &mut [u8]) {
    let scale = 1.0 / (samples * samples) as f32;
    for (row, pixels) in rgba.chunks_exact_mut(4 * width.max(1)).enumerate() {
        for (x, pixel) in pixels.chunks_exact_mut(4).enumerate() {
            let line = |v: usize| &linear[((row * samples + v) * width + x) * samples..][..samples];
            let first = line(0)[0];
            let mean = if (0..samples).all(|v| line(v).iter().all(|c| *c == first)) {
                compress(first)
            } else {
                (0..samples).flat_map(line).map(|c| compress(*c)).sum::<Vec3>() * scale
            };
            pixel.copy_from_slice(&[encode_srgb(mean.x), encode_srgb(mean.y), encode_srgb(mean.z), 255]);
        }
    }
}
