//! Port 5, the feature extractor `Phi`: the appearance of an image as a unit vector. The paper uses DINOv2.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::{Adapter, Answer, Call};
use imaging::Image;

/// Maps images to feature vectors.
pub trait FeatureExtractor: Send + Sync {
    fn adapter(&self) -> Adapter;

    /// The unit-length features of each image; similar images have a large dot product. Transparent pixels do not
    /// count; a completely transparent image has zero features.
    fn features<'a>(&'a self, call: &'a Call, images: Vec<Arc<Image>>) -> Answer<'a, Vec<Vec<f32>>>;
}

/// Section `[features]`.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct FeatureSettings {
    /// The adapter of the port.
    pub adapter: FeatureAdapter,
    /// Folder or file with the weights of the adapter; empty where it has none.
    pub weights: String,
}

/// The adapters of the port.
#[derive(Clone, Copy, Debug, Serialize, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
pub enum FeatureAdapter {
    /// A descriptor of gradients and colors.
    Descriptor,
    /// DINOv2 with local weights.
    Dinov2,
}
