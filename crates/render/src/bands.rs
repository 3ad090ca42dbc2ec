//! From triangles to pictures: bands of rows, each rasterized, then shaded, on its own thread.

use rayon::prelude::*;

use super::environment::Environment;
use super::lighting::{Background, Lighting};
use super::lit_band::{LitBand, MOST_SUPERSAMPLING};
use super::prepare::{Binned, Prepared};
use super::projection::{Lens, Projection};
use super::raster::{Band, NOTHING};
use super::scenery::{Keep, Scenery};
use super::shade::Shader;
use super::sky::Sky;
use super::{GeometryFrame, RenderSettings, View};
use imaging::Image;

/// Pixel rows of a band.
const BAND_ROWS: usize = 16;
/// Samples of color, depth or id that are worth a task of their own: handing out less costs more than it
/// gains.
const TASK_SAMPLES: usize = 1 << 14;

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
    let prepared = Prepared::new(scenery, &projection);
    let binned = prepared.projected(&projection).bin(BAND_ROWS, Keep::All);
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
    let projected = prepared.projected(&fine);
    let opaque = projected.bin(BAND_ROWS * samples, Keep::Opaque);
    let glass = projected.bin(BAND_ROWS * samples, Keep::Transparent);
    // Where color is sampled at pixel centers and nothing is see-through, one drawing serves both.
    let apart = besides != Besides::Nothing && (samples > 1 || !glass.is_empty());
    let all = apart.then(|| prepared.projected(&projection).bin(BAND_ROWS, Keep::All));
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
            let lit = LitBand { band: &band, projection: &fine, shader: &shader, samples };
            lit.develop(&glass, index, rgba);
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
