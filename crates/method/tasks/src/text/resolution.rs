//! The objects of the scene that a noun phrase means.

use std::ops::Range;

use editing::references::{ReferenceError, resolve};
use scene::SceneDescription;
use scene::text_account::TextMeaning;

use super::Reading;
use super::noun_phrases::NounPhrase;
use crate::refusal::Refusal;

/// Objects that a phrase means, and its bytes in the text.
#[derive(Clone, Debug)]
pub(super) struct Resolved {
    /// Indices of objects of the scene, ascending, not empty.
    pub indices: Vec<usize>,
    pub bytes: Range<usize>,
}

/// Resolves the longest form of a phrase that is understood; a word is left out only if another rule reads it.
///
/// # Errors
///
/// [`Refusal`] as for [`resolve`].
pub(super) fn resolved(
    reading: &Reading,
    description: &SceneDescription,
    phrases: &[NounPhrase],
    index: usize,
) -> Result<Resolved, Refusal> {
    let phrase = &phrases[index];
    let overlaps = |bytes: &Range<usize>| bytes.start < phrase.bytes.end && phrase.bytes.start < bytes.end;
    if let Some((bytes, object)) = reading.named.iter().find(|(bytes, _)| overlaps(bytes)) {
        return Ok(Resolved { indices: vec![*object], bytes: bytes.clone() });
    }
    let mut forms = vec![phrase.start..phrase.end, phrase.start..phrase.bytes.end, phrase.bytes.clone()];
    forms.dedup();
    let mut first_error = None;
    for bytes in forms {
        let words = corrected(reading.text(), &bytes, description);
        let words = with_noun(words, phrases, index, reading.text());
        match resolve(reading.scene.described(), &words) {
            Ok(indices) => return Ok(Resolved { indices, bytes }),
            // A shorter form may leave such words to the parser.
            Err(ReferenceError::NotUnderstood { phrase, words }) => {
                first_error.get_or_insert(Refusal::ReferenceNotUnderstood { phrase, words });
            }
            Err(error) => return Err(refusal(error)),
        }
    }
    Err(first_error.unwrap_or(Refusal::NoGoal))
}

/// The refusal of a phrase.
fn refusal(error: ReferenceError) -> Refusal {
    match error {
        ReferenceError::NotFound { phrase, candidates } => Refusal::AbsentObject { phrase, candidates },
        ReferenceError::TooFew { phrase, found, .. } => Refusal::AbsentObject { phrase, candidates: found },
        ReferenceError::Ambiguous { phrase, candidates } => {
            Refusal::AmbiguousReference { phrase, candidates }
        }
        ReferenceError::NotUnderstood { phrase, words } => Refusal::ReferenceNotUnderstood { phrase, words },
    }
}

/// The bytes of the text, with misspelled words as the parser reads them.
fn corrected(text: &str, bytes: &Range<usize>, description: &SceneDescription) -> String {
    let mut words = text[bytes.clone()].to_owned();
    for part in description.understood.iter().rev() {
        if let TextMeaning::Correction { corrected } = &part.meaning
            && part.span.start >= bytes.start
            && part.span.end <= bytes.end
        {
            words.replace_range(part.span.start - bytes.start..part.span.end - bytes.start, corrected);
        }
    }
    words
}

/// "the blue one" with the noun of the phrase before it.
fn with_noun(words: String, phrases: &[NounPhrase], index: usize, text: &str) -> String {
    let Some(stem) = words.strip_suffix("ones").or_else(|| words.strip_suffix("one")) else { return words };
    let earlier = phrases[..index].last();
    match earlier.and_then(|phrase| text[phrase.bytes.clone()].rsplit(' ').next()) {
        Some(noun) if stem.ends_with(' ') => format!("{stem}{noun}"),
        _ => words,
    }
}
