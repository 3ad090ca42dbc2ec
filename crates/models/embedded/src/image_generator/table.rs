//! The table of a description: specification to mesh.

use glam::DVec3;

use super::error;
use crate::text_parser::{color_of_word, table_shape};
use catalog::{TableModel, build_cached_table, table_models};
use geometry::{Outline, TexturedMesh};
use ports::ProviderError;
use runtime::seed::child_seed;
use scene::request::MAX_SEED;
use scene::{RecognizedTable, TableSpec};

/// A built table with its recognized attributes.
pub struct SceneTable {
    pub recognized: RecognizedTable,
    /// World frame: top at z = 0.
    pub mesh: TexturedMesh,
    pub outline: Outline,
}

/// Builds the table of a specification. Open attributes default to the first catalog model that fits, at its
/// mean size.
///
/// # Errors
///
/// `Rejected` with the code `not_in_catalog` if no catalog model fits the specification.
pub fn build_scene_table(spec: &TableSpec, seed: u64) -> Result<SceneTable, ProviderError> {
    let fits = |model: &&TableModel| match (&spec.model, spec.shape) {
        (Some(name), _) => model.name == name,
        (None, shape) => shape.is_none() || table_shape(model.shape) == shape,
    };
    let unknown = || error::unknown("table", spec.model.as_deref().unwrap_or("of that shape"));
    let model = table_models().iter().find(fits).ok_or_else(unknown)?;
    let size_m: DVec3 = spec.size_m.unwrap_or(0.5 * (model.low_m + model.high_m));
    let recognized = RecognizedTable {
        label: model.label.to_owned(),
        shape: table_shape(model.shape).ok_or_else(unknown)?,
        model: model.name.to_owned(),
        outline_m: None,
        size_m,
        color: spec.color.as_deref().and_then(color_of_word),
        material: spec.material.clone(),
        seed: child_seed(seed, "table") & MAX_SEED,
    };
    let built = build_cached_table(
        &recognized.model,
        size_m,
        recognized.color,
        recognized.material.as_deref(),
        recognized.seed,
    )
    .ok_or_else(unknown)?;
    Ok(SceneTable { recognized, mesh: built.mesh.clone(), outline: built.outline_m.clone() })
}
