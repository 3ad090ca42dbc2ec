//! Whether a drawn view from above can be measured on: the gate behind a painter that draws.

use serde::Deserialize;
use serde_json::{Value, json};

use super::conversation::Topic;
use super::prompts::prompts;
use super::words::Complaints;
use super::{ChatAnalyst, rejected, schema};
use crate::picture;
use ports::{Call, Port, ProviderError, TopCheck, TopVerdict};

/// Longest sentence that is passed on to the painter, characters.
const MAX_TOLD_CHARS: usize = 400;

#[derive(Deserialize)]
pub(super) struct Answer {
    straight_down: bool,
    no_perspective: bool,
    front_below: bool,
    all_there: bool,
    none_added: bool,
    told: String,
}

pub(super) fn schema() -> Value {
    let questions = ["straight_down", "no_perspective", "front_below", "all_there", "none_added"];
    let mut properties: Vec<(&str, Value)> =
        questions.into_iter().map(|question| (question, schema::yes_or_no())).collect();
    properties.push(("told", schema::text("one sentence to the painter")));
    schema::object(&properties)
}

/// Asks about both pictures.
pub(super) async fn check(
    analyst: &ChatAnalyst,
    call: &Call,
    question: TopCheck,
) -> Result<TopVerdict, ProviderError> {
    let longest_px = analyst.settings.picture_px;
    let (seen, top) = (question.reference.picture.clone(), question.top.clone());
    let pictures = call.compute(Port::Analyst, move |_| {
        let sent = |image| {
            picture::sent(image, longest_px)
                .map_err(|error| rejected("image_unreadable", format!("the picture cannot be sent: {error}")))
        };
        Ok(vec![sent(&seen)?, sent(&top)?])
    });
    let objects = question.recognition.objects.iter();
    let topic = Topic {
        prompt: &prompts().check_top,
        schema: schema(),
        seed: question.seed,
        data: json!({ "objects": objects.map(|object| &object.label).collect::<Vec<_>>() }),
        pictures: pictures.await?,
    };
    analyst.ask(call, topic, accepted).await
}

pub(super) fn accepted(answer: Answer) -> Result<TopVerdict, Vec<String>> {
    let mut complaints = Complaints::default();
    complaints.plain("told", &answer.told, MAX_TOLD_CHARS);
    let Answer { straight_down, no_perspective, front_below, all_there, none_added, told } = answer;
    complaints.none_or(TopVerdict { straight_down, no_perspective, front_below, all_there, none_added, told })
}
