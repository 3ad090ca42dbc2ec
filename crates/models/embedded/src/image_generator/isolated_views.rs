//! Isolated views: each object rendered without the others from the camera of the reference image.

use rayon::prelude::*;

use super::Settings;
use super::objects::SceneObject;
use super::render_scene::RenderScene;
use geometry::Camera;
use imaging::{Image, Mask};
use ports::{Completion, IsolatedRender, ProviderError};
use render::{Background, RenderObject, RenderSettings, SceneCache, View, silhouette};
use runtime::CancelFlag;
use scene::InstanceMask;

/// Free border around the silhouette, as a share of its longer side.
const BORDER: f64 = 0.08;

/// One completion for each object, in order.
pub(super) fn render(
    scene: &RenderScene,
    objects: &[SceneObject],
    visible: &[InstanceMask],
    settings: &Settings,
    cancel: &CancelFlag,
) -> Result<Vec<IsolatedRender>, ProviderError> {
    (0..objects.len())
        .into_par_iter()
        .map(|k| {
            cancel.check()?;
            let object = scene.placed_objects()[k];
            let silhouette = silhouette(object, &View::Perspective(scene.camera));
            let (image, crop_px) = close_up(scene, object, &silhouette, settings);
            let total_px = silhouette.area_px();
            let occluded_px = silhouette
                .bits()
                .iter()
                .zip(visible[k].visible.bits())
                .filter(|(inside, shows)| **inside && !**shows)
                .count();
            let completed_share = if total_px == 0 { 0.0 } else { occluded_px as f64 / total_px as f64 };
            let completion =
                Completion { image, crop_px, silhouette, completed_share, completed_by: Vec::new() };
            Ok(IsolatedRender { id: objects[k].spec.id.clone(), completion })
        })
        .collect()
}

/// The crop around the silhouette, enlarged, transparent outside the object; and its box in the image.
fn close_up(
    scene: &RenderScene,
    object: RenderObject,
    silhouette: &Mask,
    settings: &Settings,
) -> (Image, [f64; 4]) {
    let [x0, y0, x1, y1] = silhouette.bbox_px().unwrap_or([0, 0, 1, 1]).map(f64::from);
    let border = (BORDER * (x1 - x0).max(y1 - y0)).max(1.0);
    let (x0, y0) = ((x0 - border).floor(), (y0 - border).floor());
    let (x1, y1) = ((x1 + border).ceil(), (y1 + border).ceil());
    let scale = (f64::from(settings.image_generator.alone_px) / (x1 - x0).max(y1 - y0)).max(1.0);
    let camera = Camera {
        width_px: ((x1 - x0) * scale).round().max(1.0) as u32,
        height_px: ((y1 - y0) * scale).round().max(1.0) as u32,
        fx: scene.camera.fx * scale,
        fy: scene.camera.fy * scale,
        cx: (scene.camera.cx - x0) * scale,
        cy: (scene.camera.cy - y0) * scale,
        ..scene.camera
    };
    let background = Background { floor: None, ..scene.background };
    let scene_cache = SceneCache::new(vec![object], &reduced_quality(&settings.render));
    let frame = scene_cache.render(scene.lighting, background, &View::Perspective(camera));
    let mut image = frame.color;
    for (pixel, id) in image.as_rgba_mut().chunks_exact_mut(4).zip(&frame.ids) {
        if *id == 0 {
            pixel.fill(0);
        }
    }
    (image, [x0, y0, x1, y1])
}

/// One sample for each pixel, so that no pixel mixes object and background, and small maps for a single object.
fn reduced_quality(settings: &RenderSettings) -> RenderSettings {
    RenderSettings {
        supersampling: 1,
        shadow_map_px: settings.shadow_map_px.min(512),
        sky_directions: settings.sky_directions.min(12),
        sky_map_px: settings.sky_map_px.min(96),
    }
}
