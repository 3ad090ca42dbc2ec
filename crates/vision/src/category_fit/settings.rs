//! Knobs of the comparison with the catalog.

use serde::{Deserialize, Serialize};

/// Section `[category_fit]`: how things in photographs are named.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct CategoryFitSettings {
    /// Meshes that are fitted to each thing, 1..64; more finds odd views of things and costs in proportion. Usual: 18.
    pub candidates: u32,
    /// Most by which a picture's scale may be off, natural logarithm, 0.1..1.5; more looks at more categories and
    /// takes large things for small ones. Usual: 0.8.
    pub most_oversize: f64,
    /// Probability from which a thing is given the name of a category, 0..1; less names more things and more of them
    /// wrongly. 1 names none and looks at nothing. Usual: 0.6, chosen on painted validation pictures.
    pub least_confidence: f64,
}

#[cfg(test)]
impl CategoryFitSettings {
    /// As `config/default.toml` has them.
    pub(crate) fn usual() -> Self {
        Self { candidates: 18, most_oversize: 0.8, least_confidence: 0.6 }
    }
}
