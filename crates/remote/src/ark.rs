//! The painter over Ark's Seedream 4.0 and later: reference pictures, single things, and tables drawn from straight above.
//!
//! It draws on no transparent background: single things are drawn before one plain color, unlike theirs, which is cut away. It
//! cannot be seeded. Its pictures come in the answer itself: addresses are not followed.

pub mod wire;

use std::sync::Arc;

use bytes::Bytes;
use serde_json::json;

use super::Endpoint;
use super::endpoint::Question;
use super::failure::{Failure, FailureKind};
use super::images::redraw::{Redrawing, redraw};
use super::images::{decoded, prompts, reference, top_view};
use super::settings::ArkSettings;
use imaging::Image;
use ports::ledger::MicroUsd;
use ports::{
    Adapter, Answer, Call, Completion, CompletionRequest, Painter, Painting, Port, ProviderError, TopPicture,
    TopViewRequest,
};
use scene::SceneDescription;

/// Name of the adapter.
pub const NAME: &str = "ark/seedream";

/// Asks Seedream.
pub struct ArkPainter {
    pub settings: ArkSettings,
    pub endpoint: Arc<Endpoint>,
}

impl ArkPainter {
    /// One picture of that size; the inner error says why it cannot be used.
    async fn painted(
        &self,
        call: &Call,
        operation: &'static str,
        size: &str,
        prompt: &str,
        pictures: &[Bytes],
    ) -> Result<Result<Image, String>, ProviderError> {
        let question = Question {
            operation,
            path: "/images/generations",
            headers: Vec::new(),
            content_type: "application/json".into(),
            body: wire::request(&self.settings, size, prompt, pictures).to_string().into(),
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
            match self.painted(call, "paint", &self.settings.size, &prompt, &[]).await? {
                Ok(picture) => {
                    let picture = call.compute(Port::Painter, move |_| Ok(reference::kept(picture))).await?;
                    return Ok(Painting { picture, aside: None });
                }
                Err(refused) => reason = refused,
            }
        }
        Err(not_taken(&reason))
    }

    async fn redrawn(&self, call: &Call, request: CompletionRequest) -> Result<Completion, ProviderError> {
        let settings = &self.settings;
        let how = Redrawing {
            adapter: NAME,
            on_backdrop: true,
            least_agreement: settings.least_agreement,
            redraws: settings.redraws,
        };
        let draw = |prompt: String, sent: [Bytes; 2]| async move {
            self.painted(call, "redraw", &settings.thing_size, &prompt, &sent).await
        };
        redraw(&how, call, request, draw).await
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
        match self.painted(call, "top_view", &self.settings.size, &prompt, &[png]).await? {
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
        let ArkSettings { endpoint, size, thing_size, least_agreement, redraws, .. } = &self.settings;
        let settings = json!({
            "base_url": endpoint.base_url, "size": size, "thing_size": thing_size, "redraws": redraws,
            "least_agreement": least_agreement, "prompts": prompts::identity_on_backdrop(),
        });
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

    fn complete<'a>(&'a self, call: &'a Call, request: CompletionRequest) -> Answer<'a, Completion> {
        Box::pin(async move {
            match request.alone {
                Some(alone) => Ok(alone),
                None => self.redrawn(call, request).await,
            }
        })
    }

    fn top_view<'a>(&'a self, call: &'a Call, request: TopViewRequest) -> Answer<'a, TopPicture> {
        Box::pin(self.drawn_from_above(call, request))
    }
}
