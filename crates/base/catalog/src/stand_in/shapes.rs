//! The hidden categories that build stand-ins, one per family (`config/catalog/stand_in_shapes.toml`).

use std::sync::LazyLock;

use crate::Category;
use crate::category::with_unread_shapes;

static CATEGORIES: LazyLock<Vec<Category>> =
    LazyLock::new(|| with_unread_shapes(include_str!("../../../../../config/catalog/stand_in_shapes.toml")));

/// The categories of all families. They are no words of a request.
pub(crate) fn hidden_categories() -> &'static [Category] {
    &CATEGORIES
}

/// Whether a category of that name is a stand-in for what the catalog lacks.
pub fn is_stand_in(category_name: &str) -> bool {
    CATEGORIES.iter().any(|category| category.name == category_name)
}
