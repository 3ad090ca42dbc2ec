//! The embedded feature extractor: the classical descriptor of [`crate::vision::descriptor`].

use std::sync::Arc;

use rayon::prelude::*;

use crate::geometry::Image;
use crate::provider::{Adapter, Answer, Call, FeatureExtractor, Port};
use crate::vision::descriptor::{DescriptorSettings, describe};

/// Adapter `embedded/descriptor`.
pub struct EmbeddedFeatureExtractor {
    pub settings: DescriptorSettings,
}

impl FeatureExtractor for EmbeddedFeatureExtractor {
    fn adapter(&self) -> Adapter {
        Adapter::new("embedded/descriptor", "1", &self.settings)
    }

    fn features<'a>(&'a self, call: &'a Call, pictures: Vec<Arc<Image>>) -> Answer<'a, Vec<Vec<f32>>> {
        let settings = self.settings.clone();
        Box::pin(call.compute(Port::FeatureExtractor, move |_| {
            Ok(pictures.par_iter().map(|picture| describe(picture, &settings)).collect())
        }))
    }
}
