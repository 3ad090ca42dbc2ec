//! Color, depth, normals and object ids of a scene in one pass, on the CPU or a GPU.
//!
//! [`render`] renders a product image: soft key light with shadows, sky light with ambient occlusion,
//! metallic-roughness surfaces, glass; on a plain backdrop or in a [`Room`], whose light comes from prefiltered maps.
//! [`render_geometry`] gives depth and ids alone, much cheaper, for masks and pose
//! estimation. Both need no GPU, no display and no system library. The inner loops are eight lanes wide (`wide`). The
//! image is cut into horizontal bands that run on rayon; the bytes do not depend on the number of threads.
//! [`ObjectColors`] gives the colors of few pixels, for comparisons. [`mod@reference`] is the slow renderer that the
//! tests compare with. [`annotate`] draws boxes, outlines, curves and labels onto finished images. [`gpu`] renders the
//! same images on a GPU, within a stated tolerance.
//!
//! Frames and units: the world frame is in meters, +z up; cameras are [`geometry::Camera`] (OpenCV axes, pixel centers
//! at +0.5); depth is measured along the optical axis in meters; numbers are `f32`. The crate must not depend on
//! scenes, files, jobs or the catalog.
//!
//! ```
//! use geometry::{Camera, DVec3, Material, Pose, Rgb, TexturedMesh, shapes};
//! use render::{RenderObject, View, render_geometry};
//!
//! let mut mesh = TexturedMesh::default();
//! mesh.add(shapes::sphere(0.06, 40), &Material::plain("gray", Rgb::hex(0x808080), 0.5));
//! let object = RenderObject { mesh: &mesh, world_from_object: Pose::IDENTITY, id: 1 };
//! let camera = Camera::orbit(64, 48, 0.6, DVec3::ZERO, 0.0, 0.7, 0.5);
//! let frame = render_geometry(&[object], &View::Perspective(camera));
//! assert!(frame.ids.contains(&1) && frame.ids.contains(&0));
//! ```

pub mod annotate;
#[cfg_attr(
    not(feature = "wgpu"),
    expect(dead_code, reason = "some functions give the GPU what was prepared on the CPU")
)]
mod forward;
mod frame;
pub mod gpu;
pub mod lighting;
mod object_colors;
pub mod path_trace;
pub mod room;
mod scene_cache;
pub mod sequence;
mod settings;
pub mod side_views;
mod silhouette;
mod tabletop;
mod view;

pub use forward::reference;
pub use frame::{Frame, GeometryFrame};
pub use lighting::{Background, Floor, Lighting};
pub use object_colors::{ObjectColors, PixelColors};
pub use path_trace::{PathTraceSettings, PathTracer, TracedImage, path_trace};
pub use room::{Decor, FloorFinish, Room};
pub use scene_cache::SceneCache;
pub use sequence::ImageSequence;
pub use settings::RenderSettings;
pub use silhouette::silhouette;
pub use tabletop::Tabletop;
pub use view::{TopView, View};

use geometry::{Pose, TexturedMesh};

/// One mesh placed in the world.
#[derive(Clone, Copy, Debug)]
pub struct RenderObject<'a> {
    pub mesh: &'a TexturedMesh,
    pub world_from_object: Pose,
    /// Value of [`Frame::ids`] where this object is visible, 1 and up; 0 is the background.
    pub id: u32,
}

/// Objects, lighting and background of one image.
#[derive(Clone, Debug)]
pub struct RenderScene<'a> {
    pub objects: Vec<RenderObject<'a>>,
    pub lighting: Lighting,
    pub background: Background,
}

/// Renders color, depth, normals and ids.
///
/// Glass (opacity below 1) counts as a surface for depth, normals and ids; its color is blended with the color behind
/// it. Several images of one scene are cheaper with a [`SceneCache`].
pub fn render(scene: &RenderScene, view: &View, settings: &RenderSettings) -> Frame {
    SceneCache::new(scene.objects.clone(), settings).render_with_normals(
        scene.lighting,
        scene.background,
        view,
    )
}

/// Renders depth and ids only, without lighting.
pub fn render_geometry(objects: &[RenderObject], view: &View) -> GeometryFrame {
    forward::bands::measure(&forward::scene_buffers::SceneBuffers::new(objects.to_vec()), view)
}

#[cfg(test)]
mod tests;
