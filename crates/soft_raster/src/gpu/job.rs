//! The compute kernels and their inputs: one job for many poses.

use wgpu::{
    BindGroup, BindGroupDescriptor, BindGroupEntry, Buffer, CommandEncoder, ComputePassDescriptor,
    ComputePipeline, ComputePipelineDescriptor, Device, PipelineCompilationOptions, ShaderModuleDescriptor,
    ShaderSource,
};

use crate::loss::EDGE_EPSILON;
use crate::outline::{LayeredSurface, Outline};
use crate::{Grid, MovingPoint, Surface, band, fill};

/// Largest width and height of an image: a row's counts must fit a workgroup's memory.
pub const LARGEST_SIDE_PX: usize = 1024;

/// Threads of a workgroup; the tile of `soften` and its bits are made for this number.
const THREADS: u32 = 64;

/// Side of the tile of a workgroup of `soften`, pixels.
const TILE_PX: u32 = 8;

/// Rows that are summed up together.
const STRIP_ROWS: u32 = 8;

/// Numbers of a line and of a pose's ranges, four bytes each.
const LINE_WORDS: usize = 6;

/// The compiled passes for one number of parameters.
#[derive(Debug)]
pub struct Kernels {
    fill: ComputePipeline,
    soften: ComputePipeline,
    compare: ComputePipeline,
}

impl Kernels {
    pub fn new(device: &Device, parameters: usize) -> Self {
        let constants = format!(
            "const THREADS = {THREADS}u;\nconst PLANES = {}u;\nconst MAX_SIDE_PX = {LARGEST_SIDE_PX}u;\n\
             const STRIP_ROWS = {STRIP_ROWS}u;\nconst EDGE_EPSILON = {EDGE_EPSILON:e}f;\n",
            parameters + 1
        );
        let compiled = |name: &str, source: &str| {
            let source = [&constants, include_str!("job.wgsl"), source].concat();
            let module = device.create_shader_module(ShaderModuleDescriptor {
                label: Some(name),
                source: ShaderSource::Wgsl(source.into()),
            });
            device.create_compute_pipeline(&ComputePipelineDescriptor {
                label: Some(name),
                layout: None,
                module: &module,
                entry_point: Some(name),
                // Every kernel fills what it shares before it reads it.
                compilation_options: PipelineCompilationOptions {
                    zero_initialize_workgroup_memory: false,
                    ..PipelineCompilationOptions::default()
                },
                cache: None,
            })
        };
        Self {
            fill: compiled("fill", include_str!("fill.wgsl")),
            soften: compiled("soften", include_str!("soften.wgsl")),
            compare: compiled("compare", include_str!("compare.wgsl")),
        }
    }

    /// Records the passes that draw `poses` images into `planes`.
    pub fn draw(&self, device: &Device, encoder: &mut CommandEncoder, drawn: &DrawBuffers, grid: Grid) {
        let (width, height) = (grid.width_px() as u32, grid.height_px as u32);
        let group = |pipeline, third| bound(device, pipeline, [drawn.job, drawn.poses, third, drawn.planes]);
        let fill = (&self.fill, group(&self.fill, drawn.lines), [height, drawn.count, 1]);
        let tiles = [width / TILE_PX, height.div_ceil(TILE_PX), drawn.count];
        let soften = (&self.soften, group(&self.soften, drawn.pieces), tiles);
        run(encoder, &[fill, soften]);
    }

    /// Records the pass that computes the sums of the loss.
    pub fn compare(
        &self,
        device: &Device,
        encoder: &mut CommandEncoder,
        buffers: [&Buffer; 4],
        grid: Grid,
        count: u32,
    ) {
        let strips = grid.height_px.div_ceil(STRIP_ROWS as usize) as u32;
        run(encoder, &[(&self.compare, bound(device, &self.compare, buffers), [strips, count, 1])]);
    }
}

/// Buffers of a drawing.
pub struct DrawBuffers<'a> {
    pub job: &'a Buffer,
    pub poses: &'a Buffer,
    pub lines: &'a Buffer,
    pub pieces: &'a Buffer,
    pub planes: &'a Buffer,
    /// Number of poses.
    pub count: u32,
}

/// Strips of an image whose sums come back one by one.
pub fn strips(grid: Grid) -> usize {
    grid.height_px.div_ceil(STRIP_ROWS as usize)
}

