//! A [`SceneCache`] rendered on a GPU: the same calls, with errors.

use std::sync::Arc;

use wgpu::{Buffer, BufferUsages};

use super::job::{Job, Strip};
use super::kernels::{COLOR_WORDS, COUNTERS, FRONT_WORDS, Kernels, LAYER_COUNTER, Workspace};
use super::light_words::{ImageLight, LightLayout, light_words};
use super::scene_words::{SceneLayout, scene_words};
use super::words::Words;
use crate::forward::backdrop::Backdrop;
use crate::forward::bands::{ExtraOutputs, VisibleSurfaces, shadow_map_px};
use crate::forward::environment::Environment;
use crate::forward::floor_light::FloorLight;
use crate::forward::projection::Projection;
use crate::forward::shade_band::MAX_SUPERSAMPLING;
use crate::{Background, Frame, GeometryFrame, Lighting, SceneCache, View};
use gpu::transfer::{INPUT, OUTPUT, READ_BACK, TransferError, read_words, sized};
use gpu::{Gpu, GpuError};
use imaging::Image;

/// Size limits of one strip.
#[derive(Clone, Copy, Debug)]
pub(super) struct Capacity {
    /// Maximum number of pixels, and of samples, of a strip.
    pub pixels: usize,
    pub samples: usize,
    /// Capacity in layers of glass, per pixel of a strip and in total; if it is exceeded, strips become lower.
    pub layers_of_a_pixel: usize,
    pub fewest_layers: usize,
}

const CAPACITY: Capacity =
    Capacity { pixels: 1 << 20, samples: 1 << 22, layers_of_a_pixel: 4, fewest_layers: 1 << 16 };

const LAYER_BYTES: usize = 16;
/// Rows of the lowest strip: whole blocks that share light from the sky.
const MIN_ROWS_PX: usize = 2;

/// Placed objects, uploaded to a device.
pub struct GpuSceneCache<'a> {
    gpu: Arc<Gpu>,
    scene_cache: Arc<SceneCache<'a>>,
    scene: Buffer,
    layout: SceneLayout,
    pub(super) capacity: Capacity,
}

impl<'a> GpuSceneCache<'a> {
    /// Uploads the view-independent data.
    pub fn new(gpu: Arc<Gpu>, scene_cache: Arc<SceneCache<'a>>) -> Result<Self, GpuError> {
        let (words, layout) =
            scene_words(&scene_cache.scene_buffers, &scene_cache.sky, scene_cache.sky_of_rooms.as_ref());
        let bytes = words.bytes().len().max(2 * 4 * layout.triangles as usize);
        check_fits(&gpu, "uploading a scene", bytes)?;
        let scene = gpu.guarded("uploading a scene", || Ok(filled(&gpu, &words)))?;
        Ok(Self { gpu, scene_cache, scene, layout, capacity: CAPACITY })
    }

    /// The device that renders.
    pub fn gpu(&self) -> &Arc<Gpu> {
        &self.gpu
    }

    /// As [`SceneCache::color`].
    pub fn color(&self, lighting: Lighting, background: Background, view: &View) -> Result<Image, GpuError> {
        Ok(self.rendered(lighting, background, view, ExtraOutputs::Nothing)?.0)
    }

    /// As [`SceneCache::render`].
    pub fn render(&self, lighting: Lighting, background: Background, view: &View) -> Result<Frame, GpuError> {
        let (color, front) = self.rendered(lighting, background, view, ExtraOutputs::Geometry)?;
        Ok(Frame { color, depth_m: front.depth_m, normals: None, ids: front.ids })
    }

    /// As [`SceneCache::render_with_normals`].
    pub fn render_with_normals(
        &self,
        lighting: Lighting,
        background: Background,
        view: &View,
    ) -> Result<Frame, GpuError> {
        let (color, front) = self.rendered(lighting, background, view, ExtraOutputs::GeometryAndNormals)?;
        Ok(Frame { color, depth_m: front.depth_m, normals: Some(front.normals), ids: front.ids })
    }

