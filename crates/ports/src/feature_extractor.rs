//! Port 5, the feature extractor `Phi`: what a picture looks like, as a unit vector. The paper asks DINOv2.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::{Adapter, Answer, Call};
use imaging::Image;

/// Turns pictures into feature vectors.
pub trait FeatureExtractor: Send + Sync {
    fn adapter(&self) -> Adapter;

    /// The unit-length features of each picture; pictures that look alike have a large dot product. Transparent
    /// pixels do not count; where nothing is opaque, all values are zero.
    fn features<'a>(&'a self, call: &'a Call, pictures: Vec<Arc<Image>>) -> Answer<'a, Vec<Vec<f32>>>;
}

/// Section `[features]`.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct FeatureSettings {
    /// Who answers the port.
    pub adapter: FeatureAdapter,
    /// Folder or file with the weights of an adapter that has some; empty where it has none.
    pub weights: String,
}

/// The adapters there are for the port.
#[derive(Clone, Copy, Debug, Serialize, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
pub enum FeatureAdapter {
    /// Gradients and colors.
    Descriptor,
    /// DINOv2 with local weights.
    Dinov2,
}
