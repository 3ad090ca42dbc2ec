//! What a stand-in can say of finished scenes: the more a picture is like the one it was made after, the
//! better it is rated; tasks are about what a gripper can take.

use serde_json::{Value, json};

use super::Asked;
use crate::dev_providers::likeness::Look;
use crate::dev_providers::refusal::Refusal;
use crate::dev_providers::studio::Studio;
use imaging::Image;

/// Distance of looks at which a scene is rated worst.
const WORST: f64 = 0.3;

/// What a gripper can take: the width of one side, meters, and kilograms.
const GRIPPED_M: f64 = 0.08;
const GRIPPED_KG: f64 = 2.0;

/// Ratings of a scene after a picture.
pub(super) fn after_picture(asked: &Asked) -> Result<Value, Refusal> {
    let [reference, scene] = &asked.pictures[..] else {
        return Err(Refusal::Wrong("two pictures are wanted".into()));
    };
    rated(reference, scene, &["visual_fidelity", "image_alignment", "physical_plausibility"])
}

/// Ratings of a scene after a text that was described here.
pub(super) async fn after_text(studio: &Studio, asked: &Asked) -> Result<Value, Refusal> {
    let words = asked.data["made_after"].as_str();
    let words = words.ok_or_else(|| Refusal::Wrong("there are no words that it was made after".into()))?;
    let scene = asked.pictures.first().ok_or_else(|| Refusal::Wrong("there is no picture".into()))?;
    let painted = studio.painting_after(words).await?;
    let criteria = ["consistency_with_text", "object_quality", "layout_coherence", "physical_plausibility"];
    rated(&painted.sight.picture, scene, &criteria)
}

fn rated(wanted: &Image, scene: &Image, criteria: &[&str]) -> Result<Value, Refusal> {
    let look = |picture| Look::of(picture).ok_or_else(|| Refusal::Wrong("a picture is transparent".into()));
    let distance = look(wanted)?.distance(&look(scene)?);
    let score = (7.0 - 6.0 * (distance / WORST).min(1.0)).round();
    let why = format!("It looks {distance:.2} away from what it was made after, where {WORST} is the worst.");
    let mut answer = json!({});
    for criterion in criteria {
        answer[*criterion] = json!({ "score": score, "why": why });
    }
    Ok(answer)
}

/// Tasks about the things that were told.
pub(super) fn tasks(asked: &Asked) -> Result<Value, Refusal> {
    let wrong = || Refusal::Wrong("things have names, labels, sizes and masses".into());
    let count = asked.data["count"].as_u64().ok_or_else(wrong)? as usize;
    let told = asked.data["things"].as_array().ok_or_else(wrong)?;
    let things: Option<Vec<(&str, &str, bool)>> = told
        .iter()
        .map(|thing| {
            let (name, label) = (thing["name"].as_str()?, thing["label"].as_str()?);
            let sizes = thing["size_m"].as_array()?.iter().map(Value::as_f64);
            let narrowest = sizes.collect::<Option<Vec<f64>>>()?.into_iter().fold(f64::INFINITY, f64::min);
            let carries = told.iter().any(|other| other["carried_by"] == name);
            let light = thing["mass_kg"].as_f64()? <= GRIPPED_KG;
            Some((name, label, narrowest < GRIPPED_M && light && !carries))
        })
        .collect();
    let things = things.ok_or_else(wrong)?;
    let mut tasks: Vec<Value> = Vec::new();
    let mut add = |instruction: String, kind: &str, objects: &[&str]| {
        if tasks.len() < count && tasks.iter().all(|task| task["instruction"] != instruction) {
            tasks.push(json!({ "instruction": instruction, "kind": kind, "objects": objects }));
        }
    };
    for (name, label, _) in things.iter().filter(|(_, _, gripped)| *gripped) {
        for (other, beside, _) in things.iter().filter(|(other, ..)| other != name) {
            add(format!("Put the {label} beside the {beside}."), "pick_and_place", &[name, other]);
        }
    }
    for (index, (name, label, gripped)) in things.iter().enumerate() {
        for (other, beside, also) in &things[index + 1..] {
            if *gripped && *also {
                add(format!("Let the {label} and the {beside} change places."), "swap", &[name, other]);
            }
        }
    }
    for (name, label, _) in things.iter().filter(|(_, _, gripped)| *gripped) {
        add(format!("Lift the {label} and put it back."), "multi_step", &[name]);
    }
    match tasks.len() == count {
        true => Ok(json!({ "tasks": tasks })),
        false => Err(Refusal::Unable(format!("nobody here can think of {count} tasks with these things"))),
    }
}
