//! An image generator with a fixed reference image.
//!
//! The benchmark renders the image first and keeps the truth. The stages request the reference image from this
//! generator and get the version, with or without noise, that they may see.

use std::sync::Arc;

use futures::FutureExt;

use super::noise::Noise;
use ports::{
    Adapter, Answer, Call, Completion, CompletionRequest, GeneratedReference, ImageGenerator, TopViewImage,
    TopViewRequest,
};
use scene::SceneDescription;

/// Answers `reference` with the fixed image and delegates everything else to `image_generator`.
pub struct PrerenderedReference {
    pub image_generator: Arc<dyn ImageGenerator>,
    pub reference: Arc<GeneratedReference>,
    /// Noise applied to the image, if any; part of the adapter's identity.
    pub noise: Option<Noise>,
}

impl ImageGenerator for PrerenderedReference {
    fn adapter(&self) -> Adapter {
        let inner = self.image_generator.adapter();
        Adapter::new("evaluate/painted", &inner.model, &(inner.settings, self.noise))
    }

    fn reference<'a>(
        &'a self,
        _call: &'a Call,
        _description: Arc<SceneDescription>,
        _seed: u64,
    ) -> Answer<'a, GeneratedReference> {
        let reference = self.reference.clone();
        async move { Ok((*reference).clone()) }.boxed()
    }

    fn complete<'a>(&'a self, call: &'a Call, request: CompletionRequest) -> Answer<'a, Completion> {
        self.image_generator.complete(call, request)
    }

    fn top_view<'a>(&'a self, call: &'a Call, request: TopViewRequest) -> Answer<'a, TopViewImage> {
        self.image_generator.top_view(call, request)
    }
}
