//! Objects ready to be painted from many sides and in any light.

use super::bands::{self, Light};
use super::sky::Sky;
use super::{Background, Frame, GeometryFrame, Lighting, RenderObject, RenderSettings, View};

/// Objects in their places with what depends on nothing else: how much of the sky reaches where. Painting a
/// scene from seven sides makes that once.
pub struct Diorama<'a> {
    objects: Vec<RenderObject<'a>>,
    sky: Sky,
    settings: RenderSettings,
}

impl<'a> Diorama<'a> {
    pub fn new(objects: Vec<RenderObject<'a>>, settings: &RenderSettings) -> Self {
        let sky = Sky::new(&objects, settings);
        Self { objects, sky, settings: settings.clone() }
    }

    /// The same picture as [`super::render`] of these objects, without normals.
    pub fn paint(&self, lighting: Lighting, background: Background, view: &View) -> Frame {
        self.frame(lighting, background, view, false)
    }

    /// Depth and ids alone, as [`super::render_geometry`] gives them.
    pub fn measure(&self, view: &View) -> GeometryFrame {
        bands::measure(&self.objects, view)
    }

    pub(super) fn frame(
        &self,
        lighting: Lighting,
        background: Background,
        view: &View,
        normals: bool,
    ) -> Frame {
        let light = Light { sky: &self.sky, lighting, background };
        bands::paint(&self.objects, &light, view, &self.settings, normals)
    }
}
