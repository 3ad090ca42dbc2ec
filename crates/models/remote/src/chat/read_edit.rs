//! An instruction about a finished scene as a program of edits.

use serde::Deserialize;
use serde_json::{Map, Value, json};

use super::instructions::{Read, Remaining, ask_for_program, check_phrase, check_words, program_schema};
use super::prompts::prompts;
use super::response_values::Complaints;
use super::{ChatAnalyst, schema};
use editing::EditableObject;
use ports::{Call, Instruction, ProviderError};
use scene::edit::{MAX_ADDED, MAX_RESIZE};
use scene::program::{Program, Statement};
use scene::{EditOperation, EditProgram};

#[derive(Deserialize)]
pub(super) struct Answer {
    statements: Vec<Map<String, Value>>,
    not_understood: Vec<String>,
    asides: Vec<String>,
}

const OPERATIONS: [&str; 19] = [
    "add",
    "remove",
    "replace",
    "move",
    "rotate",
    "resize",
    "recolor",
    "relabel",
    "restyle_table",
    "stack",
    "swap",
    "arrange",
    "tidy",
    "clutter",
    "remake",
    "rearrange",
    "set_physics",
    "relight",
    "move_camera",
];

const RELATIONS: [&str; 21] = [
    "on",
    "in",
    "left_of",
    "right_of",
    "in_front_of",
    "behind",
    "next_to",
    "between",
    "at_center",
    "at_back",
    "at_front",
    "at_left",
    "at_right",
    "at_back_left",
    "at_back_right",
    "at_front_left",
    "at_front_right",
    "from_left_edge",
    "from_right_edge",
    "from_front_edge",
    "from_back_edge",
];

/// Fields in degrees, which operations state in radians.
const ANGLES: [(&str, &str); 6] = [
    ("by_deg", "by_rad"),
    ("to_deg", "to_rad"),
    ("azimuth_deg", "azimuth_rad"),
    ("elevation_deg", "elevation_rad"),
    ("turn_deg", "turn_rad"),
    ("raise_deg", "raise_rad"),
];

pub(super) fn schema() -> Value {
    let number = |low: f64, high: f64, what: &str| schema::number_or_null(low, high, what);
    let text = schema::text_or_null;
    let place = schema::object(&[
        ("relation", schema::word_or_null(RELATIONS)),
        ("target", text("the other object")),
        ("second_target", text("the second object of `between`")),
        ("distance_m", number(0.0, 5.0, "free distance, meters")),
        ("offset_right_m", number(-5.0, 5.0, "displacement to the right, meters")),
        ("offset_back_m", number(-5.0, 5.0, "displacement to the back, meters")),
    ]);
    program_schema(&[
        ("op", schema::word(OPERATIONS)),
        ("target", text("existing objects: a name or a phrase")),
        ("targets", schema::list(&schema::text("an existing object, or several by a phrase"))),
        ("object", text("a new object: \"a red mug\"")),
        ("count", number(1.0, f64::from(MAX_ADDED), "how many")),
        ("where", schema::list(&place)),
        ("with_contents", schema::yes_or_no()),
        ("by_deg", number(-360.0, 360.0, "counter-clockwise, degrees")),
        ("to_deg", number(-360.0, 360.0, "degrees, 0 faces the front edge")),
        ("facing", text("the object that it faces")),
        ("factor", number(1.0 / MAX_RESIZE, MAX_RESIZE, "of the size")),
        ("color", text("a color word")),
        ("material", text("a material word")),
        ("label", text("another name")),
        ("arrangement", schema::word_or_null(["row", "column"])),
        ("sort_by", schema::word_or_null(["size", "height", "color", "kind"])),
        ("theme", text("such as office")),
        ("mass_factor", number(0.25, 4.0, "of the mass")),
        ("friction_factor", number(0.25, 4.0, "of the friction")),
        ("azimuth_deg", number(-360.0, 360.0, "direction of the light, 0 at the front edge")),
        ("elevation_deg", number(12.0, 85.0, "of the light")),
        ("intensity", number(0.3, 2.0, "of the light")),
        ("turn_deg", number(-360.0, 360.0, "of the camera")),
        ("raise_deg", number(-57.0, 57.0, "of the camera")),
        ("distance_factor", number(0.25, 4.0, "of the camera's distance")),
        ("focal_factor", number(0.25, 4.0, "of the focal length")),
    ])
}

