//! Ratings and tasks of finished scenes: the rating falls with the fingerprint distance between rendering and
//! source; tasks use objects that a gripper can lift.

use serde_json::{Value, json};

use super::Question;
use crate::mock_vendors::error_response::VendorError;
use crate::mock_vendors::image_fingerprint::Fingerprint;
use crate::mock_vendors::image_sessions::ImageSessions;
use imaging::Image;

/// Fingerprint distance with the worst rating.
const WORST: f64 = 0.3;

/// Gripper limits: width of one side, meters, and mass, kilograms.
const GRIPPED_M: f64 = 0.08;
const GRIPPED_KG: f64 = 2.0;

/// Ratings of a scene generated from an image.
pub(super) fn after_image(question: &Question) -> Result<Value, VendorError> {
    let [reference, scene] = &question.images[..] else {
        return Err(VendorError::Invalid("two images are wanted".into()));
    };
    rated(reference, scene, &["visual_fidelity", "image_alignment", "physical_plausibility"])
}

/// Ratings of a scene generated from a text described here.
pub(super) async fn after_text(sessions: &ImageSessions, question: &Question) -> Result<Value, VendorError> {
    let words = question.data["made_after"].as_str();
    let words =
        words.ok_or_else(|| VendorError::Invalid("there are no words that it was made after".into()))?;
    let scene = question.images.first().ok_or_else(|| VendorError::Invalid("there is no image".into()))?;
    let known = sessions.reference_for_text(words).await?;
    let criteria = ["consistency_with_text", "object_quality", "layout_coherence", "physical_plausibility"];
    rated(&known.recognized.image, scene, &criteria)
}

fn rated(wanted: &Image, scene: &Image, criteria: &[&str]) -> Result<Value, VendorError> {
    let fingerprint =
        |image| Fingerprint::of(image).ok_or_else(|| VendorError::Invalid("an image is transparent".into()));
    let distance = fingerprint(wanted)?.distance(&fingerprint(scene)?);
    let score = (7.0 - 6.0 * (distance / WORST).min(1.0)).round();
    let why = format!("Its distance from the original image is {distance:.2}, where {WORST} is the worst.");
    let mut answer = json!({});
    for criterion in criteria {
        answer[*criterion] = json!({ "score": score, "why": why });
    }
    Ok(answer)
}

/// Tasks about the listed objects.
pub(super) fn tasks(question: &Question) -> Result<Value, VendorError> {
    let invalid = || VendorError::Invalid("objects have names, labels, sizes and masses".into());
    let count = question.data["count"].as_u64().ok_or_else(invalid)? as usize;
    let listed = question.data["things"].as_array().ok_or_else(invalid)?;
    let objects: Option<Vec<(&str, &str, bool)>> = listed
        .iter()
        .map(|object| {
            let (name, label) = (object["name"].as_str()?, object["label"].as_str()?);
            let sizes = object["size_m"].as_array()?.iter().map(Value::as_f64);
            let narrowest = sizes.collect::<Option<Vec<f64>>>()?.into_iter().fold(f64::INFINITY, f64::min);
            let carries = listed.iter().any(|other| other["carried_by"] == name);
            let light = object["mass_kg"].as_f64()? <= GRIPPED_KG;
            Some((name, label, narrowest < GRIPPED_M && light && !carries))
        })
        .collect();
    let objects = objects.ok_or_else(invalid)?;
    let mut tasks: Vec<Value> = Vec::new();
    let mut add = |instruction: String, kind: &str, objects: &[&str]| {
        if tasks.len() < count && tasks.iter().all(|task| task["instruction"] != instruction) {
            tasks.push(json!({ "instruction": instruction, "kind": kind, "objects": objects }));
        }
    };
    for (name, label, _) in objects.iter().filter(|(_, _, gripped)| *gripped) {
        for (other, beside, _) in objects.iter().filter(|(other, ..)| other != name) {
            add(format!("Put the {label} beside the {beside}."), "pick_and_place", &[name, other]);
        }
    }
    for (index, (name, label, gripped)) in objects.iter().enumerate() {
        for (other, beside, also) in &objects[index + 1..] {
            if *gripped && *also {
                add(format!("Let the {label} and the {beside} change places."), "swap", &[name, other]);
            }
        }
    }
    for (name, label, _) in objects.iter().filter(|(_, _, gripped)| *gripped) {
        add(format!("Lift the {label} and put it back."), "multi_step", &[name]);
    }
    match tasks.len() == count {
        true => Ok(json!({ "tasks": tasks })),
        false => Err(VendorError::Unsupported(format!("there are no {count} tasks with these objects"))),
    }
}
