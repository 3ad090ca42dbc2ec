//! Instructions about a finished scene: what [`read_edit`](super::read_edit) and [`read_task`](super::read_task) have
//! in common. Every word of an instruction is part of a statement, asks for nothing, or is not understood.

use std::collections::BTreeSet;

use serde_json::{Value, json};

use super::repair_turn::Topic;
use super::response_values::{Complaints, clipped};
use super::{ChatAnalyst, rejected, schema};
use crate::prompt::Prompt;
use editing::EditableObject;
use editing::references::resolve;
use language::words::is_function_word;
use ports::instruction_reader::NOT_UNDERSTOOD;
use ports::{Call, Instruction, ProviderError};
use scene::Supporter;
use serde::de::DeserializeOwned;

/// Maximum length of an instruction, characters.
const MAX_CHARS: usize = 4000;

/// Maximum length of a phrase for objects, characters.
const MAX_PHRASE_CHARS: usize = 200;

/// Maximum number of statements of a program.
const MAX_STATEMENTS: usize = 64;

/// Seed of the questions: the same instruction is the same question, so that it is paid once.
const SEED: u64 = 0;

/// Words of an instruction that are part of no statement.
pub(super) struct Remaining {
    pub not_understood: Vec<String>,
    pub asides: Vec<String>,
}

/// A valid answer.
#[derive(Debug, PartialEq)]
pub(super) enum Read<P> {
    Program(P),
    /// Words that ask for something that no statement expresses.
    NotUnderstood(Vec<String>),
}

impl<P> Read<P> {
    /// The program, unless words are not understood.
    pub fn unless(not_understood: Vec<String>, program: P) -> Self {
        if not_understood.is_empty() { Self::Program(program) } else { Self::NotUnderstood(not_understood) }
    }

    #[cfg(test)]
    pub fn program(self) -> P {
        match self {
            Self::Program(program) => program,
            Self::NotUnderstood(words) => panic!("{words:?} are not understood"),
        }
    }
}

/// Schema of an answer with these statements.
pub(super) fn program_schema(statement: &[(&str, Value)]) -> Value {
    let mut fields = vec![("words", schema::text("words of the instruction, copied"))];
    fields.extend(statement.iter().cloned());
    schema::object(&[
        ("statements", schema::list(&schema::object(&fields))),
        ("not_understood", schema::list(&schema::text("words of the instruction, copied"))),
        ("asides", schema::list(&schema::text("words of the instruction, copied"))),
    ])
}

/// Asks for the program of an instruction.
pub(super) async fn ask_for_program<T, P>(
    analyst: &ChatAnalyst,
    call: &Call,
    prompt: &'static Prompt,
    form: Value,
    instruction: &Instruction,
    accept: impl Fn(T) -> Result<Read<P>, Vec<String>>,
) -> Result<P, ProviderError>
where
    T: DeserializeOwned,
{
    let text = instruction.text.trim();
    if text.is_empty() {
        return Err(rejected("text_empty", "the instruction is empty: say what to do".to_owned()));
    }
    let chars = text.chars().count();
    if chars > MAX_CHARS {
        let reason =
            format!("the instruction has {chars} characters, the most sent is {MAX_CHARS}: split it");
        return Err(rejected("text_too_long", reason));
    }
    let objects: Vec<Value> = instruction.objects.iter().map(|object| summary(object, instruction)).collect();
    let data = json!({ "instruction": text, "objects": objects });
    let topic = Topic { prompt, schema: form, seed: SEED, data, images: Vec::new() };
    match analyst.ask(call, topic, accept).await? {
        Read::Program(program) => Ok(program),
        Read::NotUnderstood(words) => {
            let quoted = words.iter().map(|words| format!("{words:?}")).collect::<Vec<_>>().join(", ");
            let reason = format!("{quoted} of the instruction is not understood: reword it");
            Err(rejected(NOT_UNDERSTOOD, reason))
        }
    }
}

