//! Images of a scene in which some objects move.

use std::ops::Range;
use std::sync::Arc;

use super::{Background, Frame, Lighting, RenderObject, RenderSettings, View};
use crate::forward::bands::{ExtraOutputs, VisibleSurfaces, render_in};
use crate::forward::environment::{Environment, shadows_of};
use crate::forward::scene_buffers::SceneBuffers;
use crate::forward::shade::Surroundings;
use crate::forward::sky::OPEN_SKY;
pub use crate::forward::still_layer::StillLayer;
use crate::forward::surface_colors::SurfaceColors;
use geometry::Pose;
use imaging::Image;

#[cfg(test)]
mod tests;

/// A scene with objects that stay and objects that move, under one light.
///
/// The images share materials, the shadows of what stays, and for each pose the shadows of what moves. A camera that
/// does not move has a [`StillLayer`], with which an image costs little more than what moves. The sky has no shadows:
/// `sky_directions` of the settings are not used. Shadows that fall together from both kinds of objects are multiplied,
/// so where their edges cross they are darker than in [`render`](crate::render).
pub struct ImageSequence<'a> {
    scene_buffers: SceneBuffers<'a>,
    still: Range<usize>,
    moving: Range<usize>,
    surroundings: Surroundings<'a>,
    settings: RenderSettings,
}

impl<'a> ImageSequence<'a> {
    /// A sequence whose moving objects are where they are given. The shadow map has the size of the settings, whatever
    /// the size of images.
    pub fn new(
        still: Vec<RenderObject<'a>>,
        moving: Vec<RenderObject<'a>>,
        lighting: Lighting,
        background: Background,
        settings: &RenderSettings,
    ) -> Self {
        let (first, count) = (still.len(), still.len() + moving.len());
        let scene_buffers = SceneBuffers::new(still.into_iter().chain(moving).collect());
        let (still, moving) = (0..first, first..count);
        let shadow_map_px = settings.shadow_map_px;
        let environment = Environment::of_part(&scene_buffers, &still, &OPEN_SKY, lighting, shadow_map_px)
            .in_room(background.room);
        let colors = Arc::new(SurfaceColors::new(&scene_buffers.objects));
        let surroundings = Surroundings::new(&scene_buffers, environment, background, colors);
        let mut sequence = Self { scene_buffers, still, moving, surroundings, settings: settings.clone() };
        sequence.draw_moving_shadows();
        sequence
    }

    /// Moves the objects that move, in the order in which they were given.
    pub fn move_to(&mut self, world_from_objects: &[Pose]) {
        for (index, pose) in self.moving.clone().zip(world_from_objects) {
            self.scene_buffers.set_pose(index, *pose);
        }
        self.draw_moving_shadows();
    }

    fn draw_moving_shadows(&mut self) {
        let environment = &mut self.surroundings.environment;
        // Finer texels than those of what stays would show no more, and take longer to search.
        let max_texels_per_m =
            environment.key_map.as_ref().map_or(f64::INFINITY, |map| f64::from(map.texels_per_m));
        let (lighting, side_px) = (&environment.lighting, self.settings.shadow_map_px);
        environment.moving_map =
            shadows_of(&self.scene_buffers, &self.moving, lighting, side_px, max_texels_per_m);
    }

    /// The part of a camera's images that is the same in all of them.
    pub fn still_layer(&self, view: &View) -> StillLayer {
        let Self { scene_buffers, still, surroundings, settings, .. } = self;
        StillLayer::new(scene_buffers, still, surroundings, view, settings.supersampling)
    }

    /// Color in a view.
    pub fn color(&self, view: &View) -> Image {
        self.rendered(view, ExtraOutputs::Nothing).0
    }

    /// Color, depth and ids in a view, without normals.
    pub fn render(&self, view: &View) -> Frame {
        let (color, VisibleSurfaces { depth_m, ids, .. }) = self.rendered(view, ExtraOutputs::Geometry);
        Frame { color, depth_m, normals: None, ids }
    }

    fn rendered(&self, view: &View, extra: ExtraOutputs) -> (Image, VisibleSurfaces) {
        render_in(&self.scene_buffers, &self.surroundings, view, self.settings.supersampling, extra)
    }

    /// Color in the view of the layer, which must be of this sequence.
    pub fn color_over(&self, layer: &mut StillLayer) -> Image {
        layer.color(&self.scene_buffers, &self.moving, &self.surroundings)
    }

    /// Color, depth and ids in the view of the layer, which must be of this sequence.
    pub fn render_over(&self, layer: &mut StillLayer) -> Frame {
        let color = self.color_over(layer);
        let VisibleSurfaces { depth_m, ids, .. } = layer.measure(&self.scene_buffers, &self.moving);
        Frame { color, depth_m, normals: None, ids }
    }
}
