//! Cache of the view- and light-independent data of a scene.

use std::sync::Arc;

use super::{Background, Frame, GeometryFrame, Lighting, RenderObject, RenderSettings, View};
use crate::forward::bands::{self, ExtraOutputs, Light, VisibleSurfaces};
use crate::forward::scene_buffers::{SceneBuffers, TriangleFilter};
use crate::forward::sky::Sky;
use crate::forward::surface_colors::SurfaceColors;
use imaging::Image;

/// Placed objects with their sky occlusion, which depends on neither view nor key light. Several images of one scene
/// share it.
pub struct SceneCache<'a> {
    pub(super) scene_buffers: SceneBuffers<'a>,
    pub(super) sky: Sky,
    /// Prepared by [`Self::for_rooms`].
    pub(super) sky_of_rooms: Option<Sky>,
    colors: Arc<SurfaceColors<'a>>,
    pub(super) settings: RenderSettings,
}

impl<'a> SceneCache<'a> {
    pub fn new(objects: Vec<RenderObject<'a>>, settings: &RenderSettings) -> Self {
        let scene_buffers = SceneBuffers::new(objects);
        let sky = Sky::new(&scene_buffers, TriangleFilter::All, settings);
        let colors = Arc::new(SurfaceColors::new(&scene_buffers.objects));
        Self { scene_buffers, sky, sky_of_rooms: None, colors, settings: settings.clone() }
    }

    /// Prepares for images in rooms, whose sky is finer than the settings say. Glass does not shade it: the screen by
    /// which it does would show as dots on what stands beside it. Images without a room remain as they are.
    pub fn for_rooms(mut self) -> Self {
        let finer = RenderSettings {
            sky_directions: self.settings.sky_directions * 3 / 2,
            sky_map_px: self.settings.sky_map_px * 5 / 4,
            ..self.settings.clone()
        };
        self.sky_of_rooms = Some(Sky::new(&self.scene_buffers, TriangleFilter::Opaque, &finer));
        self
    }

    pub(super) fn sky_for(&self, background: &Background) -> &Sky {
        match &self.sky_of_rooms {
            Some(sky) if background.room.is_some() => sky,
            _ => &self.sky,
        }
    }

    /// Color as [`render`](crate::render) gives it for these objects.
    pub fn color(&self, lighting: Lighting, background: Background, view: &View) -> Image {
        self.rendered(lighting, background, view, ExtraOutputs::Nothing).0
    }

    /// Color, depth and ids as [`render`](crate::render) gives them for these objects, without normals.
    pub fn render(&self, lighting: Lighting, background: Background, view: &View) -> Frame {
        let (color, VisibleSurfaces { depth_m, ids, .. }) =
            self.rendered(lighting, background, view, ExtraOutputs::Geometry);
        Frame { color, depth_m, normals: None, ids }
    }

    /// Color, depth, ids and normals as [`render`](crate::render) gives them.
    pub fn render_with_normals(&self, lighting: Lighting, background: Background, view: &View) -> Frame {
        let (color, VisibleSurfaces { depth_m, ids, normals }) =
            self.rendered(lighting, background, view, ExtraOutputs::GeometryAndNormals);
        Frame { color, depth_m, normals: Some(normals), ids }
    }

    /// Depth and ids as [`render_geometry`](crate::render_geometry) gives them.
    pub fn measure(&self, view: &View) -> GeometryFrame {
        bands::measure(&self.scene_buffers, view)
    }

    fn rendered(
        &self,
        lighting: Lighting,
        background: Background,
        view: &View,
        extra: ExtraOutputs,
    ) -> (Image, VisibleSurfaces) {
        let light = Light { sky: self.sky_for(&background), lighting, background };
        bands::render(&self.scene_buffers, self.colors.clone(), &light, view, &self.settings, extra)
    }
}
