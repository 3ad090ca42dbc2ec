//! Port 5, the feature extractor `Phi`: what a picture looks like, as a unit vector. The paper asks DINOv2.

use std::sync::Arc;

use super::{Adapter, Answer, Call};
use crate::geometry::Image;

/// Turns pictures into feature vectors.
pub trait FeatureExtractor: Send + Sync {
    fn adapter(&self) -> Adapter;

    /// The unit-length descriptor of each picture; pictures that look alike have a large dot product.
    /// Transparent pixels do not count.
    fn features<'a>(&'a self, call: &'a Call, pictures: Vec<Arc<Image>>) -> Answer<'a, Vec<Vec<f32>>>;
}
