//! Each object drawn without the others, from the camera of the reference picture.

use rayon::prelude::*;

use super::Settings;
use super::props::Prop;
use super::stage::Stage;
use geometry::Camera;
use imaging::{Image, Mask};
use ports::{Alone, Completion, ProviderError};
use render::{Background, Diorama, RenderObject, RenderSettings, View, silhouette};
use runtime::Interrupt;
use scene::InstanceMask;

/// Free border around the silhouette, as a share of its longer side.
const BORDER: f64 = 0.08;

/// One completion per prop, in order.
pub(super) fn draw(
    stage: &Stage,
    props: &[Prop],
    visible: &[InstanceMask],
    settings: &Settings,
    interrupt: &Interrupt,
) -> Result<Vec<Alone>, ProviderError> {
    (0..props.len())
        .into_par_iter()
        .map(|k| {
            interrupt.check()?;
            let object = stage.props()[k];
            let silhouette = silhouette(object, &View::Perspective(stage.camera));
            let (picture, shown_px) = close_up(stage, object, &silhouette, settings);
            let whole = silhouette.area_px();
            let missing = silhouette
                .bits()
                .iter()
                .zip(visible[k].visible.bits())
                .filter(|(inside, shows)| **inside && !**shows)
                .count();
            let completed_share = if whole == 0 { 0.0 } else { missing as f64 / whole as f64 };
            let completed_by = Vec::new();
            let completion = Completion { picture, shown_px, silhouette, completed_share, completed_by };
            Ok(Alone { id: props[k].spec.id.clone(), completion })
        })
        .collect()
}

/// The part of the picture around the silhouette, enlarged, transparent beside the object.
fn close_up(
    stage: &Stage,
    object: RenderObject,
    silhouette: &Mask,
    settings: &Settings,
) -> (Image, [f64; 4]) {
    let [x0, y0, x1, y1] = silhouette.bbox_px().unwrap_or([0, 0, 1, 1]).map(f64::from);
    let border = (BORDER * (x1 - x0).max(y1 - y0)).max(1.0);
    let (x0, y0) = ((x0 - border).floor(), (y0 - border).floor());
    let (x1, y1) = ((x1 + border).ceil(), (y1 + border).ceil());
    let scale = (f64::from(settings.painter.alone_px) / (x1 - x0).max(y1 - y0)).max(1.0);
    let camera = Camera {
        width_px: ((x1 - x0) * scale).round().max(1.0) as u32,
        height_px: ((y1 - y0) * scale).round().max(1.0) as u32,
        fx: stage.camera.fx * scale,
        fy: stage.camera.fy * scale,
        cx: (stage.camera.cx - x0) * scale,
        cy: (stage.camera.cy - y0) * scale,
        ..stage.camera
    };
    let background = Background { floor: None, ..stage.background };
    let diorama = Diorama::new(vec![object], &small_work(&settings.render));
    let frame = diorama.paint(stage.lighting, background, &View::Perspective(camera));
    let mut picture = frame.color;
    for (pixel, id) in picture.as_rgba_mut().chunks_exact_mut(4).zip(&frame.ids) {
        if *id == 0 {
            pixel.fill(0);
        }
    }
    (picture, [x0, y0, x1, y1])
}

/// One sample a pixel, so that no pixel mixes object and backdrop, and small maps for one small thing.
fn small_work(settings: &RenderSettings) -> RenderSettings {
    RenderSettings {
        supersampling: 1,
        shadow_map_px: settings.shadow_map_px.min(512),
        sky_directions: settings.sky_directions.min(12),
        sky_map_px: settings.sky_map_px.min(96),
    }
}
