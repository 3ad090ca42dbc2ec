//! The objects that a phrase means: a name (`mug_1`) or an English noun phrase ("the second book from the left").
//!
//! Directions are as seen from the front edge. Ranks count from the left unless the phrase says from where. A noun
//! names what has it in its label; else what is of the category, of the superclass ("fruit"), or of a category with
//! that synonym. A color or material is that of the label or the measured one; where one object is meant and exactly
//! one label says it, that object is meant. "Small" and "large" compare the objects that otherwise fit. In "the spoon
//! in the mug" the spoon may tell which mug is meant. "The mug next to the lamp" is at most 15 cm away, or the only
//! one within 30 cm. No word is ignored: an unknown word is an error. "The other mug" does not say which one it is
//! not: it is an error where several fit, and "the mug other than the red mug" is none.
//!
//! A phrase costs the product of its words, the objects and the synonyms of their categories.

mod color_match;
mod phrase;
mod qualifier;
mod noun;
mod modifier;
mod places;
mod picks;
mod relatives;
mod selection;

pub use language::vocabulary::{MaterialWord, color_of, material_of, theme_of};

use crate::EditableObject;
use runtime::edit_distance;
use scene::InstanceId;
use selection::Selector;

/// Reason why a phrase does not state which objects are meant.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ReferenceError {
    /// No object fits. The candidates are those that are spelled alike or fit in part; where there are none, all.
    #[error("no object fits {phrase:?}{}", hint("; there are", .candidates))]
    NotFound { phrase: String, candidates: Vec<InstanceId> },
    /// Fewer objects are meant than fit.
    #[error(
        "{phrase:?} fits several objects: {}; name the one that is meant, or add its color, size or place",
        list(.candidates)
    )]
    Ambiguous { phrase: String, candidates: Vec<InstanceId> },
    /// More objects are meant than fit.
    #[error("{phrase:?} asks for {wanted} objects, but {} fit{}", .found.len(), hint(":", .found))]
    TooFew { phrase: String, wanted: usize, found: Vec<InstanceId> },
    /// Words without a meaning here.
    #[error(
        "in {phrase:?}, {words:?} is not understood; name the object (`mug_1`) or use its label, color, size, material \
         or place"
    )]
    NotUnderstood { phrase: String, words: Vec<String> },
}

impl ReferenceError {
    fn not_found(objects: &[EditableObject], phrase: &str, near: Vec<InstanceId>) -> Self {
        let all = || objects.iter().map(|object| object.name.clone()).collect();
        let candidates = if near.is_empty() { all() } else { near };
        Self::NotFound { phrase: phrase.trim().to_owned(), candidates }
    }
}

fn list(names: &[InstanceId]) -> String {
    names.iter().map(InstanceId::as_str).collect::<Vec<_>>().join(", ")
}

fn hint(opening: &str, names: &[InstanceId]) -> String {
    if names.is_empty() { String::new() } else { format!("{opening} {}", list(names)) }
}

/// The objects of a scene, for the reader of instructions.
#[derive(Clone, Copy, Debug)]
pub struct SceneReferents<'a>(pub &'a [EditableObject]);

impl language::Referents for SceneReferents<'_> {
    fn is_noun(&self, words: &str) -> bool {
        let is_labeled = |object: &EditableObject| {
            let label = object.label.to_lowercase().replace('-', " ");
            label == words || label.strip_suffix(words).is_some_and(|start| start.ends_with(' '))
        };
        language::nouns::is_noun(words) || self.0.iter().any(is_labeled)
    }

    fn resolves(&self, phrase: &str) -> Option<bool> {
        Some(resolve(self.0, phrase).is_ok())
    }
}

/// The indices of the objects that a phrase means, ascending and not empty.
///
/// # Errors
///
/// [`ReferenceError`] if no object fits, if one is meant and several fit, if fewer fit than the phrase counts, or if a
/// word has no meaning.
pub fn resolve(objects: &[EditableObject], phrase: &str) -> Result<Vec<usize>, ReferenceError> {
    resolve_newest(objects, phrase, &[])
}

