//! Settings of the category fit.

use serde::{Deserialize, Serialize};

/// Section `[category_fit]`: classification of objects in images.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct CategoryFitSettings {
    /// Guesses of the recognizer whose meshes are fitted to an object, 1..64; the cost is proportional.
    pub candidates: u32,
    /// Maximum error of the image's scale, natural logarithm, 0.1..1.5. More tries more categories and confuses
    /// sizes.
    pub max_oversize: f64,
    /// Minimum probability of an assigned category, 0..1. Less names more objects, and more of them wrongly. 1
    /// disables the classification. The default was chosen on photographs and on synthetic images.
    pub min_confidence: f64,
}
