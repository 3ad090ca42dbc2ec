//! One mesh in many poses on a GPU: its silhouettes, or their fit to a mask.

use std::sync::Arc;

use rayon::prelude::*;
use wgpu::{Buffer, BufferUsages, CommandEncoder};

use super::job::{DrawBuffers, Kernels, LARGEST_SIDE_PX, PackedPoses, TracedPose, Tracer, job_bytes, strips};
use crate::loss::{Dual, LossSums, SoftTerms, Target};
use crate::{Grid, MovingPoint, Surface};
use gpu::transfer::{INPUT, OUTPUT, READ_BACK, buffer, bytes_of, grow, read_back, read_words};
use gpu::{Gpu, GpuError};

/// Most memory for the planes of the poses of one dispatch; more poses take several.
const PLANES_BYTES: usize = 32 << 20;

/// A mesh whose silhouettes are drawn on a GPU.
pub struct GpuSilhouettes<const N: usize> {
    gpu: Arc<Gpu>,
    kernels: Arc<Kernels>,
    surface: Surface,
    grid: Grid,
    sigma_px2: f32,
    buffers: Buffers,
    /// The target mask's area, pixels^2, and the crop's side, pixels.
    goal: (f64, f64),
}

/// Buffers shared by all batches. Grown when needed, never shrunk.
struct Buffers {
    job: Buffer,
    poses: Buffer,
    lines: Buffer,
    pieces: Buffer,
    planes: Buffer,
    sums: Buffer,
    goal: Buffer,
    read_back: Buffer,
}

/// A soft silhouette read back from the device; row-major planes.
#[derive(Clone, Debug, PartialEq)]
pub struct DrawnImages<const N: usize> {
    pub coverage: Vec<f32>,
    pub slopes: [Vec<f32>; N],
}

impl<const N: usize> GpuSilhouettes<N> {
    /// `sigma_px2` as for [`SoftSilhouette::draw`](crate::SoftSilhouette::draw).
    pub fn new(gpu: Arc<Gpu>, surface: Surface, grid: Grid, sigma_px2: f32) -> Result<Self, GpuError> {
        let side_px = grid.width_px().max(grid.height_px);
        if side_px > LARGEST_SIDE_PX {
            return Err(GpuError::TooLarge { side_px, largest_px: LARGEST_SIDE_PX });
        }
        let kernels = gpu.kernels(N, |device| Kernels::new(device, N))?;
        let buffers = gpu.guarded("allocating buffers", || {
            let job = job_bytes(grid, sigma_px2);
            let buffers = Buffers {
                job: buffer(&gpu, job.len(), BufferUsages::UNIFORM | BufferUsages::COPY_DST),
                poses: buffer(&gpu, 0, INPUT),
                lines: buffer(&gpu, 0, INPUT),
                pieces: buffer(&gpu, 0, INPUT),
                planes: buffer(&gpu, 0, OUTPUT),
                sums: buffer(&gpu, 0, OUTPUT),
                goal: buffer(&gpu, 3 * 4 * grid.pixels(), INPUT),
                read_back: buffer(&gpu, 0, READ_BACK),
            };
            gpu.queue.write_buffer(&buffers.job, 0, &job);
            Ok(buffers)
        })?;
        Ok(Self { gpu, kernels, surface, grid, sigma_px2, buffers, goal: (0.0, 1.0) })
    }

    /// Coverage and slopes of every pose.
    pub fn draw(&mut self, poses: &[Vec<MovingPoint<N>>]) -> Result<Vec<DrawnImages<N>>, GpuError> {
        let pixels = self.grid.pixels();
        let numbers = self.in_batches("drawing soft silhouettes", poses, |this, encoder, count| {
            let bytes = count * this.image_bytes();
            read_back(&this.gpu, encoder, &this.buffers.planes, &mut this.buffers.read_back, bytes)
        })?;
        let mut planes = numbers.chunks_exact(pixels).map(<[f32]>::to_vec);
        let mut next = || planes.next().unwrap_or_default();
        Ok(poses
            .iter()
            .map(|_| DrawnImages { coverage: next(), slopes: std::array::from_fn(|_| next()) })
            .collect())
    }

    /// Sets the target of the following calls of [`Self::terms`].
    pub fn aim_at(&mut self, target: &Target) -> Result<(), GpuError> {
        let goal = [target.mask, target.known, target.distance_px].concat();
        self.goal = (target.mask_area_px2, target.side_px);
        self.gpu.guarded("uploading a mask", || {
            if goal.len() != 3 * self.grid.pixels() {
                return Err("the mask is not as large as the silhouettes".into());
            }
            self.gpu.queue.write_buffer(&self.buffers.goal, 0, &bytes_of(&goal));
            Ok(())
        })
    }

