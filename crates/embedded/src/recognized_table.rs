//! The mesh of a recognized table: a model of the catalog, or a top of the outline that was seen.

use std::sync::Arc;

use catalog::{BuiltTable, build_outlined_table, stocked_table};
use scene::{RecognizedTable, TableShape};

/// Builds it; `None` for a model the catalog does not have, or an outline too narrow for a table.
pub(super) fn built(table: &RecognizedTable) -> Option<Arc<BuiltTable>> {
    let (color, material) = (table.color, table.material.as_deref());
    match &table.outline_m {
        Some(edge) => {
            let legs = if table.shape == TableShape::Triangular { 3 } else { 4 };
            build_outlined_table(edge, table.size_m.z, legs, color, material, table.seed).map(Arc::new)
        }
        None => stocked_table(&table.model, table.size_m, color, material, table.seed),
    }
}
