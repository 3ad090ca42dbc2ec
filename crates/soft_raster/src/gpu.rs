//! Soft silhouettes on a GPU: many poses of one mesh at once, through `wgpu` compute.
//!
//! For each pose the CPU finds the contour and cuts it at occlusions (outline.rs, in f64, which shaders lack), in
//! parallel. The device fills, softens, and sums the two terms of the loss with their derivatives (gpu/*.wgsl, one per
//! CPU file), so that a few numbers per pose and eight rows return. A GPU therefore speeds up the part of the work
//! that grows with the image, not the part that grows with the mesh.
//!
//! The device is that of the `gpu` crate. Portable: storage buffers and 32-bit integer atomics within a
//! workgroup only, the limits of OpenGL ES 3.1 ([`wgpu::Limits::downlevel_defaults`]), no render targets, no float
//! atomics, no subgroups. Ties and sums are in a fixed order, so one device gives the same bits every time. Other
//! devices, and the CPU, give other bits. A caller that stores results stores [`Gpu::name`](::gpu::Gpu::name) with
//! them.
//!
//! Guarantees, tested on software adapters: within 1e-5 of the CPU in coverage and 1e-6 in the terms of the loss, and
//! in slopes within 1e-3 of the largest, except for pixels with two nearest points, where the slope jumps and either
//! side's value is right. Validation errors, exhausted memory and lost devices are errors, not panics; after one the
//! device is given up ([`Gpu::given_up`](::gpu::Gpu::given_up)). Cost: tracing stays on the CPU, a tenth of the CPU
//! path's time for a mesh of 300 triangles on 256 x 256 pixels. Unsuitable for software adapters where speed matters:
//! lavapipe took 10 to 25 times as long as the CPU path on two busy cores, llvmpipe's OpenGL 30 times.

mod job;
mod images;

pub use images::{DrawnImages, GpuSilhouettes};
pub use job::LARGEST_SIDE_PX;

#[cfg(test)]
mod tests;
