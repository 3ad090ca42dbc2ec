//! An instruction for a robot in a finished scene as a program of conditions on the state at the end.

use serde::Deserialize;
use serde_json::{Value, json};

use super::instructions::{Read, Remaining, ask_for_program, check_phrase, check_words, program_schema};
use super::prompts::prompts;
use super::response_values::Complaints;
use super::{ChatAnalyst, schema};
use editing::EditableObject;
use ports::{Call, Instruction, ProviderError};
use scene::program::{Program, Statement};
use scene::{PredicateKind, StatedGoal, TaskProgram};

#[derive(Deserialize)]
pub(super) struct Answer {
    statements: Vec<AnswerStatement>,
    not_understood: Vec<String>,
    asides: Vec<String>,
}

#[derive(Deserialize)]
struct AnswerStatement {
    words: String,
    predicate: PredicateKind,
    object: String,
    target: Option<String>,
    second_target: Option<String>,
}

/// Predicates that poses decide.
fn decided() -> impl Iterator<Item = PredicateKind> {
    use PredicateKind::{Closed, Moved, Opened, PouredInto, Pressed, UsedOn};
    PredicateKind::ALL
        .into_iter()
        .filter(|kind| !matches!(kind, Opened | Closed | Moved | PouredInto | UsedOn | Pressed))
}

fn word(kind: PredicateKind) -> String {
    json!(kind).as_str().unwrap_or_default().to_owned()
}

pub(super) fn schema() -> Value {
    let predicates: Vec<String> = decided().map(word).collect();
    program_schema(&[
        ("predicate", schema::word(predicates.iter().map(String::as_str))),
        ("object", schema::text("a name or a phrase")),
        ("target", schema::text_or_null("the other object")),
        ("second_target", schema::text_or_null("the second object of `between`")),
    ])
}

/// Asks for the program of a task.
pub(super) async fn read(
    analyst: &ChatAnalyst,
    call: &Call,
    instruction: Instruction,
) -> Result<TaskProgram, ProviderError> {
    let (text, objects) = (instruction.text.trim(), &instruction.objects);
    let accept = |answer| accepted(answer, text, objects);
    ask_for_program(analyst, call, &prompts().read_task, schema(), &instruction, accept).await
}

/// The program of a valid answer or the words that are not understood; else the violations.
pub(super) fn accepted(
    answer: Answer,
    text: &str,
    objects: &[EditableObject],
) -> Result<Read<TaskProgram>, Vec<String>> {
    let Answer { statements: given, not_understood, asides } = answer;
    let mut complaints = Complaints::default();
    let remaining = Remaining { not_understood, asides };
    let words: Vec<&str> = given.iter().map(|statement| statement.words.as_str()).collect();
    check_words(text, &words, &remaining, &mut complaints);
    let mut statements = Vec::with_capacity(given.len().min(64));
    for (index, statement) in given.into_iter().enumerate().take(64) {
        let at = format!("statements[{index}]");
        let AnswerStatement { words, predicate, object, target, second_target } = statement;
        if decided().all(|kind| kind != predicate) {
            complaints.add(format!("{at}.predicate must be one of the given words"));
        }
        let (is_needed, is_allowed) = targets_of(predicate);
        let count = usize::from(target.is_some()) + usize::from(second_target.is_some());
        if !(is_needed..=is_allowed).contains(&count) || (target.is_none() && second_target.is_some()) {
            complaints.add(format!("{at}: {} takes {is_needed} to {is_allowed} targets", word(predicate)));
        }
        for phrase in std::iter::once(&object).chain(&target).chain(&second_target) {
            check_phrase(&at, phrase, objects, &mut complaints);
        }
        statements
            .push(Statement { words, meaning: StatedGoal { predicate, object, target, second_target } });
    }
    complaints.none_or(())?;
    let Remaining { not_understood, asides } = remaining;
    Ok(Read::unless(not_understood, Program { statements, asides }))
}

/// Fewest and most targets of a predicate.
fn targets_of(predicate: PredicateKind) -> (usize, usize) {
    use PredicateKind as P;
    match predicate {
        P::Between => (2, 2),
        P::In | P::LeftOf | P::RightOf | P::InFrontOf | P::Behind | P::NextTo | P::AwayFrom => (1, 1),
        // On the table; off what carries it; among themselves.
        P::On | P::Off | P::OutOf | P::StackedOn | P::Swapped => (0, 1),
        _ => (0, 0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chat::tests::scene_objects;

    fn answered(statements: Value, not_understood: &[&str]) -> Result<Read<TaskProgram>, Vec<String>> {
        let answer =
            json!({ "statements": statements, "not_understood": not_understood, "asides": ["please"] });
        let text = "please put the apple in the bowl and bake it";
        accepted(serde_json::from_value(answer).expect("has the form"), text, &scene_objects())
    }

    fn put(words: &str, object: &str, target: Value) -> Value {
        json!([{ "words": words, "predicate": "in", "object": object, "target": target, "second_target": null }])
    }

    #[test]
    fn conditions_are_about_objects_of_the_scene() {
        let whole = "put the apple in the bowl and bake it";
        let program = answered(put(whole, "apple_1", json!("the bowl")), &[]).expect("holds").program();
        assert_eq!(program.statements[0].meaning.target.as_deref(), Some("the bowl"));
        let half = put("put the apple in the bowl", "apple_1", json!("bowl_1"));
        assert_eq!(
            answered(half.clone(), &["bake it"]).expect("holds"),
            Read::NotUnderstood(vec!["bake it".to_owned()])
        );
        assert!(answered(half, &[]).is_err(), "half of it is left out");
        assert!(answered(put(whole, "the lamp", json!("bowl_1")), &[]).is_err(), "no such object");
        assert!(answered(put(whole, "apple_1", Value::Null), &[]).is_err(), "in nothing");
    }
}
