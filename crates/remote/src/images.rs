//! The painter over OpenAI's Images endpoints.
//!
//! [`reference`] has a description painted (`/images/generations`); [`redraw`] has one thing redrawn from its surroundings
//! and its visible pixels (`/images/edits`, two pictures, transparent background), and finds where the redrawn thing lies.
//! A drawing that shows another thing, or has a background, is not taken: the model is told why and draws again, a few
//! times. [`top_view`] has the table drawn from straight above, for an analyst to look at.
//!
//! What the models paint cannot be seeded; the seed chooses the side the table is seen from.

pub mod wire;
pub mod prompts;
pub mod reference;
pub mod redraw;
pub mod top_view;

use std::sync::Arc;

use bytes::Bytes;
use serde_json::json;

use self::redraw::{Redrawing, redraw};
use super::endpoint::Question;
use super::failure::{Failure, FailureKind};
use super::settings::ImagesSettings;
use super::{Endpoint, picture};
use imaging::Image;
use ports::{
    Adapter, Answer, Call, Completion, CompletionRequest, Painter, Painting, Port, ProviderError, TopPicture,
    TopViewRequest,
};
use scene::SceneDescription;

/// Name of the adapter.
pub const NAME: &str = "openai/images";

/// Asks an image model.
pub struct ImagesPainter {
    pub settings: ImagesSettings,
    pub endpoint: Arc<Endpoint>,
}

impl ImagesPainter {
    async fn redrawn(&self, call: &Call, request: CompletionRequest) -> Result<Completion, ProviderError> {
        let settings = &self.settings;
        let how = Redrawing {
            adapter: NAME,
            on_backdrop: false,
            least_agreement: settings.least_agreement,
            redraws: settings.redraws,
        };
        let draw = |prompt: String, sent: [Bytes; 2]| async move {
            let (content_type, body) = wire::edit(settings, wire::Canvas::Thing, &prompt, &sent).encoded();
            let question = Question {
                operation: "redraw",
                path: "/images/edits",
                headers: Vec::new(),
                content_type: content_type.into(),
                body,
                reserved: wire::most_it_can_cost(settings, &prompt, sent.len()),
            };
            decoded(call, self.endpoint.ask(call, &question, |reply| wire::read(settings, reply)).await?)
                .await
        };
        redraw(&how, call, request, draw).await
    }
}

impl Painter for ImagesPainter {
    fn adapter(&self) -> Adapter {
        let ImagesSettings {
            endpoint,
            reference_size,
            quality,
            input_fidelity,
            least_agreement,
            redraws,
            ..
        } = &self.settings;
        let settings = json!({
            "base_url": endpoint.base_url, "reference_size": reference_size, "quality": quality, "redraws": redraws,
            "input_fidelity": input_fidelity, "least_agreement": least_agreement, "prompts": prompts::identity(),
        });
        Adapter { name: NAME.to_owned(), model: self.settings.model.clone(), settings }
    }

    fn reference<'a>(
        &'a self,
        call: &'a Call,
        description: Arc<SceneDescription>,
        seed: u64,
    ) -> Answer<'a, Painting> {
        Box::pin(async move {
            let picture = reference::paint(self, call, &description, seed).await?;
            Ok(Painting { picture, aside: None })
        })
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
        Box::pin(async move {
            match request.painted {
                Some(painted) => Ok(painted),
                None => top_view::draw(self, call, request).await,
            }
        })
    }
}

/// Decodes what the vendor sent, on the pool.
pub(super) async fn decoded(call: &Call, file: Vec<u8>) -> Result<Result<Image, String>, ProviderError> {
    call.compute(Port::Painter, move |_| {
        Ok(picture::received(&file).map_err(|error| format!("its picture is not taken: {error}")))
    })
    .await
}

/// The last reason why no drawing of an adapter was taken.
fn not_taken(adapter: &'static str, reason: &str, drawings: u32) -> ProviderError {
    let reason = format!("none of {drawings} drawings could be used: {reason}");
    Failure::new(FailureKind::BadAnswer, reason).into_error(Port::Painter, adapter)
}
