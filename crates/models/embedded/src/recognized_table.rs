//! The mesh of a recognized table: a catalog model, or a table top with the recognized outline.

use std::sync::Arc;

use catalog::{BuiltTable, build_cached_table, build_outlined_table};
use scene::{RecognizedTable, TableShape};

/// Builds the table; `None` for a model outside the catalog or an outline too narrow for a table.
pub(super) fn built(table: &RecognizedTable) -> Option<Arc<BuiltTable>> {
    let (color, material) = (table.color, table.material.as_deref());
    match &table.outline_m {
        Some(edge) => {
            let legs = if table.shape == TableShape::Triangular { 3 } else { 4 };
            build_outlined_table(edge, table.size_m.z, legs, color, material, table.seed).map(Arc::new)
        }
        None => build_cached_table(&table.model, table.size_m, color, material, table.seed),
    }
}
