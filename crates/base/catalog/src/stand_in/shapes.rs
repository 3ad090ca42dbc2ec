//! The hidden categories that build stand-ins, one per family (`config/catalog/stand_in_shapes.toml`).

use std::collections::BTreeMap;
use std::sync::LazyLock;

use serde::Deserialize;

use super::solids;
use crate::{Category, Generator};
use geometry::Rgb;

/// Name of the category and the function that builds it.
pub(crate) const GENERATORS: &[(&str, Generator)] = &[
    ("stand_in_box", solids::block),
    ("stand_in_cylinder", solids::can),
    ("stand_in_bottle", solids::bottle),
    ("stand_in_bowl", solids::bowl),
    ("stand_in_produce", solids::produce),
    ("stand_in_plate", solids::plate),
    ("stand_in_rod", solids::rod),
    ("stand_in_pillow", solids::pillow),
    ("stand_in_figure", solids::figure),
    ("stand_in_plant", solids::plant),
    ("stand_in_ring", solids::ring),
];

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ShapeFile {
    /// Hexadecimal color by substance.
    colors: BTreeMap<String, String>,
    category: Vec<Category>,
}

static SHAPES: LazyLock<ShapeFile> = LazyLock::new(|| {
    toml::from_str(include_str!("../../../../../config/catalog/stand_in_shapes.toml"))
        .expect("the built-in shapes parse (a test loads them)")
});

/// The categories of all families. They are no words of a request.
pub(crate) fn hidden_categories() -> &'static [Category] {
    &SHAPES.category
}

/// Whether a category of that name is a stand-in for what the catalog lacks.
pub fn is_stand_in(category_name: &str) -> bool {
    SHAPES.category.iter().any(|category| category.name == category_name)
}

/// Color of a stand-in of that substance.
pub(super) fn usual_color(substance: &str) -> Option<Rgb> {
    let digits = SHAPES.colors.get(substance)?.strip_prefix('#')?;
    u32::from_str_radix(digits, 16).ok().map(Rgb::hex)
}