fn bound(device: &Device, pipeline: &ComputePipeline, buffers: [&Buffer; 4]) -> BindGroup {
    let entries: Vec<BindGroupEntry> = buffers
        .iter()
        .enumerate()
        .map(|(k, buffer)| BindGroupEntry { binding: k as u32, resource: buffer.as_entire_binding() })
        .collect();
    let layout = pipeline.get_bind_group_layout(0);
    device.create_bind_group(&BindGroupDescriptor { label: None, layout: &layout, entries: &entries })
}

fn run(encoder: &mut CommandEncoder, passes: &[(&ComputePipeline, BindGroup, [u32; 3])]) {
    let mut pass = encoder.begin_compute_pass(&ComputePassDescriptor::default());
    for (pipeline, group, [x, y, z]) in passes {
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, group, &[]);
        pass.dispatch_workgroups(*x, *y, *z);
    }
}

/// The contour and the outline of one pose, as the kernels read them.
#[derive(Debug, Default)]
pub struct TracedPose {
    lines: Vec<[u32; LINE_WORDS]>,
    /// `1 + N` quadruples a piece.
    pieces: Vec<[f32; 4]>,
}

/// Working memory for tracing poses one after another.
#[derive(Debug, Default)]
pub struct Tracer<const N: usize> {
    clockwise: Vec<bool>,
    fill: fill::Fill,
    outline: Outline<N>,
}

impl<const N: usize> Tracer<N> {
    pub fn trace(
        &mut self,
        surface: &Surface,
        points: &[MovingPoint<N>],
        grid: Grid,
        sigma_px2: f32,
    ) -> TracedPose {
        surface.find_clockwise(points, &mut self.clockwise);
        let mut lines = Vec::new();
        self.fill.count(surface, points, &self.clockwise, grid);
        fill::each_line(surface, points, self.fill.steps(), |upper, lower, layers| {
            // Such a line begins nothing: it crosses no row.
            if lower[1] > upper[1] && lower[1] > 0.0 && upper[1] < grid.height_px as f32 {
                let slope = (lower[0] - upper[0]) / (lower[1] - upper[1]);
                let [x, y, slope, end] = [upper[0], upper[1], slope, lower[1]].map(f32::to_bits);
                lines.push([x, y, slope, end, layers as u32, 0]);
            }
        });
        let seen = LayeredSurface { surface, points, clockwise: &self.clockwise, fill: &self.fill };
        self.outline.trace(&seen, grid, band::reach_px(sigma_px2));
        let pieces = self.outline.pieces().iter().flat_map(|piece| {
            let [a, b] = piece.ends;
            let quad = |a: [f32; 2], b: [f32; 2]| [a[0], a[1], b[0], b[1]];
            std::iter::once(quad(a.at_px, b.at_px)).chain((0..N).map(move |k| quad(a.slopes[k], b.slopes[k])))
        });
        TracedPose { lines, pieces: pieces.collect() }
    }
}

/// Many poses, one after another, as bytes.
#[derive(Debug, Default)]
pub struct PackedPoses {
    pub poses: Vec<u8>,
    pub lines: Vec<u8>,
    pub pieces: Vec<u8>,
}

impl PackedPoses {
    pub fn new<const N: usize>(traced: &[TracedPose]) -> Self {
        let mut packed = Self::default();
        let (mut first_line, mut first_piece) = (0, 0);
        for TracedPose { lines, pieces } in traced {
            let ranges = [first_line, lines.len(), first_piece, pieces.len() / (1 + N)];
            packed.poses.extend(ranges.into_iter().flat_map(|n| (n as u32).to_ne_bytes()));
            packed.lines.extend(lines.iter().flatten().flat_map(|word| word.to_ne_bytes()));
            packed.pieces.extend(pieces.iter().flatten().flat_map(|word| word.to_ne_bytes()));
            (first_line, first_piece) = (first_line + ranges[1], first_piece + ranges[3]);
        }
        packed
    }
}

/// The uniform of all passes.
pub fn job_bytes(grid: Grid, sigma_px2: f32) -> Vec<u8> {
    let reach_px = band::reach_px(sigma_px2);
    let words = [grid.width_px() as u32, grid.height_px as u32, reach_px.to_bits(), sigma_px2.to_bits()];
    words.into_iter().flat_map(u32::to_ne_bytes).collect()
}