    /// As [`SceneCache::measure`].
    pub fn measure(&self, view: &View) -> Result<GeometryFrame, GpuError> {
        let front = self.fronts(view, ExtraOutputs::Geometry)?;
        let (width_px, height_px) = (view.width_px(), view.height_px());
        Ok(GeometryFrame { width_px, height_px, depth_m: front.depth_m, ids: front.ids })
    }

    fn rendered(
        &self,
        lighting: Lighting,
        background: Background,
        view: &View,
        extra: ExtraOutputs,
    ) -> Result<(Image, VisibleSurfaces), GpuError> {
        let light = self.light(lighting, background, view);
        let (words, layout) = light_words(&light);
        check_fits(&self.gpu, "uploading a shadow map", words.bytes().len())?;
        let samples = self.scene_cache.settings.supersampling.clamp(1, MAX_SUPERSAMPLING);
        let words = self.drawn("rendering", view, samples, Some((&light, words, layout)))?;
        let rgba = words.into_iter().flat_map(u32::to_ne_bytes).collect();
        let image = Image::from_rgba(view.width_px(), view.height_px(), rgba);
        let front = match extra {
            ExtraOutputs::Nothing => VisibleSurfaces::default(),
            ExtraOutputs::Geometry | ExtraOutputs::GeometryAndNormals => self.fronts(view, extra)?,
        };
        Ok((image.expect("the strips fill the image"), front))
    }

