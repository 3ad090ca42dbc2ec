//! The painter over Ark's Seedream 4.0 and later: reference pictures, and tables drawn from straight above.
//!
//! It draws on no transparent background, so that single things are another painter's ([`images`](super::images)), and it cannot
//! be seeded. Its pictures come in the answer itself: addresses are not followed.

pub mod wire;

use std::sync::Arc;

use serde_json::json;

use super::Endpoint;
use super::endpoint::Question;
use super::failure::{Failure, FailureKind};
use super::images::{decoded, prompts, reference, top_view};
use super::settings::ArkSettings;
use crate::geometry::Image;
use crate::provider::ledger::MicroUsd;
use crate::provider::{
    Adapter, Answer, Call, Completion, CompletionRequest, Painter, Painting, Port, ProviderError, TopPicture,
    TopViewRequest,
};
use crate::scene::SceneDescription;

/// Name of the adapter.
pub const NAME: &str = "ark/seedream";

/// Asks Seedream.
pub struct ArkPainter {
    pub settings: ArkSettings,
    pub endpoint: Arc<Endpoint>,
}

impl ArkPainter {
    /// One picture; the inner error says why it cannot be used.
    async fn painted(
        &self,
        call: &Call,
        operation: &'static str,
        prompt: &str,
        pictures: &[bytes::Bytes],
    ) -> Result<Result<Image, String>, ProviderError> {
        let question = Question {
            operation,
            path: "/images/generations",
            headers: Vec::new(),
            content_type: "application/json".into(),
            body: wire::request(&self.settings, prompt, pictures).to_string().into(),
            reserved: MicroUsd::of_usd(self.settings.usd_per_picture),
        };
        let file = self.endpoint.ask(call, &question, |reply| wire::read(&self.settings, reply)).await?;
        Ok(decoded(call, file).await?.and_then(|picture| {
            match picture.width_px().min(picture.height_px()) < reference::LEAST_PX {
                true => Err(format!("{} x {} pixels are too few", picture.width_px(), picture.height_px())),
                false => Ok(picture),
            }
        }))
    }

    async fn reference_picture(
        &self,
        call: &Call,
        description: &SceneDescription,
        seed: u64,
    ) -> Result<Painting, ProviderError> {
        let prompt = reference::prompt_of(description, seed);
        let mut reason = String::new();
        for _ in 0..=self.settings.redraws {
            match self.painted(call, "paint", &prompt, &[]).await? {
                Ok(picture) => {
                    let picture = call.compute(Port::Painter, move |_| Ok(reference::kept(picture))).await?;
                    return Ok(Painting { picture, aside: None });
                }
                Err(refused) => reason = refused,
            }
        }
        Err(not_taken(&reason))
    }

    async fn drawn_from_above(
        &self,
        call: &Call,
        request: TopViewRequest,
    ) -> Result<TopPicture, ProviderError> {
        if let Some(painted) = request.painted {
            return Ok(painted);
        }
        let drawn = request.refused.len();
        if let Some(reason) = request.refused.last().filter(|_| drawn > self.settings.redraws as usize) {
            return Err(not_taken(reason));
        }
        let prompt = top_view::prompt_of(&request.recognition, &request.refused);
        let png = top_view::sent(call, request.reference.picture.clone()).await?;
        match self.painted(call, "top_view", &prompt, &[png]).await? {
            Ok(picture) => Ok(TopPicture { picture, known: None }),
            Err(reason) => Err(not_taken(&reason)),
        }
    }
}

/// Why no picture was taken.
fn not_taken(reason: &str) -> ProviderError {
    let reason = format!("none of its pictures could be used: {reason}");
    Failure::new(FailureKind::BadAnswer, reason).into_error(Port::Painter, NAME)
}

impl Painter for ArkPainter {
    fn adapter(&self) -> Adapter {
        let ArkSettings { endpoint, size, redraws, .. } = &self.settings;
        let settings = json!({ "base_url": endpoint.base_url, "size": size, "redraws": redraws, "prompts": prompts::identity() });
        Adapter { name: NAME.to_owned(), model: self.settings.model.clone(), settings }
    }

    fn reference<'a>(
        &'a self,
        call: &'a Call,
        description: Arc<SceneDescription>,
        seed: u64,
    ) -> Answer<'a, Painting> {
        Box::pin(async move { self.reference_picture(call, &description, seed).await })
    }

    fn complete<'a>(&'a self, _call: &'a Call, request: CompletionRequest) -> Answer<'a, Completion> {
        Box::pin(async move {
            request.alone.ok_or_else(|| ProviderError::Unsupported {
                port: Port::Painter,
                adapter: NAME.to_owned(),
                reason: "it draws on no transparent background; put openai_images or embedded behind it in \
                         providers.painter"
                    .to_owned(),
            })
        })
    }

    fn top_view<'a>(&'a self, call: &'a Call, request: TopViewRequest) -> Answer<'a, TopPicture> {
        Box::pin(self.drawn_from_above(call, request))
    }
}