/// Asks for the program of an edit.
pub(super) async fn read(
    analyst: &ChatAnalyst,
    call: &Call,
    instruction: Instruction,
) -> Result<EditProgram, ProviderError> {
    let (text, objects) = (instruction.text.trim(), &instruction.objects);
    let accept = |answer| accepted(answer, text, objects);
    ask_for_program(analyst, call, &prompts().read_edit, schema(), &instruction, accept).await
}

/// The program of a valid answer or the words that are not understood; else the violations.
pub(super) fn accepted(
    answer: Answer,
    text: &str,
    objects: &[EditableObject],
) -> Result<Read<EditProgram>, Vec<String>> {
    let Answer { statements: given, not_understood, asides } = answer;
    let mut complaints = Complaints::default();
    let words: Vec<String> = given
        .iter()
        .map(|fields| fields.get("words").and_then(Value::as_str).unwrap_or_default().to_owned())
        .collect();
    let remaining = Remaining { not_understood, asides };
    check_words(text, &words.iter().map(String::as_str).collect::<Vec<_>>(), &remaining, &mut complaints);
    let mut statements = Vec::with_capacity(given.len().min(64));
    // After these, phrases may mean objects that are not in the list.
    let mut has_new_names = false;
    for (index, (fields, words)) in given.into_iter().zip(words).enumerate().take(64) {
        let at = format!("statements[{index}]");
        let meaning = match operation(fields) {
            Ok(operation) => operation,
            Err(why) => {
                complaints.add(format!("{at}: {why}"));
                continue;
            }
        };
        for violation in meaning.violations() {
            complaints.add(format!("{at}{}: {}", violation.pointer, violation.detail));
        }
        if !has_new_names {
            // "it" is what the statement before is about.
            let is_named = |phrase: &&str| statements.is_empty() || !matches!(*phrase, "it" | "them");
            for phrase in existing(&meaning).into_iter().filter(is_named) {
                check_phrase(&at, phrase, objects, &mut complaints);
            }
        }
        has_new_names |= matches!(
            meaning,
            EditOperation::Add { .. }
                | EditOperation::Replace { .. }
                | EditOperation::Recolor { .. }
                | EditOperation::Relabel { .. }
                | EditOperation::Clutter { .. }
        );
        statements.push(Statement { words, meaning });
    }
    complaints.none_or(())?;
    let Remaining { not_understood, asides } = remaining;
    Ok(Read::unless(not_understood, Program { statements, asides }))
}