fn summary(object: &EditableObject, instruction: &Instruction) -> Value {
    let name_of = |index: usize| instruction.objects.get(index).map(|object| object.name.to_string());
    let carried_by = match object.supporter {
        Supporter { parent: Some(index), .. } => name_of(index),
        Supporter { parent: None, .. } => Some("table".to_owned()),
    };
    let millimeters = |length_m: f64| (1e3 * length_m).round() / 1e3;
    let center = object.footprint.center();
    json!({
        "name": object.name,
        "label": object.label,
        "category": object.category,
        "color": object.color.map(|color| color.to_hex()),
        "material": object.material,
        "size_m": object.size_m.to_array().map(millimeters),
        "position_m": [millimeters(center.x), millimeters(center.y)],
        "carried_by": carried_by,
    })
}

/// Checks the words of a program: their number, that they are those of the instruction, and that none is left out.
pub(super) fn check_words(
    text: &str,
    statements: &[&str],
    remaining: &Remaining,
    complaints: &mut Complaints,
) {
    if statements.len() > MAX_STATEMENTS {
        complaints
            .add(format!("there are {} statements; at most {MAX_STATEMENTS} are allowed", statements.len()));
        return;
    }
    if statements.is_empty() && remaining.not_understood.is_empty() {
        complaints.add("there is no statement; say in `not_understood` which words ask for something else");
    }
    let said = words(text);
    let mut covered: BTreeSet<usize> = BTreeSet::new();
    let others = remaining.not_understood.iter().chain(&remaining.asides).map(String::as_str);
    for part in statements.iter().copied().chain(others) {
        let part_words = words(part);
        let starts: Vec<usize> = match part_words.len() {
            0 => Vec::new(),
            length => (0..(said.len() + 1).saturating_sub(length))
                .filter(|&at| said[at..at + length] == part_words[..])
                .collect(),
        };
        if starts.is_empty() {
            let part = clipped(part);
            complaints
                .add(format!("{part:?} are not words of the instruction in one piece; copy them exactly"));
        }
        covered.extend(starts.iter().flat_map(|&at| at..at + part_words.len()));
    }
    let left: Vec<&str> =
        (0..said.len()).filter(|at| !covered.contains(at)).map(|at| said[at].as_str()).collect();
    if !left.iter().all(|word| is_function_word(word)) {
        complaints.add(format!(
            "the words {:?} are in no statement, nor in `not_understood` or `asides`",
            left.join(" ")
        ));
    }
}

fn words(text: &str) -> Vec<String> {
    text.split(|letter: char| !letter.is_alphanumeric() && letter != '_' && letter != '\'')
        .filter(|word| !word.is_empty())
        .map(str::to_lowercase)
        .collect()
}

/// Requires that a phrase names objects of the scene.
pub(super) fn check_phrase(at: &str, phrase: &str, objects: &[EditableObject], complaints: &mut Complaints) {
    if phrase.chars().count() > MAX_PHRASE_CHARS {
        complaints.add(format!("{at}: {:?}... is too long for a phrase", clipped(phrase)));
    } else if let Err(error) = resolve(objects, phrase) {
        complaints.add(format!("{at}: {error}"));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn complaints(statements: &[&str], not_understood: &[&str], asides: &[&str]) -> Vec<String> {
        let owned = |words: &[&str]| words.iter().map(|word| (*word).to_owned()).collect();
        let remaining = Remaining { not_understood: owned(not_understood), asides: owned(asides) };
        let mut complaints = Complaints::default();
        check_words(
            "Hello! Put the mug on the tray, then crack the egg.",
            statements,
            &remaining,
            &mut complaints,
        );
        complaints.none_or(()).err().unwrap_or_default()
    }

    #[test]
    fn every_word_is_in_a_statement_or_reported() {
        assert_eq!(complaints(&["Put the mug on the tray"], &["crack the egg"], &["Hello"]), [""; 0]);
        let lazy = complaints(&["Put the mug on the tray"], &[], &["Hello"]);
        assert!(lazy[0].contains("then crack the egg"), "{lazy:?}");
        let invented =
            complaints(&["Put the mug on the tray", "open the box"], &["crack the egg"], &["Hello"]);
        assert!(invented[0].contains("open the box"), "{invented:?}");
        assert!(!complaints(&[], &[], &["Hello! Put the mug on the tray, then crack the egg."]).is_empty());
    }
}