    /// The loss terms of every pose against the mask of [`Self::aim_at`], as [`terms`](crate::loss::terms).
    pub fn terms(&mut self, poses: &[Vec<MovingPoint<N>>]) -> Result<Vec<SoftTerms<N>>, GpuError> {
        let per_pose = strips(self.grid) * 4 * (1 + N);
        let numbers = self.in_batches("comparing soft silhouettes", poses, |this, encoder, count| {
            let (bytes, buffers) = (4 * count * per_pose, &mut this.buffers);
            grow(&this.gpu, &mut buffers.sums, bytes, OUTPUT);
            let bound = [&buffers.job, &buffers.planes, &buffers.goal, &buffers.sums];
            this.kernels.compare(&this.gpu.device, encoder, bound, this.grid, count as u32);
            read_back(&this.gpu, encoder, &buffers.sums, &mut buffers.read_back, bytes)
        })?;
        Ok(numbers
            .chunks_exact(per_pose)
            .map(|strips| summed::<N>(strips).terms(self.goal.0, self.goal.1))
            .collect())
    }

    fn image_bytes(&self) -> usize {
        4 * (1 + N) * self.grid.pixels()
    }

    /// Draws the poses in batches that fit into memory; `then` records the passes that follow and the read-back.
    fn in_batches(
        &mut self,
        attempted: &'static str,
        poses: &[Vec<MovingPoint<N>>],
        then: impl Fn(&mut Self, &mut CommandEncoder, usize) -> usize,
    ) -> Result<Vec<f32>, GpuError> {
        let mut numbers = Vec::new();
        for batch in poses.chunks((PLANES_BYTES / self.image_bytes()).max(1)) {
            let (surface, grid, sigma_px2) = (&self.surface, self.grid, self.sigma_px2);
            let traced: Vec<TracedPose> = batch
                .par_iter()
                .map_init(Tracer::default, |tracer, points| tracer.trace(surface, points, grid, sigma_px2))
                .collect();
            let packed = PackedPoses::new::<N>(&traced);
            let gpu = self.gpu.clone();
            numbers.extend(gpu.guarded(attempted, || self.submit(&packed, batch.len(), &then))?);
        }
        Ok(numbers)
    }

    fn submit(
        &mut self,
        packed: &PackedPoses,
        count: usize,
        then: impl Fn(&mut Self, &mut CommandEncoder, usize) -> usize,
    ) -> Result<Vec<f32>, String> {
        let (gpu, planes_bytes) = (self.gpu.clone(), count * self.image_bytes());
        let buffers = &mut self.buffers;
        for (buffer, bytes) in [
            (&mut buffers.poses, &packed.poses),
            (&mut buffers.lines, &packed.lines),
            (&mut buffers.pieces, &packed.pieces),
        ] {
            grow(&gpu, buffer, bytes.len(), INPUT);
            if !bytes.is_empty() {
                gpu.queue.write_buffer(buffer, 0, bytes);
            }
        }
        grow(&gpu, &mut buffers.planes, planes_bytes, OUTPUT);
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        let drawn = DrawBuffers {
            job: &buffers.job,
            poses: &buffers.poses,
            lines: &buffers.lines,
            pieces: &buffers.pieces,
            planes: &buffers.planes,
            count: count as u32,
        };
        self.kernels.draw(&gpu.device, &mut encoder, &drawn, self.grid);
        let bytes = then(self, &mut encoder, count);
        gpu.queue.submit([encoder.finish()]);
        let words = read_words(&gpu, &self.buffers.read_back, bytes)?;
        Ok(words.into_iter().map(f32::from_bits).collect())
    }
}

/// The sums of an image from those of its strips.
fn summed<const N: usize>(strips: &[f32]) -> LossSums<N> {
    let mut total = LossSums::NOTHING;
    for strip in strips.chunks_exact(4 * (1 + N)) {
        let sums = [&mut total.common, &mut total.covered, &mut total.far, &mut total.edges];
        for (sum, numbers) in sums.into_iter().zip(strip.chunks_exact(1 + N)) {
            let Dual { value, slopes } = sum;
            *value += f64::from(numbers[0]);
            slopes.iter_mut().zip(&numbers[1..]).for_each(|(slope, number)| *slope += f64::from(*number));
        }
    }
    total
}
