//! Orthographic top view of the arrangement.

use rayon::prelude::*;

use super::Settings;
use super::objects::SceneObject;
use super::render_scene::{RenderScene, TABLE_ID};
use super::table::SceneTable;
use ports::{ProviderError, TopViewAnnotations, TopViewImage};
use render::{TopView, View, silhouette};
use runtime::CancelFlag;
use scene::InstanceMask;

/// Free border around the table, as a share of its longer side.
const BORDER: f64 = 0.06;

/// The orthographic image with complete silhouettes of the table and of every object.
pub(super) fn render(
    scene: &RenderScene,
    objects: &[SceneObject],
    table: &SceneTable,
    settings: &Settings,
    cancel: &CancelFlag,
) -> Result<TopViewImage, ProviderError> {
    let view = View::Orthographic(view_of(scene, table, settings.image_generator.top_px));
    let image = scene.color_from(&view);
    cancel.check()?;
    let whole = |index: usize| silhouette(scene.placed[index], &view);
    let masks = (0..objects.len())
        .into_par_iter()
        .map(|k| {
            cancel.check()?;
            Ok(InstanceMask { id: objects[k].spec.id.clone(), visible: whole(k + 1) })
        })
        .collect::<Result<_, ProviderError>>()?;
    let known = TopViewAnnotations { table: whole(TABLE_ID as usize - 1), objects: masks };
    Ok(TopViewImage { image, known: Some(known) })
}

/// The view of the whole table with a border, from above the highest object.
fn view_of(scene: &RenderScene, table: &SceneTable, long_px: u32) -> TopView {
    let (low, high) = table.mesh.bounds();
    let size = (high - low).truncate();
    let extent = size + 2.0 * BORDER * size.max_element();
    let meters_per_px = extent.max_element() / f64::from(long_px);
    let highest = scene
        .placed_objects()
        .iter()
        .map(|object| {
            // The diagonal bounds the height in every orientation.
            object.world_from_object.translation_m.z + object.mesh.size_m().length()
        })
        .fold(0.0, f64::max);
    TopView {
        width_px: (extent.x / meters_per_px).round().max(1.0) as u32,
        height_px: (extent.y / meters_per_px).round().max(1.0) as u32,
        meters_per_px,
        center_m: 0.5 * (low + high).truncate(),
        eye_z_m: highest + 0.1,
    }
}