    fn light(&self, lighting: Lighting, background: Background, view: &View) -> ImageLight<'_> {
        let SceneCache { scene_buffers, settings, .. } = &*self.scene_cache;
        let sky = self.scene_cache.sky_for(&background);
        let environment = Environment::new(scene_buffers, sky, lighting, shadow_map_px(settings, view))
            .in_room(background.room);
        let light = |z_m: f64| FloorLight::new(scene_buffers, &environment, z_m as f32);
        let floor_light = background.floor_z_m().map(light);
        let backdrop = Backdrop::new(background, &environment, floor_light);
        ImageLight { environment, backdrop }
    }

    fn fronts(&self, view: &View, extra: ExtraOutputs) -> Result<VisibleSurfaces, GpuError> {
        let words = self.drawn("measuring", view, 1, None)?;
        let mut front = VisibleSurfaces::default();
        for word in words.chunks_exact(FRONT_WORDS) {
            let (depth_m, id) = (f32::from_bits(word[0]), word[1]);
            let nothing = depth_m == 0.0 && id == 0;
            front.depth_m.push(if nothing { f32::INFINITY } else { depth_m });
            front.ids.push(id);
            if extra == ExtraOutputs::GeometryAndNormals {
                front.normals.push(std::array::from_fn(|k| f32::from_bits(word[2 + k])));
            }
        }
        Ok(front)
    }

    /// Reads back each pixel's color, or without a light its depth, id and normal.
    fn drawn(
        &self,
        attempted: &'static str,
        view: &View,
        samples: u32,
        light: Option<(&ImageLight, Words, LightLayout)>,
    ) -> Result<Vec<u32>, GpuError> {
        let gpu = &self.gpu;
        let projection = Projection::new(view, samples);
        let samples = samples as usize;
        let kernels = gpu.kernels(samples, |device| Kernels::new(device, samples))?;
        let (width, height) = (view.width_px() as usize, view.height_px() as usize);
        if width == 0 || height == 0 {
            return Ok(Vec::new());
        }
        let max_pixels = self.capacity.pixels.min(self.capacity.samples / (samples * samples));
        let mut rows_px = (max_pixels / width).clamp(MIN_ROWS_PX, height.max(MIN_ROWS_PX));
        rows_px -= rows_px % MIN_ROWS_PX;
        let words_of_a_pixel = if light.is_some() { COLOR_WORDS } else { FRONT_WORDS };
        let (state_bytes, _) = kernels.state_bytes(rows_px * width, words_of_a_pixel);
        let layered = light.is_some() && self.layout.has_glass;
        let room = (self.capacity.layers_of_a_pixel * rows_px * width).max(self.capacity.fewest_layers);
        let layers = if layered { room } else { 0 };
        check_fits(gpu, attempted, state_bytes.max(LAYER_BYTES * layers))?;
        let job = Job {
            projection: &projection,
            samples,
            scene: self.layout,
            light: light.as_ref().map(|(light, _, layout)| (*light, *layout)),
            layer_capacity: layers as u32,
        };
        let light_words = light.as_ref().map(|(_, words, _)| words);
        let (state, large, layer_buffer, light_buffer) = gpu.guarded(attempted, || {
            let large = sized(gpu, 2 * 4 * self.layout.triangles as usize, INPUT);
            let light = light_words.map_or_else(|| sized(gpu, 0, INPUT), |words| filled(gpu, words));
            let state = sized(gpu, state_bytes, OUTPUT | BufferUsages::COPY_DST);
            Ok((state, large, sized(gpu, LAYER_BYTES * layers, INPUT), light))
        })?;
        let space = Workspace {
            scene: &self.scene,
            state: &state,
            large: &large,
            layers: &layer_buffer,
            light: &light_buffer,
        };
        let mut drawn = Vec::with_capacity(width * height * words_of_a_pixel);
        let mut first_row_px = 0;
        while first_row_px < height {
            let strip = Strip { first_row_px, rows_px: rows_px.min(height - first_row_px) };
            let results_bytes = 4 * words_of_a_pixel * width * strip.rows_px;
            let words =
                gpu.guarded(attempted, || self.strip(&kernels, &space, &job, strip, results_bytes))?;
            let (counters, results) = words.split_at(COUNTERS);
            if counters[LAYER_COUNTER] as usize > layers {
                if rows_px <= MIN_ROWS_PX {
                    let adapter = gpu.name().to_owned();
                    return Err(GpuError::TooManyLayers { adapter, highest: layers });
                }
                rows_px = (rows_px / 2).max(MIN_ROWS_PX).next_multiple_of(MIN_ROWS_PX);
                continue;
            }
            drawn.extend_from_slice(results);
            first_row_px += strip.rows_px;
        }
        Ok(drawn)
    }

    /// The counters after a strip was drawn, and its results.
    fn strip(
        &self,
        kernels: &Kernels,
        space: &Workspace,
        job: &Job,
        strip: Strip,
        results_bytes: usize,
    ) -> Result<Vec<u32>, TransferError> {
        let gpu = &self.gpu;
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        kernels.find(gpu, &mut encoder, space, job, strip);
        match job.light {
            Some(_) => kernels.shade(gpu, &mut encoder, space, job, strip),
            None => kernels.front(gpu, &mut encoder, space, job, strip),
        }
        let returned = sized(gpu, 4 * COUNTERS + results_bytes, READ_BACK);
        let (_, results_at) = kernels.state_bytes(job.width_px() * strip.rows_px, 0);
        for (from, to, bytes) in [(0, 0, 4 * COUNTERS), (results_at, 4 * COUNTERS, results_bytes)] {
            let [from, to, bytes] = [from, to, bytes].map(|n| n as u64);
            encoder.copy_buffer_to_buffer(space.state, from, &returned, to, bytes);
        }
        gpu.queue.submit([encoder.finish()]);
        read_words(gpu, &returned, 4 * COUNTERS + results_bytes)
    }
}

fn check_fits(gpu: &Gpu, attempted: &'static str, bytes: usize) -> Result<(), GpuError> {
    let largest_bytes = gpu.max_buffer_bytes();
    if bytes <= largest_bytes {
        return Ok(());
    }
    Err(GpuError::DoesNotFit { attempted, adapter: gpu.name().to_owned(), bytes, largest_bytes })
}

fn filled(gpu: &Gpu, words: &Words) -> Buffer {
    let buffer = sized(gpu, words.bytes().len(), INPUT);
    if !words.bytes().is_empty() {
        gpu.queue.write_buffer(&buffer, 0, words.bytes());
    }
    buffer
}
