//! What is drawn on a GPU: devices, and the renderer's pictures, through `wgpu` compute.
//!
//! [`Compute`] is a process's device, [`Gpu`] one that was opened; [`super::soft::gpu`] draws soft silhouettes on it,
//! [`GpuDiorama`] the pictures of a [`Diorama`](super::Diorama). The split: what does not depend on the view stays the
//! CPU's (light maps of the sky, textures' halved versions, which meshes are closed) and is uploaded once; of each
//! picture it makes the key light's map and the floor's light, whose size is bounded. The device projects and clips
//! triangles, finds what is in front at each sample (visible.wgsl), and shades it (shade.wgsl and what it stands on,
//! one file per CPU file), so that a few words a pixel come back.
//!
//! Method: small triangles are drawn one a thread, large ones by tiles of 16 x 16 pixels, a workgroup each. Depth keys
//! are unsigned numbers in the order of floats, so integer maxima find the nearest, and a second pass the first
//! triangle that has it: like the CPU, whatever order threads run in. Glass is a list of layers a pixel, laid over from
//! far to near as on the CPU; light from the sky is shared by blocks of 2 x 2 pixels, as there. Pictures are drawn in
//! strips of about a million pixels, so that memory and the time of one dispatch are bounded.
//!
//! Portable: storage buffers (four a shader) and 32-bit integer atomics only, the limits of OpenGL ES 3.1 but for the
//! size of buffers, no render targets, no float atomics, no subgroups. One device gives the same bits every time;
//! another, or the CPU, gives others: whoever keeps pictures keeps [`Gpu::name`] with them.
//!
//! Errors are values, never panics: no adapter, a picture or scene that does not fit (the device remains good), and
//! anything a driver refuses, after which the device is given up ([`Gpu::given_up`]).
//!
//! Agreement with the CPU, on a table laid with things of the catalog (textured, metallic, glass) and plain shapes, in
//! four views of 192 x 144 pixels with 1 and 2 samples along a pixel's side. Measured on lavapipe and on llvmpipe's
//! OpenGL: no id of 220,000 differs, depths differ by more than 1e-4 of themselves, and normals by more than a degree,
//! at 1 pixel in 110,000, and bytes of color by 0.0034 on average, not at all in 999 of 1000. Tested: ids but for 1 in
//! 1000, and those beside an edge; depths and normals but for 1 in 5000; bytes within 0.02 on average, 1 in 99 of 100,
//! 4 in 999 of 1000. The room is for devices that fuse multiplications and approximate exponentials, on which none of
//! this was measured. One place differs by design: keys' slopes and triangles' areas are f64 on the CPU, which shaders
//! do not have, so slivers may be lost.
//!
//! Not for small pictures of depth and ids alone, whose upload costs more than they do, and not for software adapters
//! where speed matters: compiling alone takes them seconds.

mod diorama;
mod job;
mod kernels;
mod light_words;
mod scene_words;
mod words;

pub use diorama::GpuDiorama;
pub use gpu::{Compute, ComputeSettings, DeviceChoice, Gpu, GpuError};

#[cfg(test)]
mod tests;
