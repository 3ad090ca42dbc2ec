//! Table models with real legs and outlines.

use glam::DVec3;

use crate::geometry::{Outline, Rgb, TexturedMesh};

/// A kind of table.
#[derive(Clone, Debug)]
pub struct TableModel {
    /// `[a-z0-9_]`.
    pub name: &'static str,
    pub label: &'static str,
    /// Words for it, singular, lower case.
    pub synonyms: &'static [&'static str],
    /// `rectangular`, `square`, `round`, `oval`, `triangular`, `irregular`.
    pub shape: &'static str,
    /// Lowest and highest width, depth, height, meters.
    pub low_m: DVec3,
    pub high_m: DVec3,
    /// Families in which it is usual.
    pub families: &'static [&'static str],
}

/// A table as built: the mesh in the world frame (top surface at z = 0, feet at -height).
pub struct BuiltTable {
    pub mesh: TexturedMesh,
    /// Edge of the top surface.
    pub outline_m: Outline,
}

/// Every table model.
pub fn table_models() -> &'static [TableModel] {
    &[]
}

/// Builds the model at `size_m` (width, depth, height); `None` for an unknown name.
pub fn build_table(
    _name: &str,
    _size_m: DVec3,
    _color: Option<Rgb>,
    _material: Option<&str>,
    _seed: u64,
) -> Option<BuiltTable> {
    None
}
