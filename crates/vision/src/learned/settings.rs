//! Knobs of [`read_with_network`](super::read_with_network).

use serde::{Deserialize, Serialize};

/// Sizes and thresholds of the reading of a picture. The values named as usual were chosen on pictures of the painter's
/// validation split.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct NetworkReadingSettings {
    /// Longer side of the copy on which edges are followed and solids fitted, pixels, 256..1536; more follows finer edges
    /// and costs in proportion to the area. Usual: 768.
    pub work_px: u32,
    /// Least share of the picture the table top must fill, 0..1. Usual: 0.03.
    pub min_table_share: f64,
    /// Least share of the picture an object must fill, 0..1. Usual: 0.0003.
    pub min_object_share: f64,
    /// How much of a middle of an object a place must be, 0..1; less finds fainter things and splits others. Usual: 0.2.
    pub least_middle: f64,
    /// Least probability of being a whole thing at which a region is believed, 0..1; less finds more things and invents
    /// more. Usual: 0.3.
    pub least_belief: f64,
    /// Width of the rim along which the network's masks are not believed, pixels of its maps, 0..2. Usual: 0.5.
    pub mask_rim: f64,
    /// Most objects that are believed, 1..64. Usual: 48.
    pub max_objects: u32,
}

#[cfg(test)]
impl NetworkReadingSettings {
    /// As `config/default.toml` has them.
    pub(crate) fn usual() -> Self {
        Self {
            work_px: 768,
            min_table_share: 0.03,
            min_object_share: 0.0003,
            least_middle: 0.2,
            least_belief: 0.3,
            mask_rim: 0.5,
            max_objects: 48,
        }
    }
}
