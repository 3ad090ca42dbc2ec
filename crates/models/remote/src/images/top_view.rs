//! The top view: the table from straight above, generated from the reference image. The caller has an analyst check
//! it and asks again with the reason of a rejection.

use std::sync::Arc;

use bytes::Bytes;

use super::super::endpoint::Question;
use super::super::image;
use super::prompts::prompts;
use super::reference::MIN_PX;
use super::{NAME, OpenAiImageGenerator, decoded, not_taken, wire};
use imaging::Image;
use ports::{Call, Port, ProviderError, TopViewImage, TopViewRequest};
use scene::{Recognition, StandsOn};

/// Maximum side of the sent image, pixels.
const SENT_PX: u32 = 1536;

/// Requests one top view; an error where the maximum number of requests was rejected.
pub(super) async fn draw(
    image_generator: &OpenAiImageGenerator,
    call: &Call,
    request: TopViewRequest,
) -> Result<TopViewImage, ProviderError> {
    let settings = &image_generator.settings;
    if let Some(reason) = request.refused.last().filter(|_| request.refused.len() > settings.redraws as usize)
    {
        return Err(not_taken(NAME, reason, settings.redraws + 1));
    }
    let prompt = prompt_of(&request.recognition, &request.refused);
    let png = sent(call, request.reference.image.clone()).await?;
    let (content_type, body) = wire::edit(settings, wire::Canvas::Table, &prompt, &[png]).encoded();
    let question = Question {
        operation: "top_view",
        path: "/images/edits",
        headers: Vec::new(),
        content_type: content_type.into(),
        body,
        reserved: wire::max_cost(settings, &prompt, 1),
    };
    let file = image_generator.endpoint.ask(call, &question, |reply| wire::read(settings, reply)).await?;
    match decoded(call, file).await? {
        Ok(image) if image.width_px().min(image.height_px()) >= MIN_PX => {
            Ok(TopViewImage { image, known: None })
        }
        Ok(_) => Err(not_taken(NAME, "it is too small", 1)),
        Err(reason) => Err(not_taken(NAME, reason, 1)),
    }
}

/// The reference image as a PNG file.
pub(crate) async fn sent(call: &Call, image: Arc<Image>) -> Result<Bytes, ProviderError> {
    call.compute(Port::ImageGenerator, move |_| {
        image::sent(&image, SENT_PX).map_err(|error| ProviderError::Rejected {
            port: Port::ImageGenerator,
            code: "image_unreadable",
            reason: format!("the image cannot be sent: {error}"),
        })
    })
    .await
}

pub(crate) fn prompt_of(recognition: &Recognition, refused: &[String]) -> String {
    let mut message = vec![prompts().top.text.to_owned(), String::new(), "The things:".to_owned()];
    message.extend(recognition.objects.iter().map(|object| match &object.stands_on {
        StandsOn::Table => format!("- {}: {}", object.id, object.label),
        StandsOn::On(id) => format!("- {}: {}, on {id}", object.id, object.label),
        StandsOn::In(id) => format!("- {}: {}, in {id}", object.id, object.label),
    }));
    if let Some(reason) = refused.last() {
        message.extend([String::new(), format!("An earlier drawing could not be used: {reason}.")]);
    }
    message.join("\n")
}
