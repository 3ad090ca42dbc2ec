//! The same arrangement from straight above.

use rayon::prelude::*;

use super::Settings;
use super::props::Prop;
use super::stage::{Stage, TABLE};
use super::table::PaintedTable;
use ports::{KnownTop, ProviderError, TopPicture};
use render::{TopView, View, silhouette};
use runtime::Interrupt;
use scene::InstanceMask;

/// Free border around the table, as a share of its longer side.
const BORDER: f64 = 0.06;

/// The orthographic picture with whole outlines of the table and of every prop.
pub(super) fn paint(
    stage: &Stage,
    props: &[Prop],
    table: &PaintedTable,
    settings: &Settings,
    interrupt: &Interrupt,
) -> Result<TopPicture, ProviderError> {
    let view = View::Orthographic(view_of(stage, table, settings.painter.top_px));
    let picture = stage.color_from(&view);
    interrupt.check()?;
    let alone = |index: usize| silhouette(stage.objects[index], &view);
    let objects = (0..props.len())
        .into_par_iter()
        .map(|k| {
            interrupt.check()?;
            Ok(InstanceMask { id: props[k].spec.id.clone(), visible: alone(k + 1) })
        })
        .collect::<Result<_, ProviderError>>()?;
    let known = KnownTop { table: alone(TABLE as usize - 1), objects };
    Ok(TopPicture { picture, known: Some(known) })
}

/// The whole table with a border; above everything.
fn view_of(stage: &Stage, table: &PaintedTable, long_px: u32) -> TopView {
    let (low, high) = table.mesh.bounds();
    let size = (high - low).truncate();
    let shown = size + 2.0 * BORDER * size.max_element();
    let meters_per_px = shown.max_element() / f64::from(long_px);
    let highest = stage
        .props()
        .iter()
        .map(|prop| {
            // No matter how it lies, it reaches no higher than its diagonal.
            prop.world_from_object.translation_m.z + prop.mesh.size_m().length()
        })
        .fold(0.0, f64::max);
    TopView {
        width_px: (shown.x / meters_per_px).round().max(1.0) as u32,
        height_px: (shown.y / meters_per_px).round().max(1.0) as u32,
        meters_per_px,
        center_m: 0.5 * (low + high).truncate(),
        eye_z_m: highest + 0.1,
    }
}
