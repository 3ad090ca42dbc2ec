//! The image generator over OpenAI's Images endpoints.
//!
//! [`mod@reference`] generates the reference image of a description (`/images/generations`).
//! [`mod@inpaint`] completes one object from its surroundings and its visible pixels (`/images/edits`, two images,
//! transparent background) and registers the result with the reference image. A result with another object or a
//! background is rejected, and the next prompt states the reason. [`top_view`] generates the table from straight above,
//! which an analyst checks.
//!
//! The models accept no seed; the seed chooses the viewing direction.

pub mod wire;
pub mod prompts;
pub mod reference;
pub mod inpaint;
pub mod top_view;

use std::fmt::Display;
use std::sync::Arc;

use bytes::Bytes;
use serde_json::json;

use self::inpaint::{InpaintSettings, inpaint};
use super::endpoint::Question;
use super::failure::{Failure, FailureKind};
use super::image::ImageRefused;
use super::settings::ImagesSettings;
use super::{Endpoint, image};
use imaging::Image;
use ports::{
    Adapter, Answer, Call, Completion, CompletionRequest, GeneratedReference, ImageGenerator, Port,
    ProviderError, TopViewImage, TopViewRequest,
};
use scene::SceneDescription;

/// Name of the adapter.
pub const NAME: &str = "openai/images";

/// Reason why an image of a model is not used; a repeated request states it.
#[derive(Debug, thiserror::Error)]
pub(crate) enum DrawingRefused {
    #[error("its image is not accepted: {0}")]
    NotAccepted(#[from] ImageRefused),
    #[error("{width_px} x {height_px} pixels are too few")]
    TooSmall { width_px: u32, height_px: u32 },
    #[error("its background is not one plain color")]
    BackgroundNotPlain,
    #[error("its background is not transparent")]
    BackgroundNotTransparent,
    #[error("nothing is drawn")]
    Empty,
    #[error(
        "it shows another object, or another side: its outline agrees to {:.0} % with what is visible",
        100.0 * .agreement
    )]
    AnotherObject { agreement: f64 },
}

/// The image generator of an OpenAI-compatible endpoint.
pub struct OpenAiImageGenerator {
    pub settings: ImagesSettings,
    pub endpoint: Arc<Endpoint>,
}

impl OpenAiImageGenerator {
    async fn inpaint(&self, call: &Call, request: CompletionRequest) -> Result<Completion, ProviderError> {
        let settings = &self.settings;
        let how = InpaintSettings {
            adapter: NAME,
            on_backdrop: false,
            min_agreement: settings.min_agreement,
            redraws: settings.redraws,
        };
        let draw = |prompt: String, sent: [Bytes; 2]| async move {
            let (content_type, body) = wire::edit(settings, wire::Canvas::Object, &prompt, &sent).encoded();
            let question = Question {
                operation: "redraw",
                path: "/images/edits",
                headers: Vec::new(),
                content_type: content_type.into(),
                body,
                reserved: wire::max_cost(settings, &prompt, sent.len()),
            };
            decoded(call, self.endpoint.ask(call, &question, |reply| wire::read(settings, reply)).await?)
                .await
        };
        inpaint(&how, call, request, draw).await
    }
}

impl ImageGenerator for OpenAiImageGenerator {
    fn adapter(&self) -> Adapter {
        let ImagesSettings {
            endpoint, reference_size, quality, input_fidelity, min_agreement, redraws, ..
        } = &self.settings;
        let settings = json!({
            "base_url": endpoint.base_url, "reference_size": reference_size, "quality": quality, "redraws": redraws,
            "input_fidelity": input_fidelity, "min_agreement": min_agreement, "prompts": prompts::identity(),
        });
        Adapter { name: NAME.to_owned(), model: self.settings.model.clone(), settings }
    }

    fn reference<'a>(
        &'a self,
        call: &'a Call,
        description: Arc<SceneDescription>,
        seed: u64,
    ) -> Answer<'a, GeneratedReference> {
        Box::pin(async move {
            let image = reference::render(self, call, &description, seed).await?;
            Ok(GeneratedReference { image, unmet: Vec::new(), ground_truth: None })
        })
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
        Box::pin(async move {
            match request.rendered {
                Some(rendered) => Ok(rendered),
                None => top_view::draw(self, call, request).await,
            }
        })
    }
}

/// Decodes a file of the vendor, on the pool.
pub(super) async fn decoded(
    call: &Call,
    file: Vec<u8>,
) -> Result<Result<Image, DrawingRefused>, ProviderError> {
    call.compute(Port::ImageGenerator, move |_| Ok(image::received(&file).map_err(DrawingRefused::from)))
        .await
}

/// The error after the last rejected image.
fn not_taken(adapter: &'static str, reason: impl Display, drawings: u32) -> ProviderError {
    let reason = format!("none of {drawings} drawings could be used: {reason}");
    Failure::new(FailureKind::BadAnswer, reason).into_error(Port::ImageGenerator, adapter)
}
