//! Rendering by bands of rows: each band is rasterized and shaded on its own thread.

use std::sync::Arc;

use rayon::prelude::*;

use super::environment::Environment;
use super::prepare::{TriangleBins, ViewGeometry};
use super::projection::{Lens, Projection};
use super::raster::{Band, NOTHING};
use super::scene_buffers::{SceneBuffers, TriangleFilter};
use super::shade::{Shader, Surroundings};
use super::shade_band::{BandShader, MAX_SUPERSAMPLING};
use super::sky::Sky;
use super::surface_colors::SurfaceColors;
use crate::lighting::{Background, Lighting};
use crate::{GeometryFrame, RenderSettings, View};
use imaging::Image;

/// Pixel rows of a band.
pub const BAND_ROWS: usize = 16;
/// Samples of color, depth or id per rayon task; smaller tasks cost more than they gain.
const TASK_SAMPLES: usize = 1 << 14;

/// Sky, lighting and background of an image.
pub struct Light<'a> {
    pub sky: &'a Sky,
    pub lighting: Lighting,
    pub background: Background,
}

/// Outputs of a rendering besides color.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum ExtraOutputs {
    Nothing,
    Geometry,
    GeometryAndNormals,
}

/// Depth, ids and normals at the pixel centers, row by row from the top; outputs that were not requested are empty.
#[derive(Default)]
pub struct VisibleSurfaces {
    /// Depth along the optical axis, meters; infinite for background.
    pub depth_m: Vec<f32>,
    /// Id of the object, 0 = background.
    pub ids: Vec<u32>,
    /// Unit normals, world frame, facing the eye; zero for background.
    pub normals: Vec<[f32; 3]>,
}

/// Renders depth and ids.
pub fn measure(scene_buffers: &SceneBuffers, view: &View) -> GeometryFrame {
    let projection = Projection::new(view, 1);
    let prepared = ViewGeometry::new(scene_buffers, &projection);
    let binned = prepared.projected(&projection).bin(BAND_ROWS, TriangleFilter::All);
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
            note_front(&band, &projection.lens, scene_buffers, depth_m, ids);
        });
    frame
}

pub fn bands_of_a_task(width: usize, samples: usize) -> usize {
    TASK_SAMPLES.div_ceil((BAND_ROWS * width * samples * samples).max(1))
}

pub fn draw(binned: &TriangleBins, index: usize, width: usize, rows: usize, samples: usize) -> Band {
    let mut band = Band::new(index * BAND_ROWS * samples, rows * samples, width * samples);
    binned.band(index).for_each(|t| band.draw(t, 0xffff));
    band
}

/// Writes depth and id of the visible surface at each pixel of the band; background pixels stay unchanged.
pub fn note_front(
    band: &Band,
    lens: &Lens,
    scene_buffers: &SceneBuffers,
    depth_m: &mut [f32],
    ids: &mut [u32],
) {
    for k in 0..ids.len() {
        let (source, key) = band.at(k % band.width_px, k / band.width_px);
        if source != NOTHING {
            depth_m[k] = lens.depth_of(key);
            ids[k] = scene_buffers.objects[scene_buffers.triangles[source as usize].object as usize].id;
        }
    }
}

/// Renders color and the requested extra outputs.
pub fn render<'a>(
    scene_buffers: &SceneBuffers<'a>,
    colors: Arc<SurfaceColors<'a>>,
    light: &Light,
    view: &View,
    settings: &RenderSettings,
    extra: ExtraOutputs,
) -> (Image, VisibleSurfaces) {
    let environment =
        Environment::new(scene_buffers, light.sky, light.lighting, shadow_map_px(settings, view))
            .in_room(light.background.room);
    let surroundings = Surroundings::new(scene_buffers, environment, light.background, colors);
    render_in(scene_buffers, &surroundings, view, settings.supersampling, extra)
}

/// Renders color and the requested extra outputs with prepared light and materials.
pub fn render_in(
    scene_buffers: &SceneBuffers,
    surroundings: &Surroundings,
    view: &View,
    supersampling: u32,
    extra: ExtraOutputs,
) -> (Image, VisibleSurfaces) {
    let samples = supersampling.clamp(1, MAX_SUPERSAMPLING);
    let projection = Projection::new(view, 1);
    let fine = Projection::new(view, samples);
    let prepared = ViewGeometry::new(scene_buffers, &projection);
    let samples = samples as usize;
    let projected = prepared.projected(&fine);
    let opaque = projected.bin(BAND_ROWS * samples, TriangleFilter::Opaque);
    let glass = projected.bin(BAND_ROWS * samples, TriangleFilter::Transparent);
    // One rasterization serves both outputs if color is sampled at pixel centers and nothing is transparent.
    let apart = extra != ExtraOutputs::Nothing && (samples > 1 || !glass.is_empty());
    let all = apart.then(|| prepared.projected(&projection).bin(BAND_ROWS, TriangleFilter::All));
    let (width, height) = (projection.width_px, projection.height_px);
    let shader = Shader::new(scene_buffers, &prepared, surroundings, projection.world_from_camera());
    let mut rgba = vec![0; width * height * 4];
    let bands: Vec<VisibleSurfaces> = rgba
        .par_chunks_mut(4 * BAND_ROWS * width.max(1))
        .enumerate()
        .with_min_len(bands_of_a_task(width, samples))
        .map(|(index, rgba)| {
            let rows = rgba.len() / (4 * width);
            let band = draw(&opaque, index, width, rows, samples);
            let lit = BandShader { band: &band, projection: &fine, shader: &shader, samples };
            lit.shade(&glass, index, rgba);
            if extra == ExtraOutputs::Nothing {
                return VisibleSurfaces::default();
            }
            let drawn = all.as_ref().map(|all| draw(all, index, width, rows, 1));
            let band = drawn.as_ref().unwrap_or(&band);
            let (mut depth_m, mut ids) = (vec![f32::INFINITY; rows * width], vec![0; rows * width]);
            note_front(band, &projection.lens, scene_buffers, &mut depth_m, &mut ids);
            let normals = match extra {
                ExtraOutputs::GeometryAndNormals => normals_of(band, &projection.lens, &shader),
                _ => Vec::new(),
            };
            VisibleSurfaces { depth_m, ids, normals }
        })
        .collect();
    let mut front = VisibleSurfaces::default();
    for band in bands {
        front.depth_m.extend(band.depth_m);
        front.ids.extend(band.ids);
        front.normals.extend(band.normals);
    }
    (Image::from_rgba(width as u32, height as u32, rgba).expect("the bands fill the image"), front)
}

/// Side of the key light's map for that image; a map finer than the image adds no detail.
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
