//! The compiled compute passes, and their dispatch for one strip of an image.

use wgpu::{
    BindGroupDescriptor, BindGroupEntry, Buffer, BufferUsages, CommandEncoder, ComputePassDescriptor,
    ComputePipeline, ComputePipelineDescriptor, Device, PipelineCompilationOptions, ShaderModule,
    ShaderModuleDescriptor, ShaderSource,
};

use super::job::{Job, Phase, Strip};
use crate::forward::backdrop::sunspot;
use crate::forward::light_map::glass;
use crate::forward::projection::NEAR_M;
use crate::forward::scene_buffers::TriangleFilter;
use crate::forward::shade::wear;
use crate::forward::{
    backdrop, environment, environment_map, light_map, partly_open, room_light, shade, sky,
};
use gpu::Gpu;
use gpu::transfer::sized;

/// Threads of a workgroup; `sweep` and its bits are made for this number.
const THREADS: usize = 64;
/// Side of the tile of a workgroup of `sweep`, and of the block of a thread of `shade`, pixels.
const TILE_PX: usize = 16;
const BLOCK_PX: usize = 2;
/// Maximum number of workgroups along one axis on all adapters.
const MAX_GROUPS: usize = 65_535;

/// Counters at the beginning of the state, words; the layers' is one of them.
pub const COUNTERS: usize = 4;
pub const LAYER_COUNTER: usize = 2;
/// Words of a pixel that come back: depth, id, normal; or its color.
pub const FRONT_WORDS: usize = 5;
pub const COLOR_WORDS: usize = 1;

/// The passes for one number of samples along a pixel's side.
pub struct Kernels {
    samples: usize,
    scatter: ComputePipeline,
    sweep: ComputePipeline,
    front: ComputePipeline,
    shade: ComputePipeline,
}

/// Buffers of the passes.
pub struct Workspace<'a> {
    pub scene: &'a Buffer,
    pub state: &'a Buffer,
    pub large: &'a Buffer,
    pub layers: &'a Buffer,
    pub light: &'a Buffer,
}

impl Kernels {
    pub fn new(device: &Device, samples: usize) -> Self {
        let constants = constants(samples);
        let module = |name: &str, sources: &[&str]| {
            let shared = [&constants, include_str!("job.wgsl"), include_str!("scene.wgsl")];
            let source = [&shared[..], sources].concat().concat();
            let source = ShaderSource::Wgsl(source.into());
            device.create_shader_module(ShaderModuleDescriptor { label: Some(name), source })
        };
        let visible = module("visible", &[include_str!("visible.wgsl")]);
        let surface = include_str!("surface.wgsl");
        let front = module("front", &[surface, include_str!("front.wgsl")]);
        let lit = [
            surface,
            include_str!("texture.wgsl"),
            include_str!("key_light.wgsl"),
            include_str!("room_light.wgsl"),
            include_str!("sky.wgsl"),
            include_str!("environment.wgsl"),
            include_str!("noise.wgsl"),
            include_str!("floor_pattern.wgsl"),
            include_str!("backdrop.wgsl"),
            include_str!("shade.wgsl"),
            include_str!("image.wgsl"),
        ];
        let shade = module("shade", &lit);
        Self {
            samples,
            scatter: pipeline(device, &visible, "scatter"),
            sweep: pipeline(device, &visible, "sweep"),
            front: pipeline(device, &front, "front"),
            shade: pipeline(device, &shade, "shade"),
        }
    }

    /// Bytes of the state of a strip, and where in it lies what comes back.
    pub fn state_bytes(&self, pixels: usize, words_of_a_pixel: usize) -> (usize, usize) {
        let results = COUNTERS + (2 * self.samples * self.samples + 1) * pixels;
        (4 * (results + words_of_a_pixel * pixels), 4 * results)
    }

    /// Records the passes that find the visible triangles. With a light these are the opaque ones, and then the
    /// transparent layers before them if there is room for any.
    pub fn find(&self, gpu: &Gpu, encoder: &mut CommandEncoder, space: &Workspace, job: &Job, strip: Strip) {
        let pixels = job.width_px() * strip.rows_px;
        encoder.clear_buffer(space.state, 0, Some(self.state_bytes(pixels, 0).0 as u64));
        let kept = if job.light.is_some() { TriangleFilter::Opaque } else { TriangleFilter::All };
        let mut phases = vec![(Phase::Keys, kept), (Phase::Fronts, kept)];
        phases.extend((job.layer_capacity > 0).then_some((Phase::Layers, TriangleFilter::Transparent)));
        let threads = job.scene.triangles as usize;
        let tiles = [job.width_px().div_ceil(TILE_PX), strip.rows_px.div_ceil(TILE_PX)];
        for (phase, kept) in phases {
            let uniform = uniform(gpu, job, strip, phase, kept);
            let buffers = [&uniform, space.scene, space.state, space.large, space.layers];
            run(gpu, encoder, &self.scatter, &buffers, groups_of(threads));
            run(gpu, encoder, &self.sweep, &buffers, tiles);
        }
    }

    /// Records the pass that writes depth, id and normal of the visible surface.
    pub fn front(&self, gpu: &Gpu, encoder: &mut CommandEncoder, space: &Workspace, job: &Job, strip: Strip) {
        let uniform = uniform(gpu, job, strip, Phase::Fronts, TriangleFilter::All);
        let groups = groups_of(job.width_px() * strip.rows_px);
        run(gpu, encoder, &self.front, &[&uniform, space.scene, space.state], groups);
    }

