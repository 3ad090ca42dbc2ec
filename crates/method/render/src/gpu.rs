//! GPU rendering through `wgpu` compute: the same images as [`SceneCache`](crate::SceneCache), within a stated
//! tolerance.
//!
//! [`Compute`] is the device of the process, [`Gpu`] an opened device, [`GpuSceneCache`] a scene uploaded to it. Data
//! that does not depend on the view is prepared on the CPU (light maps of the sky, mipmaps, which meshes are closed)
//! and uploaded once. The key light's map and the floor's light, whose size is bounded, are prepared on the CPU for
//! each image. The device projects and clips triangles, finds the visible triangle at each sample (visible.wgsl) and
//! shades it (shade.wgsl and the files it uses, one file per CPU file). A few words per pixel return.
//!
//! Method: small triangles are drawn by one thread each, large ones by tiles of 16 x 16 pixels, a workgroup each.
//! Depth keys are unsigned numbers in the order of floats, so integer maxima find the nearest, and a second pass finds
//! the first triangle that has it, as on the CPU and independent of thread order. Glass is a list of layers per pixel,
//! blended from far to near as on the CPU; sky light is shared by blocks of 2 x 2 pixels, as there. Images are drawn
//! in strips of about a million pixels, so that memory and the time of one dispatch are bounded.
//!
//! Portable: storage buffers (four per shader) and 32-bit integer atomics only, the limits of OpenGL ES 3.1 but for
//! the size of buffers; no render targets, float atomics or subgroups. One device gives the same bits every time;
//! another device, or the CPU, gives other bits. A caller that stores images stores [`Gpu::name`] with them.
//!
//! Errors are values, never panics: no adapter, an image or scene that does not fit (the device remains usable), and
//! anything a driver refuses, after which the device is given up ([`Gpu::given_up`]).
//!
//! Agreement with the CPU, for catalog objects (textured, metallic, glass) and plain shapes on a table, in four views
//! of 192 x 144 pixels with 1 and 2 samples along a pixel's side, on a plain backdrop and in rooms of all floors,
//! measured on lavapipe and on llvmpipe's OpenGL (rooms on the latter): no id differs; depths differ by more than a
//! relative 1e-4, and normals by more than a degree, at 1 pixel in 110,000; bytes of color differ by 0.0045 on average,
//! and not at all in 999 of 1000. The tests allow ids to differ
//! at 1 in 1000 and beside an edge; depths and normals at 1 in 5000; bytes by 0.02 on average, 1 in 99 of 100, 4 in
//! 999 of 1000. The margin is for devices that fuse multiplications and approximate exponentials, on which none of
//! this was measured. One difference is by design: slopes of keys and areas of triangles are f64 on the CPU, which
//! shaders lack, so slivers may be lost.
//!
//! Unsuitable for small images of depth and ids alone, whose upload costs more than they do, and for software adapters
//! where speed matters: compiling alone takes them seconds.
//!
//! A program that was built without the feature `wgpu` has no device, and no scene on one.

#[cfg(feature = "wgpu")]
mod scene_cache;
#[cfg(not(feature = "wgpu"))]
mod no_scene_cache;
#[cfg(feature = "wgpu")]
mod job;
#[cfg(feature = "wgpu")]
mod kernels;
#[cfg(feature = "wgpu")]
mod light_words;
#[cfg(feature = "wgpu")]
mod scene_words;
#[cfg(feature = "wgpu")]
mod words;

pub use gpu::{Compute, ComputeSettings, DeviceChoice, Gpu, GpuError};
#[cfg(not(feature = "wgpu"))]
pub use no_scene_cache::GpuSceneCache;
#[cfg(feature = "wgpu")]
pub use scene_cache::GpuSceneCache;

#[cfg(all(test, feature = "wgpu"))]
mod tests;