/// Reason why a statement is no operation.
#[derive(Debug, thiserror::Error)]
enum StatementError {
    #[error("`where` must be a list of one place, or empty")]
    Place,
    #[error(transparent)]
    Operation(#[from] serde_json::Error),
}

/// The operation of a statement on the wire: without empty fields, with angles in radians.
fn operation(fields: Map<String, Value>) -> Result<EditOperation, StatementError> {
    let is_given = |value: &Value| match value {
        Value::Null | Value::Bool(false) => false,
        Value::Array(items) => !items.is_empty(),
        _ => true,
    };
    let mut stated: Map<String, Value> = fields.into_iter().filter(|(_, value)| is_given(value)).collect();
    stated.remove("words");
    for (degrees, radians) in ANGLES {
        if let Some(angle) = stated.remove(degrees).and_then(|angle| angle.as_f64()) {
            stated.insert(radians.to_owned(), json!(angle.to_radians()));
        }
    }
    if let Some(count) = stated.get("count").and_then(Value::as_f64).filter(|count| count.fract() == 0.0) {
        stated.insert("count".to_owned(), json!(count as i64));
    }
    match stated.remove("where") {
        Some(Value::Array(places)) => match <[Value; 1]>::try_from(places) {
            Ok([Value::Object(fields)]) => {
                stated.insert("where".to_owned(), place(fields, is_given));
            }
            _ => return Err(StatementError::Place),
        },
        Some(_) => return Err(StatementError::Place),
        None => {}
    }
    Ok(serde_json::from_value(Value::Object(stated))?)
}

fn place(fields: Map<String, Value>, is_given: impl Fn(&Value) -> bool) -> Value {
    let mut stated: Map<String, Value> = fields.into_iter().filter(|(_, value)| is_given(value)).collect();
    let (right, back) = (stated.remove("offset_right_m"), stated.remove("offset_back_m"));
    if right.is_some() || back.is_some() {
        let offset = [right, back].map(|offset| offset.unwrap_or(json!(0.0)));
        stated.insert("offset_m".to_owned(), json!(offset));
    }
    Value::Object(stated)
}

/// The phrases of an operation that mean existing objects.
fn existing(operation: &EditOperation) -> Vec<&str> {
    let place = match operation {
        EditOperation::Add { place: Some(place), .. }
        | EditOperation::Move { place, .. }
        | EditOperation::Arrange { place: Some(place), .. } => Some(place),
        _ => None,
    };
    let mut phrases: Vec<&str> = match operation {
        EditOperation::Remove { target, .. }
        | EditOperation::Replace { target, .. }
        | EditOperation::Move { target, .. }
        | EditOperation::Resize { target, .. }
        | EditOperation::Recolor { target, .. }
        | EditOperation::Relabel { target, .. }
        | EditOperation::Remake { target }
        | EditOperation::SetPhysics { target, .. } => vec![target],
        EditOperation::Rotate { target, facing, .. } => {
            std::iter::once(target).chain(facing).map(String::as_str).collect()
        }
        EditOperation::Stack { targets }
        | EditOperation::Swap { targets }
        | EditOperation::Arrange { targets, .. } => targets.iter().map(String::as_str).collect(),
        _ => Vec::new(),
    };
    phrases.extend(
        place.iter().flat_map(|place| place.target.iter().chain(&place.second_target)).map(String::as_str),
    );
    phrases
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chat::tests::scene_objects;

    fn answered(
        statements: Value,
        not_understood: &[&str],
        text: &str,
    ) -> Result<Read<EditProgram>, Vec<String>> {
        let answer = json!({ "statements": statements, "not_understood": not_understood, "asides": [] });
        accepted(serde_json::from_value(answer).expect("has the form"), text, &scene_objects())
    }

    #[test]
    fn statements_become_operations_in_radians_and_without_empty_fields() {
        let text = "move the apple 10 cm to the left and turn the fork by 90 degrees";
        let statements = json!([
            { "words": "move the apple 10 cm to the left", "op": "move", "target": "apple_1", "targets": [], "factor": null,
              "where": [{ "relation": null, "target": null, "offset_right_m": -0.1, "offset_back_m": null }] },
            { "words": "turn the fork by 90 degrees", "op": "rotate", "target": "the fork", "by_deg": 90, "where": [],
              "with_contents": false },
        ]);
        let program = answered(statements, &[], text).expect("holds").program();
        let stated = serde_json::to_value(&program).expect("has a JSON form");
        assert_eq!(stated["statements"][0]["where"], json!({ "offset_m": [-0.1, 0.0] }));
        assert_eq!(stated["statements"][0]["words"], "move the apple 10 cm to the left");
        assert!(
            (stated["statements"][1]["by_rad"].as_f64().expect("an angle") - std::f64::consts::FRAC_PI_2)
                .abs()
                < 1e-4
        );
    }

    #[test]
    fn lazy_and_hostile_answers_are_refused() {
        let text = "remove the apple and bake the fork";
        let good = json!([{ "words": "remove the apple", "op": "remove", "target": "apple_1" }]);
        assert_eq!(
            answered(good.clone(), &["bake the fork"], text).expect("holds"),
            Read::NotUnderstood(vec!["bake the fork".to_owned()])
        );
        assert!(answered(good, &[], text).is_err(), "half of it is left out");
        for spoiled in [
            json!([{ "words": "remove the apple and bake the fork", "op": "remove", "target": "the lamp" }]),
            json!([{ "words": "remove the apple and bake the fork", "op": "remove", "target": "apple_1", "factor": 2 }]),
            json!([{ "words": "remove the apple and bake the fork", "op": "explode", "target": "apple_1" }]),
            json!([{ "words": "remove everything", "op": "remove", "target": "apple_1" }]),
            json!([{ "words": "remove the apple and bake the fork", "op": "resize", "target": "apple_1", "factor": 1e9 }]),
            json!([]),
        ] {
            assert!(answered(spoiled.clone(), &[], text).is_err(), "{spoiled}");
        }
    }
}