/// As [`resolve`]; where more objects fit than are meant, those of `newest` are preferred, which lists objects that
/// earlier operations of the edit made, the latest last. "The red mug" after "add a red mug" is the new one.
///
/// # Errors
///
/// As for [`resolve`].
pub fn resolve_newest(
    objects: &[EditableObject],
    phrase: &str,
    newest: &[usize],
) -> Result<Vec<usize>, ReferenceError> {
    let name = phrase.trim().to_lowercase();
    if let Some(index) = objects.iter().position(|object| object.name.as_str() == name) {
        return Ok(vec![index]);
    }
    let found = resolve_words(objects, phrase, phrase::words(phrase), newest);
    let Err(error) = found else { return found };
    match corrected(objects, phrase) {
        Some(words) => resolve_words(objects, phrase, words, newest).map_err(|_| error),
        None => Err(error),
    }
}

/// The words of a phrase, misspelled ones as a label has them; `None` where no other spelling is likely.
fn corrected(objects: &[EditableObject], phrase: &str) -> Option<Vec<String>> {
    let labels: Vec<String> =
        objects.iter().map(|object| object.label.to_lowercase().replace('-', " ")).collect();
    let known: std::collections::BTreeSet<&str> = labels.iter().flat_map(|label| label.split(' ')).collect();
    let is_known = |word: &str| {
        word.chars().count() < 4
            || known.contains(word)
            || language::nouns::is_noun(word)
            || color_of(word).is_some()
            || material_of(word).is_some()
    };
    let mut is_changed = false;
    let mut correct = |word: String| {
        let mut near = known.iter().filter(|other| other.len() > 2 && edit_distance(&word, other) == 1);
        match (is_known(&word), near.next(), near.next()) {
            (false, Some(only), None) => {
                is_changed = true;
                (*only).to_owned()
            }
            _ => word,
        }
    };
    let words = phrase::words(phrase).into_iter().map(&mut correct).collect();
    is_changed.then_some(words)
}

fn resolve_words(
    objects: &[EditableObject],
    phrase: &str,
    words: Vec<String>,
    newest: &[usize],
) -> Result<Vec<usize>, ReferenceError> {
    let not_understood =
        |words: Vec<String>| ReferenceError::NotUnderstood { phrase: phrase.trim().to_owned(), words };
    let phrases = phrase::read_phrase(&words).map_err(not_understood)?;
    let (selector, all) = (Selector { objects, newest }, (0..objects.len()).collect::<Vec<_>>());
    let mut found = Vec::new();
    for phrase in &phrases {
        found.extend(selector.select(phrase, &all)?);
    }
    found.sort_unstable();
    found.dedup();
    if found.is_empty() {
        return Err(ReferenceError::not_found(objects, phrase, Vec::new()));
    }
    Ok(found)
}

/// The index of the one object that a phrase means.
///
/// # Errors
///
/// As for [`resolve`]; several objects are [`ReferenceError::Ambiguous`].
pub fn resolve_one(objects: &[EditableObject], phrase: &str) -> Result<usize, ReferenceError> {
    match resolve(objects, phrase)?[..] {
        [index] => Ok(index),
        ref several => Err(ReferenceError::Ambiguous {
            phrase: phrase.trim().to_owned(),
            candidates: several.iter().map(|&index| objects[index].name.clone()).collect(),
        }),
    }
}

/// Names of objects whose name or label is spelled alike, best first.
fn nearest_names(objects: &[EditableObject], words: &str) -> Vec<InstanceId> {
    let limit = words.chars().count() / 3;
    let near = |object: &EditableObject| {
        let label = object.label.to_lowercase();
        let last = label.rsplit(' ').next().unwrap_or_default();
        let spellings = [object.name.as_str(), &label, last];
        spellings.iter().map(|spelling| edit_distance(words, spelling)).min().unwrap_or(usize::MAX)
    };
    let mut scored: Vec<(usize, &InstanceId)> = objects
        .iter()
        .map(|object| (near(object), &object.name))
        .filter(|(distance, _)| *distance <= limit.clamp(1, 3))
        .collect();
    scored.sort();
    scored.into_iter().take(5).map(|(_, name)| name.clone()).collect()
}
