//! The reference renderer: a path tracer for the scenes, materials and lights of [`render`](crate::render).
//!
//! It is unbiased for this description, which the others approximate: light passes between objects any number of times,
//! shadows and reflections are those of the geometry, and white surfaces lose no light. Three conventions are part of
//! the description. The eye sees the backdrop with its near walls, reflections see the room that lights the scene.
//! Glass bends what is seen through it, and passes light to other surfaces straight. Opacity is tint, and beyond 0.4
//! also a body ([`glass`]). Paths end after `max_bounces`, which is the one bias: at 24 it is 0.05 % of the light of a
//! table with wine glasses. Nothing is clamped.
//!
//! Pixels are independent, so the result does not depend on the number of threads. [`PathTracer::image`] takes about
//! two microseconds per sample and core in scenes of some ten thousand triangles.

mod albedo_table;
mod backdrop_seen;
mod bvh;
mod ggx;
mod glass;
mod key_light;
mod lobes;
mod sequence;
mod sky_light;
mod traced_scene;
mod walk;

use std::sync::atomic::{AtomicU64, Ordering};

use glam::{Affine3A, Vec3, Vec3A};
use rayon::prelude::*;

use crate::forward::backdrop::Ray;
use crate::forward::projection::{Lens, NEAR_M, Projection};
use crate::{RenderScene, View};
use backdrop_seen::BackdropSeen;
use imaging::Image;
use imaging::srgb::encode_srgb;
use key_light::KeyLight;
use sequence::Samples;
use sky_light::SkyLight;
use traced_scene::TracedScene;
use walk::{EyeRay, Walk};

/// Side of the squares of pixels that are rendered at once.
const TILE_PX: u32 = 16;

/// Quality of [`path_trace`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PathTraceSettings {
    /// More gives less noise, which falls with the square root; powers of two are spread most evenly.
    pub samples_per_pixel: u32,
    /// Largest number of surfaces that a path meets, each side of glass being one.
    pub max_bounces: u32,
    /// Selects the random numbers; another one gives other noise.
    pub seed: u64,
}

impl PathTraceSettings {
    /// Surfaces that paths meet in images for comparison.
    pub const MANY_BOUNCES: u32 = 24;
}

/// An image as light and as color.
#[derive(Clone, Debug, PartialEq)]
pub struct TracedImage {
    /// Mean light of each pixel after exposure and before the tone curve, linear, row by row from the top.
    pub light: Vec<Vec3>,
    /// After the tone curve of the forward renderer.
    pub color: Image,
}

/// A scene ready to be traced from any view.
pub struct PathTracer<'a> {
    scene: TracedScene<'a>,
    backdrop: BackdropSeen,
    key: KeyLight,
    sky: SkyLight,
    exposure: f32,
}

/// Renders one image of a scene.
pub fn path_trace(scene: &RenderScene, view: &View, settings: &PathTraceSettings) -> TracedImage {
    PathTracer::new(scene).image(view, settings, |_, _| ())
}

impl<'a> PathTracer<'a> {
    /// Prepares geometry and lights.
    pub fn new(scene: &RenderScene<'a>) -> Self {
        let traced = TracedScene::new(scene.objects.clone());
        let backdrop = BackdropSeen::new(&traced.scene_buffers, scene.lighting, scene.background);
        let sky = SkyLight::new(&backdrop.environment);
        let key = KeyLight::new(&scene.lighting);
        Self { scene: traced, backdrop, key, sky, exposure: scene.lighting.exposure }
    }

    /// Renders an image. `watch` receives the numbers of tiles that are done and of all, on any thread.
    pub fn image(
        &self,
        view: &View,
        settings: &PathTraceSettings,
        watch: impl Fn(u64, u64) + Sync,
    ) -> TracedImage {
        let (width, height) = (view.width_px(), view.height_px());
        let columns = width.div_ceil(TILE_PX);
        let tiles = columns * height.div_ceil(TILE_PX);
        let done = AtomicU64::new(0);
        let traced: Vec<Vec<Vec3>> = (0..tiles)
            .into_par_iter()
            .with_max_len(1)
            .map(|tile| {
                let low = [tile % columns * TILE_PX, tile / columns * TILE_PX];
                let light = self.tile(view, low, settings);
                watch(done.fetch_add(1, Ordering::Relaxed) + 1, u64::from(tiles));
                light
            })
            .collect();
        let curve = self.backdrop.environment.tone_curve();
        let (mut light, mut rgba) = (Vec::new(), Vec::new());
        for (y, x) in (0..height).flat_map(|y| (0..width).map(move |x| (y, x))) {
            let tile = &traced[(y / TILE_PX * columns + x / TILE_PX) as usize];
            let tile_width = TILE_PX.min(width - x / TILE_PX * TILE_PX);
            let seen = tile[(y % TILE_PX * tile_width + x % TILE_PX) as usize];
            light.push(seen);
            let shown = curve.apply(seen);
            rgba.extend([encode_srgb(shown.x), encode_srgb(shown.y), encode_srgb(shown.z), 255]);
        }
        let color = Image::from_rgba(width, height, rgba).expect("there is one color for each pixel");
        TracedImage { light, color }
    }

    /// Light of the pixels of a tile, row by row.
    fn tile(&self, view: &View, low: [u32; 2], settings: &PathTraceSettings) -> Vec<Vec3> {
        let projection = Projection::new(view, 1);
        let eye = Eye {
            lens: projection.lens,
            world_from_camera: projection.world_from_camera(),
            height_px: projection.height_px as f32,
        };
        let walk = Walk {
            scene: &self.scene,
            key: &self.key,
            sky: &self.sky,
            backdrop: &self.backdrop,
            max_bounces: settings.max_bounces,
        };
        let (width, height) = (view.width_px(), view.height_px());
        let rows = low[1]..(low[1] + TILE_PX).min(height);
        rows.flat_map(|y| (low[0]..(low[0] + TILE_PX).min(width)).map(move |x| (x, y)))
            .map(|(x, y)| {
                let mut sum = Vec3::ZERO;
                for index in 0..settings.samples_per_pixel.max(1) {
                    let mut samples = Samples::new(settings.seed, y * width + x, index);
                    let at = samples.pair();
                    let ray = eye.ray(x as f32 + at.x, y as f32 + at.y);
                    sum += walk.light(&ray, &mut samples);
                }
                sum * (self.exposure / settings.samples_per_pixel.max(1) as f32)
            })
            .collect()
    }
}

/// Origin of the rays of a view.
struct Eye {
    lens: Lens,
    world_from_camera: Affine3A,
    height_px: f32,
}

impl Eye {
    /// The ray through a position in the image, pixels.
    fn ray(&self, x: f32, y: f32) -> EyeRay {
        let (origin, direction) = self.lens.ray(x, y);
        let direction = self.world_from_camera.transform_vector3a(Vec3A::from(direction));
        let near = if self.lens.perspective { NEAR_M } else { 0.0 };
        let origin = self.world_from_camera.transform_point3a(Vec3A::from(origin)) + near * direction;
        let at_eye = self.lens.pixel_size_m(0.0);
        EyeRay {
            ray: Ray { origin, direction },
            fraction: y / self.height_px,
            pixel_size_m: [at_eye, self.lens.pixel_size_m(1.0) - at_eye],
        }
    }
}

#[cfg(test)]
mod tests;
