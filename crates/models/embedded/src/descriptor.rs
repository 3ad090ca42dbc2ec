//! The embedded feature extractor: the classical image descriptor of [`vision::descriptor`].

use std::sync::Arc;

use rayon::prelude::*;

use imaging::Image;
use ports::{Adapter, Answer, Call, FeatureExtractor, Port};
use runtime::Cancelled;
use vision::descriptor::{DescriptorSettings, describe};

/// Answers the feature port with gradient and color statistics, which are not comparable with learned features.
#[derive(Clone, Debug)]
pub struct EmbeddedFeatureExtractor {
    pub settings: DescriptorSettings,
}

impl FeatureExtractor for EmbeddedFeatureExtractor {
    fn adapter(&self) -> Adapter {
        Adapter::new("embedded/descriptor", "1", &self.settings)
    }

    fn features<'a>(&'a self, call: &'a Call, images: Vec<Arc<Image>>) -> Answer<'a, Vec<Vec<f32>>> {
        let settings = self.settings.clone();
        Box::pin(call.compute(Port::FeatureExtractor, move |cancel| {
            let described: Result<Vec<Vec<f32>>, Cancelled> =
                images.par_iter().map(|image| cancel.check().map(|()| describe(image, &settings))).collect();
            Ok(described?)
        }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use runtime::CancelFlag;
    use runtime::CpuPool;

    #[tokio::test]
    async fn features_are_distinct_unit_vectors() {
        let settings = DescriptorSettings { patches: 4, side_px: 32, orientations: 6, color_share: 0.5 };
        let extractor = EmbeddedFeatureExtractor { settings };
        assert_eq!(extractor.adapter().name, "embedded/descriptor");
        let call = Call::without_budget(CpuPool::new(2).expect("a pool"), CancelFlag::default());
        let images = [[200, 30, 30, 255], [30, 30, 200, 255]].map(|c| Arc::new(Image::filled(40, 30, c)));
        let features = extractor.features(&call, images.to_vec()).await.expect("an answer");
        for feature in &features {
            assert!((feature.iter().map(|v| v * v).sum::<f32>() - 1.0).abs() < 1e-5);
        }
        let alike: f32 = features[0].iter().zip(&features[1]).map(|(a, b)| a * b).sum();
        assert!(alike < 0.9);
    }
}
