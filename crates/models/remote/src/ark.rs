//! The image generator over Ark's Seedream 4.0 and later: reference images, single objects and top views.
//!
//! Seedream has no transparent output: single objects are drawn on a key color, which is removed. It accepts no seed.
//! Its images come inside the response; URLs are not followed.

pub mod wire;

use std::fmt::Display;
use std::sync::Arc;

use bytes::Bytes;
use serde_json::json;

use super::Endpoint;
use super::endpoint::Question;
use super::failure::{Failure, FailureKind};
use super::images::inpaint::{InpaintSettings, inpaint};
use super::images::{DrawingRefused, decoded, prompts, reference, top_view};
use super::settings::ArkSettings;
use imaging::Image;
use ports::ledger::MicroUsd;
use ports::{
    Adapter, Answer, Call, Completion, CompletionRequest, GeneratedReference, ImageGenerator, Port,
    ProviderError, TopViewImage, TopViewRequest,
};
use scene::SceneDescription;

/// Name of the adapter.
pub const NAME: &str = "ark/seedream";

/// The image generator of an Ark endpoint.
pub struct ArkImageGenerator {
    pub settings: ArkSettings,
    pub endpoint: Arc<Endpoint>,
}

impl ArkImageGenerator {
    /// Generates one image of that size; the inner error is why it is unusable.
    async fn rendered(
        &self,
        call: &Call,
        operation: &'static str,
        size: &str,
        prompt: &str,
        images: &[Bytes],
    ) -> Result<Result<Image, DrawingRefused>, ProviderError> {
        let question = Question {
            operation,
            path: "/images/generations",
            headers: Vec::new(),
            content_type: "application/json".into(),
            body: wire::request(&self.settings, size, prompt, images).to_string().into(),
            reserved: MicroUsd::of_usd(self.settings.usd_per_image),
        };
        let file = self.endpoint.ask(call, &question, |reply| wire::read(&self.settings, reply)).await?;
        Ok(decoded(call, file).await?.and_then(|image| {
            let (width_px, height_px) = (image.width_px(), image.height_px());
            match width_px.min(height_px) < reference::MIN_PX {
                true => Err(DrawingRefused::TooSmall { width_px, height_px }),
                false => Ok(image),
            }
        }))
    }

    async fn reference_image(
        &self,
        call: &Call,
        description: &SceneDescription,
        seed: u64,
    ) -> Result<GeneratedReference, ProviderError> {
        let prompt = reference::prompt_of(description, seed);
        let mut reason = String::new();
        for _ in 0..=self.settings.redraws {
            match self.rendered(call, "paint", &self.settings.size, &prompt, &[]).await? {
                Ok(image) => {
                    let image =
                        call.compute(Port::ImageGenerator, move |_| Ok(reference::kept(image))).await?;
                    return Ok(GeneratedReference { image, unmet: Vec::new(), ground_truth: None });
                }
                Err(refused) => reason = refused.to_string(),
            }
        }
        Err(not_taken(reason))
    }

    async fn inpaint(&self, call: &Call, request: CompletionRequest) -> Result<Completion, ProviderError> {
        let settings = &self.settings;
        let how = InpaintSettings {
            adapter: NAME,
            on_backdrop: true,
            min_agreement: settings.min_agreement,
            redraws: settings.redraws,
        };
        let draw = |prompt: String, sent: [Bytes; 2]| async move {
            self.rendered(call, "redraw", &settings.object_size, &prompt, &sent).await
        };
        inpaint(&how, call, request, draw).await
    }

    async fn drawn_from_above(
        &self,
        call: &Call,
        request: TopViewRequest,
    ) -> Result<TopViewImage, ProviderError> {
        if let Some(rendered) = request.rendered {
            return Ok(rendered);
        }
        let drawn = request.refused.len();
        if let Some(reason) = request.refused.last().filter(|_| drawn > self.settings.redraws as usize) {
            return Err(not_taken(reason));
        }
        let prompt = top_view::prompt_of(&request.recognition, &request.refused);
        let png = top_view::sent(call, request.reference.image.clone()).await?;
        match self.rendered(call, "top_view", &self.settings.size, &prompt, &[png]).await? {
            Ok(image) => Ok(TopViewImage { image, known: None }),
            Err(reason) => Err(not_taken(reason)),
        }
    }
}

/// The error after the last rejected image.
fn not_taken(reason: impl Display) -> ProviderError {
    let reason = format!("none of its images could be used: {reason}");
    Failure::new(FailureKind::BadAnswer, reason).into_error(Port::ImageGenerator, NAME)
}

impl ImageGenerator for ArkImageGenerator {
    fn adapter(&self) -> Adapter {
        let ArkSettings { endpoint, size, object_size, min_agreement, redraws, .. } = &self.settings;
        let settings = json!({
            "base_url": endpoint.base_url, "size": size, "object_size": object_size, "redraws": redraws,
            "min_agreement": min_agreement, "prompts": prompts::identity_on_backdrop(),
        });
        Adapter { name: NAME.to_owned(), model: self.settings.model.clone(), settings }
    }

    fn reference<'a>(
        &'a self,
        call: &'a Call,
        description: Arc<SceneDescription>,
        seed: u64,
    ) -> Answer<'a, GeneratedReference> {
        Box::pin(async move { self.reference_image(call, &description, seed).await })
    }

    fn complete<'a>(&'a self, call: &'a Call, request: CompletionRequest) -> Answer<'a, Completion> {
        Box::pin(async move {
            match request.alone {
                Some(alone) => Ok(alone),
                None => self.inpaint(call, request).await,
            }
        })
    }

    fn top_view<'a>(&'a self, call: &'a Call, request: TopViewRequest) -> Answer<'a, TopViewImage> {
        Box::pin(self.drawn_from_above(call, request))
    }
}
