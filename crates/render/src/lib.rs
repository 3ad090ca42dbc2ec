//! The renderer: color, depth, normals and instance ids of a scene in one pass, on the CPU.
//!
//! [`render`] paints a product picture (soft key light with shadows, sky light with ambient occlusion,
//! metallic-roughness surfaces, glass); [`render_geometry`] gives depth and ids alone, much cheaper, for
//! masks and alignment. Both need no GPU, no display and no system library. The inner loops are eight
//! lanes wide (`wide`), the picture is cut into horizontal bands that run on rayon; the result is the
//! same to the byte with any number of threads. [`reference`] is the slow, obvious version the fast one
//! is tested against; [`overlay`] draws boxes, outlines, curves and labels onto finished pictures;
//! [`gpu`] paints the same pictures on a GPU, within a stated tolerance; [`soft`] draws silhouettes blurred at
//! their outline, with derivatives, for fitting poses by descent.
//!
//! Frames and units: world frame as everywhere (meters, +z up), cameras as [`Camera`] (OpenCV axes,
//! pixel centers at +0.5), depth along the optical axis in meters, numbers `f32`.

mod bands;
mod diorama;
mod environment;
mod film;
mod floor_light;
mod frame;
pub mod gpu;
mod light_map;
pub mod lighting;
mod lit_band;
mod looks;
mod one_sided;
pub mod overlay;
mod prepare;
mod projection;
mod raster;
pub mod reference;
mod scenery;
mod settings;
mod shade;
pub mod side_views;
mod silhouette;
mod sky;
mod sky_group;
mod texture_map;
mod tone;
mod view;

pub use diorama::Diorama;
pub use frame::{Frame, GeometryFrame};
pub use lighting::{Background, Floor, Lighting};
pub use settings::RenderSettings;
pub use silhouette::silhouette;
pub use view::{TopView, View};

use geometry::{Pose, TexturedMesh};

/// One mesh placed in the world.
#[derive(Clone, Copy, Debug)]
pub struct RenderObject<'a> {
    pub mesh: &'a TexturedMesh,
    pub world_from_object: Pose,
    /// What [`Frame::ids`] says where this object is in front; 1 and up (0 is the background).
    pub id: u32,
}

/// What there is to see.
#[derive(Clone, Debug)]
pub struct RenderScene<'a> {
    pub objects: Vec<RenderObject<'a>>,
    pub lighting: Lighting,
    pub background: Background,
}

/// Paints the scene: color, depth, normals and ids.
///
/// Glass (opacity below 1) counts as a surface for depth, normals and ids; in color what lies behind
/// shines through. Several pictures of one scene are cheaper as a [`Diorama`].
pub fn render(scene: &RenderScene, view: &View, settings: &RenderSettings) -> Frame {
    Diorama::new(scene.objects.clone(), settings).paint_with_normals(scene.lighting, scene.background, view)
}

/// Depth and ids only: no light, no color.
pub fn render_geometry(objects: &[RenderObject], view: &View) -> GeometryFrame {
    bands::measure(&scenery::Scenery::new(objects.to_vec()), view)
}

#[cfg(test)]
mod tests;
