//! Objects ready to be painted from many sides and in any light.

use super::bands::{self, Besides, Front, Light};
use super::scenery::Scenery;
use super::sky::Sky;
use super::{Background, Frame, GeometryFrame, Lighting, RenderObject, RenderSettings, View};
use imaging::Image;

/// Objects in their places with what depends on nothing else: how much of the sky reaches where. Painting a
/// scene from seven sides makes that once.
pub struct Diorama<'a> {
    pub(super) scenery: Scenery<'a>,
    pub(super) sky: Sky,
    pub(super) settings: RenderSettings,
}

impl<'a> Diorama<'a> {
    pub fn new(objects: Vec<RenderObject<'a>>, settings: &RenderSettings) -> Self {
        let scenery = Scenery::new(objects);
        let sky = Sky::new(&scenery, settings);
        Self { scenery, sky, settings: settings.clone() }
    }

    /// The color of the same picture as [`super::render`] of these objects.
    pub fn color(&self, lighting: Lighting, background: Background, view: &View) -> Image {
        self.painted(lighting, background, view, Besides::Nothing).0
    }

    /// The same picture as [`super::render`] of these objects, without normals.
    pub fn paint(&self, lighting: Lighting, background: Background, view: &View) -> Frame {
        let (color, Front { depth_m, ids, .. }) = self.painted(lighting, background, view, Besides::Geometry);
        Frame { color, depth_m, normals: None, ids }
    }

    /// The same picture with normals.
    pub fn paint_with_normals(&self, lighting: Lighting, background: Background, view: &View) -> Frame {
        let (color, Front { depth_m, ids, normals }) =
            self.painted(lighting, background, view, Besides::GeometryAndNormals);
        Frame { color, depth_m, normals: Some(normals), ids }
    }

    /// Depth and ids alone, as [`super::render_geometry`] gives them.
    pub fn measure(&self, view: &View) -> GeometryFrame {
        bands::measure(&self.scenery, view)
    }

    fn painted(
        &self,
        lighting: Lighting,
        background: Background,
        view: &View,
        besides: Besides,
    ) -> (Image, Front) {
        let light = Light { sky: &self.sky, lighting, background };
        bands::paint(&self.scenery, &light, view, &self.settings, besides)
    }
}
