//! Ratings of a finished scene by a vision-language model: the criteria of the paper's evaluation, 1 to 7, with a
//! reason each.

use std::collections::BTreeMap;

use serde::Deserialize;
use serde_json::{Value, json};

use super::prompts::prompts;
use super::repair_turn::Topic;
use super::response_values::Complaints;
use super::{ChatAnalyst, rejected, schema};
use crate::image;
use ports::{Call, Judgement, MadeAfter, Port, ProviderError};
use scene::appraisal::{Criterion, ModelResponse, Rating, SCORES};

/// Maximum length of a reason, characters.
const MAX_WHY_CHARS: usize = 400;

/// Maximum length of the sent text, characters.
const MAX_TEXT_CHARS: usize = 4000;

/// Scores by the criterion's name.
#[derive(Deserialize)]
#[serde(transparent)]
pub(super) struct Answer(BTreeMap<String, Score>);

#[derive(Deserialize)]
struct Score {
    score: f64,
    why: String,
}

pub(super) fn schema(criteria: &[Criterion]) -> Value {
    let [low, high] = SCORES.map(f64::from);
    let score = || {
        schema::object(&[
            ("score", schema::number(low, high, "a whole number")),
            ("why", schema::text("one sentence")),
        ])
    };
    let properties: Vec<(&str, Value)> =
        criteria.iter().map(|criterion| (criterion.name(), score())).collect();
    schema::object(&properties)
}

/// Asks for ratings.
pub(super) async fn judge(
    analyst: &ChatAnalyst,
    call: &Call,
    question: Judgement,
) -> Result<ModelResponse<Vec<Rating>>, ProviderError> {
    let (prompt, criteria, data): (_, &[Criterion], _) = match &question.after {
        MadeAfter::Image(_) => {
            let data = json!({ "question": "How good is the scene in the second picture?" });
            (&prompts().judge_image, &Criterion::OF_IMAGE, data)
        }
        MadeAfter::Text(text) => {
            let words: String = text.chars().take(MAX_TEXT_CHARS).collect();
            (&prompts().judge_text, &Criterion::OF_TEXT, json!({ "made_after": words }))
        }
    };
    let longest_px = analyst.settings.image_px;
    let (after, scene_view) = (question.after, question.scene_view);
    let images = call.compute(Port::Analyst, move |_| {
        let reference = match &after {
            MadeAfter::Image(image) => Some(image.as_ref()),
            MadeAfter::Text(_) => None,
        };
        let sent = |image| {
            image::sent(image, longest_px)
                .map_err(|error| rejected("image_unreadable", format!("an image cannot be sent: {error}")))
        };
        reference.into_iter().chain([scene_view.as_ref()]).map(sent).collect::<Result<Vec<_>, _>>()
    });
    let topic = Topic { prompt, schema: schema(criteria), seed: question.seed, data, images: images.await? };
    let ratings = analyst.ask(call, topic, |answer| accepted(answer, criteria)).await?;
    Ok(analyst.opinion(prompt, ratings))
}

pub(super) fn accepted(answer: Answer, criteria: &[Criterion]) -> Result<Vec<Rating>, Vec<String>> {
    let mut complaints = Complaints::default();
    let Answer(mut scores) = answer;
    let mut ratings = Vec::with_capacity(criteria.len());
    for &criterion in criteria {
        let name = criterion.name();
        let Some(Score { score, why }) = scores.remove(name) else {
            complaints.add(format!("{name} is missing; rate every criterion that was given"));
            continue;
        };
        let [low, high] = SCORES.map(f64::from);
        complaints.range(&format!("{name}.score"), score, low, high);
        if score.fract() != 0.0 {
            complaints.add(format!("{name}.score is {score}; it must be a whole number"));
        }
        complaints.plain(&format!("{name}.why"), &why, MAX_WHY_CHARS);
        ratings.push(Rating { criterion, score: score as u8, why });
    }
    if !scores.is_empty() {
        complaints.add("there are criteria that were not asked for; leave them out");
    }
    complaints.none_or(ratings)
}

#[cfg(test)]
mod tests {
    use super::*;

    const GOOD: &str = r#"{"visual_fidelity": {"score": 6, "why": "Soft light, clean shapes."},
        "image_alignment": {"score": 5, "why": "The fork lies further left."},
        "physical_plausibility": {"score": 7.0, "why": "Everything rests on the table."}}"#;

    fn answered(text: &str, criteria: &[Criterion]) -> Result<Vec<Rating>, Vec<String>> {
        accepted(serde_json::from_str(text).expect("has the form"), criteria)
    }

    #[test]
    fn accepted_orders_ratings_by_criterion() {
        let ratings = answered(GOOD, &Criterion::OF_IMAGE).expect("holds");
        let scores: Vec<(Criterion, u8)> =
            ratings.iter().map(|rating| (rating.criterion, rating.score)).collect();
        assert_eq!(scores, Criterion::OF_IMAGE.into_iter().zip([6, 5, 7]).collect::<Vec<_>>());
    }

    #[test]
    fn accepted_rejects_missing_and_invalid_scores() {
        for (from, to) in [
            ("\"score\": 6", "\"score\": 0"),
            ("\"score\": 6", "\"score\": 8"),
            ("\"score\": 6", "\"score\": 5.5"),
            ("\"score\": 6", "\"score\": 1e300"),
            ("Soft light, clean shapes.", ""),
            ("visual_fidelity", "beauty"),
        ] {
            let spoiled = GOOD.replace(from, to);
            assert_ne!(spoiled, GOOD);
            assert!(answered(&spoiled, &Criterion::OF_IMAGE).is_err(), "{to}");
        }
        // Of the other kind of scene.
        let message = answered(GOOD, &Criterion::OF_TEXT).expect_err("complains").join("\n");
        assert!(
            message.contains("layout_coherence is missing") && message.contains("not asked for"),
            "{message}"
        );
    }

    #[test]
    fn criteria_serialize_to_their_names() {
        for criterion in Criterion::OF_IMAGE.into_iter().chain(Criterion::OF_TEXT) {
            assert_eq!(json!(criterion), json!(criterion.name()));
        }
    }
}
