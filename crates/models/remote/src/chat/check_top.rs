//! The check of a generated top view: whether positions can be measured on it.

use serde::Deserialize;
use serde_json::{Value, json};

use super::prompts::prompts;
use super::repair_turn::Topic;
use super::response_values::Complaints;
use super::{ChatAnalyst, rejected, schema};
use crate::image;
use ports::{Call, Port, ProviderError, TopCheck, TopVerdict};

/// Maximum length of the feedback to the image generator, characters.
const MAX_FEEDBACK_CHARS: usize = 400;

#[derive(Deserialize)]
pub(super) struct Answer {
    straight_down: bool,
    no_perspective: bool,
    front_below: bool,
    all_there: bool,
    none_added: bool,
    #[serde(rename = "told")]
    feedback: String,
}

pub(super) fn schema() -> Value {
    let questions = ["straight_down", "no_perspective", "front_below", "all_there", "none_added"];
    let mut properties: Vec<(&str, Value)> =
        questions.into_iter().map(|question| (question, schema::yes_or_no())).collect();
    properties.push(("told", schema::text("one sentence to the painter")));
    schema::object(&properties)
}

/// Asks about the reference image and the top view.
pub(super) async fn check(
    analyst: &ChatAnalyst,
    call: &Call,
    question: TopCheck,
) -> Result<TopVerdict, ProviderError> {
    let longest_px = analyst.settings.image_px;
    let (reference, top) = (question.reference.image.clone(), question.top.clone());
    let images = call.compute(Port::Analyst, move |_| {
        let sent = |image| {
            image::sent(image, longest_px)
                .map_err(|error| rejected("image_unreadable", format!("the image cannot be sent: {error}")))
        };
        Ok(vec![sent(&reference)?, sent(&top)?])
    });
    let objects = question.recognition.objects.iter();
    let topic = Topic {
        prompt: &prompts().check_top,
        schema: schema(),
        seed: question.seed,
        data: json!({ "objects": objects.map(|object| &object.label).collect::<Vec<_>>() }),
        images: images.await?,
    };
    analyst.ask(call, topic, accepted).await
}

pub(super) fn accepted(answer: Answer) -> Result<TopVerdict, Vec<String>> {
    let mut complaints = Complaints::default();
    complaints.plain("told", &answer.feedback, MAX_FEEDBACK_CHARS);
    let Answer { straight_down, no_perspective, front_below, all_there, none_added, feedback } = answer;
    complaints.none_or(TopVerdict {
        straight_down,
        no_perspective,
        front_below,
        all_there,
        none_added,
        feedback,
    })
}
