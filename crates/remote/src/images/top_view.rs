//! The table from straight above, drawn after the reference picture. Whether the drawing holds is not the painter's to say:
//! whoever asks has it looked at, and asks again with what was wrong.

use std::sync::Arc;

use bytes::Bytes;

use super::super::endpoint::Question;
use super::super::picture;
use super::prompts::prompts;
use super::reference::LEAST_PX;
use super::{ImagesPainter, NAME, decoded, not_taken, wire};
use imaging::Image;
use ports::{Call, Port, ProviderError, TopPicture, TopViewRequest};
use scene::{Recognition, StandsOn};

/// Longer side of the picture that is sent, pixels.
const SENT_PX: u32 = 1536;

/// Has it drawn once; an error where as many drawings were refused as may be.
pub(super) async fn draw(
    painter: &ImagesPainter,
    call: &Call,
    request: TopViewRequest,
) -> Result<TopPicture, ProviderError> {
    let settings = &painter.settings;
    if let Some(reason) = request.refused.last().filter(|_| request.refused.len() > settings.redraws as usize)
    {
        return Err(not_taken(NAME, reason, settings.redraws + 1));
    }
    let prompt = prompt_of(&request.recognition, &request.refused);
    let png = sent(call, request.reference.picture.clone()).await?;
    let (content_type, body) = wire::edit(settings, wire::Canvas::Table, &prompt, &[png]).encoded();
    let question = Question {
        operation: "top_view",
        path: "/images/edits",
        headers: Vec::new(),
        content_type: content_type.into(),
        body,
        reserved: wire::most_it_can_cost(settings, &prompt, 1),
    };
    let file = painter.endpoint.ask(call, &question, |reply| wire::read(settings, reply)).await?;
    match decoded(call, file).await? {
        Ok(picture) if picture.width_px().min(picture.height_px()) >= LEAST_PX => {
            Ok(TopPicture { picture, known: None })
        }
        Ok(_) => Err(not_taken(NAME, "it is too small", 1)),
        Err(reason) => Err(not_taken(NAME, &reason, 1)),
    }
}

/// The reference picture as a PNG file.
pub(crate) async fn sent(call: &Call, image: Arc<Image>) -> Result<Bytes, ProviderError> {
    call.compute(Port::Painter, move |_| {
        picture::sent(&image, SENT_PX).map_err(|error| ProviderError::Rejected {
            port: Port::Painter,
            code: "image_unreadable",
            reason: format!("the picture cannot be sent: {error}"),
        })
    })
    .await
}

pub(crate) fn prompt_of(recognition: &Recognition, refused: &[String]) -> String {
    let mut told = vec![prompts().top.text.to_owned(), String::new(), "The things:".to_owned()];
    told.extend(recognition.objects.iter().map(|object| match &object.stands_on {
        StandsOn::Table => format!("- {}: {}", object.id, object.label),
        StandsOn::On(id) => format!("- {}: {}, on {id}", object.id, object.label),
        StandsOn::In(id) => format!("- {}: {}, in {id}", object.id, object.label),
    }));
    if let Some(reason) = refused.last() {
        told.extend([String::new(), format!("An earlier drawing could not be used: {reason}.")]);
    }
    told.join("\n")
}
