//! Settings of the upright search.

use serde::{Deserialize, Serialize};

/// Weights of the evidence; costs are in units of the silhouette loss.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct UprightSettings {
    /// Yaws tried for each up direction, 8..72; more tells finer shapes apart.
    pub yaws: u32,
    /// Side of the silhouettes, pixels, a multiple of 32.
    pub side_px: u32,
    /// Cost per unit of log extent error, above 0; more trusts the commonsense size.
    pub extent_weight: f64,
    /// Extent cost above the minimum beyond which an up direction is not evaluated.
    pub hopeless_extent_cost: f64,
    /// Cost per unit of color disagreement (0..2); more trusts colors over outlines.
    pub appearance_weight: f64,
    /// Number of best silhouettes of an up direction whose colors are compared, 1..8.
    pub color_candidates: u32,
    /// Cost per unit of dissimilarity to the example (0..1); more trusts the example.
    pub example_weight: f64,
    /// Cost per unit of dissimilarity (0..1) of the texture detail on the mesh and on the example; more trusts texture
    /// to tell the sides of an object apart.
    pub detail_weight: f64,
    /// Cost of another up direction than the hinted one; more trusts the hint, less the image.
    pub hint_up_weight: f64,
    /// Cost of another front with the hinted up direction; more trusts the hint, less extents and example.
    pub hint_front_weight: f64,
    /// Lead over the next up direction at which the confidence is one half.
    pub clear_lead: f64,
}
