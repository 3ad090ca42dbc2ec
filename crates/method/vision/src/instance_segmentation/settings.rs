//! Settings of [`read_with_network`](super::read_with_network).

use serde::{Deserialize, Serialize};

/// Sizes and thresholds of the image reader. The defaults were chosen on synthetic validation images.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct NetworkReadingSettings {
    /// Longer side of the copy in which edges are followed and primitives fitted, pixels, 256..1536. More follows
    /// finer edges; the cost is proportional to the area.
    pub work_px: u32,
    /// Minimum share of the image that the table top fills, 0..1.
    pub min_table_share: f64,
    /// Minimum share of the image that an object fills, 0..1.
    pub min_object_share: f64,
    /// Minimum center-heatmap value for a peak, 0..1. Lower: higher recall, more split instances.
    pub min_center: f64,
    /// Minimum objectness of an accepted region, 0..1. Lower: higher recall, lower precision.
    pub min_score: f64,
    /// Width of the mask rim that is eroded before regrowth, map cells, 0..2.
    pub mask_rim: f64,
    /// Maximum number of objects, 1..64.
    pub max_objects: u32,
}