    /// Records the pass that shades the visible surface and the layers before it.
    pub fn shade(&self, gpu: &Gpu, encoder: &mut CommandEncoder, space: &Workspace, job: &Job, strip: Strip) {
        let uniform = uniform(gpu, job, strip, Phase::Layers, TriangleFilter::All);
        let blocks = job.width_px().div_ceil(BLOCK_PX) * strip.rows_px.div_ceil(BLOCK_PX);
        let buffers = [&uniform, space.scene, space.state, space.light, space.layers];
        run(gpu, encoder, &self.shade, &buffers, groups_of(blocks));
    }
}

/// Constants shared with the CPU code.
fn constants(samples: usize) -> String {
    let whole = [
        ("THREADS", THREADS),
        ("SAMPLES", samples),
        ("TILE_PX", TILE_PX),
        ("BLOCK_PX", BLOCK_PX),
        ("COARSE", light_map::COARSE),
        ("FINE", light_map::FINE),
        ("TAP_GROUPS", light_map::TAP_GROUPS),
        ("SEARCH_GROUPS", light_map::SEARCH_GROUPS),
        ("TURNS", light_map::TURNS),
        ("DIFFUSE_MAP", environment_map::DIFFUSE),
        ("GLASS_LEVELS", glass::LEVELS),
        ("GLASS_NEAR_LEVEL", glass::NEAR_LEVEL),
    ];
    let real = [
        ("NEAR_M", NEAR_M),
        ("LOWEST_F32", f32::MIN),
        ("BORDER", light_map::BORDER),
        ("FEW_BLOCKS", light_map::FEW_BLOCKS),
        ("NARROW", light_map::NARROW),
        ("STEEPEST", light_map::STEEPEST),
        ("GLASS_WIDER", glass::WIDER),
        ("GLASS_CLOSE_M", glass::CLOSE_M),
        ("DEFOCUS_M", backdrop::DEFOCUS_M),
        ("SHADED", partly_open::SHADED),
        ("MIN_SKY_COSINE", environment::MIN_SKY_COSINE),
        ("WALL_SHARE", room_light::WALL_SHARE),
        ("SUN_PAST_BARS_LESS", 1.0 - sunspot::PAST_BARS),
        ("SUN_PAST_CURTAIN_LESS", 1.0 - sunspot::PAST_CURTAIN),
        ("SUN_PAST_SLATS_LESS", 1.0 - sunspot::PAST_SLATS),
        ("BEND", room_light::BEND),
        ("RIM_BLUR", room_light::RIM_BLUR),
        ("RIM", shade::RIM),
        ("WEAR_FINE_M", wear::FINE_M),
        ("ROUGHNESS_STEPS", environment_map::ROUGHNESS_STEPS),
        ("SKY_SAME_DIRECTION", sky::SAME_DIRECTION),
        ("SKY_NEAR_PX", sky::NEAR_PX),
        ("SKY_SAME_PLANE_PX", sky::SAME_PLANE_PX),
    ];
    let whole = whole.map(|(name, value)| format!("const {name} = {value}u;\n")).concat();
    whole + &real.map(|(name, value)| format!("const {name} = {value:e}f;\n")).concat()
}

fn pipeline(device: &Device, module: &ShaderModule, entry_point: &str) -> ComputePipeline {
    device.create_compute_pipeline(&ComputePipelineDescriptor {
        label: Some(entry_point),
        layout: None,
        module,
        entry_point: Some(entry_point),
        // Every kernel fills what it shares before it reads it.
        compilation_options: PipelineCompilationOptions {
            zero_initialize_workgroup_memory: false,
            ..PipelineCompilationOptions::default()
        },
        cache: None,
    })
}

fn uniform(gpu: &Gpu, job: &Job, strip: Strip, phase: Phase, kept: TriangleFilter) -> Buffer {
    let words = job.bytes(strip, phase, kept);
    let uniform = sized(gpu, words.bytes().len(), BufferUsages::UNIFORM | BufferUsages::COPY_DST);
    gpu.queue.write_buffer(&uniform, 0, words.bytes());
    uniform
}

/// Workgroups for so many threads, in two axes.
fn groups_of(threads: usize) -> [usize; 2] {
    let groups = threads.div_ceil(THREADS);
    let rows = groups.div_ceil(MAX_GROUPS);
    [groups.div_ceil(rows.max(1)), rows]
}

fn run(
    gpu: &Gpu,
    encoder: &mut CommandEncoder,
    pipeline: &ComputePipeline,
    buffers: &[&Buffer],
    [across, down]: [usize; 2],
) {
    let entries: Vec<BindGroupEntry> = (0..)
        .zip(buffers)
        .map(|(binding, buffer)| BindGroupEntry { binding, resource: buffer.as_entire_binding() })
        .collect();
    let layout = pipeline.get_bind_group_layout(0);
    let descriptor = BindGroupDescriptor { label: None, layout: &layout, entries: &entries };
    let group = gpu.device.create_bind_group(&descriptor);
    let mut pass = encoder.begin_compute_pass(&ComputePassDescriptor::default());
    pass.set_pipeline(pipeline);
    pass.set_bind_group(0, &group, &[]);
    pass.dispatch_workgroups(across as u32, down as u32, 1);
}
