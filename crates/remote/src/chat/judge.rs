//! How good a finished scene looks: the ratings of the paper's evaluation, 1 to 7, with a reason each.

use std::collections::BTreeMap;

use serde::Deserialize;
use serde_json::{Value, json};

use super::conversation::Topic;
use super::prompts::prompts;
use super::words::Complaints;
use super::{ChatAnalyst, rejected, schema};
use crate::picture;
use ports::{Call, Judgement, MadeAfter, Port, ProviderError};
use scene::appraisal::{Criterion, Opinion, Rating, SCORES};

/// Longest reason, characters.
const MAX_WHY_CHARS: usize = 400;

/// Longest text that is sent, characters.
const MAX_TEXT_CHARS: usize = 4000;

/// Scores by the criterion's word.
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
) -> Result<Opinion<Vec<Rating>>, ProviderError> {
    let (prompt, criteria, data): (_, &[Criterion], _) = match &question.after {
        MadeAfter::Picture(_) => {
            let data = json!({ "question": "How good is the scene in the second picture?" });
            (&prompts().judge_picture, &Criterion::OF_A_PICTURE, data)
        }
        MadeAfter::Text(text) => {
            let words: String = text.chars().take(MAX_TEXT_CHARS).collect();
            (&prompts().judge_text, &Criterion::OF_A_TEXT, json!({ "made_after": words }))
        }
    };
    let longest_px = analyst.settings.picture_px;
    let (after, scene_view) = (question.after, question.scene_view);
    let pictures = call.compute(Port::Analyst, move |_| {
        let reference = match &after {
            MadeAfter::Picture(picture) => Some(picture.as_ref()),
            MadeAfter::Text(_) => None,
        };
        let sent = |image| {
            picture::sent(image, longest_px)
                .map_err(|error| rejected("image_unreadable", format!("a picture cannot be sent: {error}")))
        };
        reference.into_iter().chain([scene_view.as_ref()]).map(sent).collect::<Result<Vec<_>, _>>()
    });
    let topic =
        Topic { prompt, schema: schema(criteria), seed: question.seed, data, pictures: pictures.await? };
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
    fn ratings_come_in_the_order_of_the_criteria() {
        let ratings = answered(GOOD, &Criterion::OF_A_PICTURE).expect("holds");
        let scores: Vec<(Criterion, u8)> =
            ratings.iter().map(|rating| (rating.criterion, rating.score)).collect();
        assert_eq!(scores, Criterion::OF_A_PICTURE.into_iter().zip([6, 5, 7]).collect::<Vec<_>>());
    }

    #[test]
    fn no_number_is_made_up_where_the_answer_has_none() {
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
            assert!(answered(&spoiled, &Criterion::OF_A_PICTURE).is_err(), "{to}");
        }
        // Of the other kind of scene.
        let told = answered(GOOD, &Criterion::OF_A_TEXT).expect_err("complains").join("\n");
        assert!(told.contains("layout_coherence is missing") && told.contains("not asked for"), "{told}");
    }

    #[test]
    fn words_in_files_are_those_of_the_answer() {
        for criterion in Criterion::OF_A_PICTURE.into_iter().chain(Criterion::OF_A_TEXT) {
            assert_eq!(json!(criterion), json!(criterion.name()));
        }
    }
}
