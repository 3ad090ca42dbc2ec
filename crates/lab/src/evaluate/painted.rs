//! A painter that has painted already: the stages get the evaluator's picture, spoiled or not.
//!
//! The evaluator paints first and keeps the truth; the stages then ask this painter for the reference picture and
//! are handed what they may see of it.

use std::sync::Arc;

use futures::FutureExt;

use super::noise::Noise;
use ports::{
    Adapter, Answer, Call, Completion, CompletionRequest, Painter, Painting, TopPicture, TopViewRequest,
};
use scene::SceneDescription;

/// Answers `reference` with one painting and everything else as `painter` does.
pub struct PaintedAlready {
    pub painter: Arc<dyn Painter>,
    pub painting: Arc<Painting>,
    /// What spoiled the painting, if anything did: part of the adapter's identity.
    pub noise: Option<Noise>,
}

impl Painter for PaintedAlready {
    fn adapter(&self) -> Adapter {
        let inner = self.painter.adapter();
        Adapter::new("evaluate/painted", &inner.model, &(inner.settings, self.noise))
    }

    fn reference<'a>(
        &'a self,
        _call: &'a Call,
        _description: Arc<SceneDescription>,
        _seed: u64,
    ) -> Answer<'a, Painting> {
        let painting = self.painting.clone();
        async move { Ok((*painting).clone()) }.boxed()
    }

    fn complete<'a>(&'a self, call: &'a Call, request: CompletionRequest) -> Answer<'a, Completion> {
        self.painter.complete(call, request)
    }

    fn top_view<'a>(&'a self, call: &'a Call, request: TopViewRequest) -> Answer<'a, TopPicture> {
        self.painter.top_view(call, request)
    }
}
