//! The noun phrases of a description in its text: which bytes name which of its objects.

use std::collections::BTreeSet;
use std::ops::Range;

use scene::text_account::TextMeaning;
use scene::{InstanceId, SceneDescription};

use super::function_words::REQUEST_WORDS;
use super::words::{Word, is_determiner, is_joined, words};

/// A place of the text that names objects of the description.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct NounPhrase {
    /// Modifiers and noun.
    pub bytes: Range<usize>,
    /// With determiners and quantities before it ("the first of the two").
    pub start: usize,
    /// With relations behind it ("on the tray", "from the left").
    pub end: usize,
    /// Objects of the description.
    pub objects: Vec<InstanceId>,
    /// Index of the phrase that may say what they contain.
    pub contents: Option<usize>,
}

/// Words that the parser counts to a noun phrase and that are none of its words: prepositions and places of a goal.
const PLACES: &[&str] = &[
    "into", "onto", "near", "behind", "between", "beside", "under", "over", "in", "on", "to", "at", "of",
    "by", "with", "from", "off", "out", "up", "down", "upside", "upright", "left", "right", "front", "back",
    "top", "bottom", "rear", "corner", "side", "edge", "center", "centre", "middle", "table", "and", "away",
    "next", "inside", "its", "half",
];

/// Words between a noun and a relation that describes it.
const CONNECTORS: &[&str] = &[
    "that",
    "which",
    "is",
    "are",
    "the",
    "from",
    "at",
    "currently",
    "standing",
    "lying",
    "sitting",
    "located",
    "placed",
    "resting",
    "in",
    "on",
    "to",
];

/// The noun phrases of the objects of a description, in the order of the text.
pub(super) fn noun_phrases(text: &str, description: &SceneDescription) -> Vec<NounPhrase> {
    let words = words(text);
    let mut phrases: Vec<NounPhrase> = Vec::new();
    for word in &words {
        let objects = objects_of(word, description);
        let text_of = word.text.as_str();
        let is_place = PLACES.contains(&text_of) && !is_modifier(word, &words);
        if objects.is_empty() || is_place || REQUEST_WORDS.contains(&text_of) {
            continue;
        }
        match phrases.last_mut() {
            Some(last)
                if is_joined(text, last.bytes.end, word.bytes.start)
                    && last.objects.iter().any(|object| objects.contains(object)) =>
            {
                last.bytes.end = word.bytes.end;
                last.end = word.bytes.end;
                if objects.len() > last.objects.len() {
                    last.objects = objects;
                }
            }
            _ => phrases.push(NounPhrase {
                start: word.bytes.start,
                end: word.bytes.end,
                bytes: word.bytes.clone(),
                objects,
                contents: None,
            }),
        }
    }
    for phrase in &mut phrases {
        phrase.start = extended_start(text, &words, phrase.bytes.start);
    }
    for index in 0..phrases.len() {
        phrases[index].end = extended_end(text, &words, description, &phrases, index);
        phrases[index].contents = contents(&words, &phrases, index);
    }
    phrases
}

/// The objects that the parser says a word names or describes.
fn objects_of(word: &Word, description: &SceneDescription) -> Vec<InstanceId> {
    let overlaps =
        |span: &scene::text_account::TextSpan| span.start < word.bytes.end && word.bytes.start < span.end;
    let named = description.understood.iter().filter(|part| overlaps(&part.span));
    let lists = named.filter_map(|part| match &part.meaning {
        TextMeaning::Object { objects, .. } | TextMeaning::Property { objects, .. } => Some(objects),
        _ => None,
    });
    lists.max_by_key(|objects| objects.len()).cloned().unwrap_or_default()
}

/// "the left mug", "the front book": a place directly before a noun that follows a determiner.
fn is_modifier(word: &Word, words: &[Word]) -> bool {
    let side = ["left", "right", "front", "back", "top", "bottom", "middle", "center"];
    let Some(at) = words.iter().position(|other| other == word) else { return false };
    let after_determiner = at > 0 && is_determiner(&words[at - 1].text);
    let before_noun =
        words.get(at + 1).is_some_and(|next| !PLACES.contains(&next.text.as_str()) && next.text != "side");
    side.contains(&word.text.as_str()) && after_determiner && before_noun
}

/// Start of a phrase with its determiners, ranks and quantities, in bytes.
fn extended_start(text: &str, words: &[Word], start: usize) -> usize {
    let before: Vec<&Word> = words.iter().filter(|word| word.bytes.end <= start).collect();
    let mut from = start;
    for (index, word) in before.iter().enumerate().rev() {
        if !is_joined(text, word.bytes.end, from) {
            break;
        }
        let is_of = word.text == "of" && is_partitive(&before[..index]);
        let is_head_of_partitive =
            text[word.bytes.end..].trim_start().starts_with("of ") && is_rank(&word.text);
        if is_determiner(&word.text) || is_of || is_head_of_partitive || is_rank(&word.text) {
            from = word.bytes.start;
        } else {
            break;
        }
    }
    from
}

/// Whether the words end with what takes a part of several objects.
fn is_partitive(words: &[&Word]) -> bool {
    words.last().is_some_and(|word| is_rank(&word.text) || is_determiner(&word.text))
}

/// Ranks and superlatives.
fn is_rank(word: &str) -> bool {
    let ordinal = ["first", "second", "third", "fourth", "fifth", "last", "two", "three", "four", "five"];
    ordinal.contains(&word) || (word.ends_with("est") && word.len() > 4) || word.ends_with("most")
}

/// End of a phrase with the relations that describe it, in bytes.
fn extended_end(
    text: &str,
    words: &[Word],
    description: &SceneDescription,
    phrases: &[NounPhrase],
    index: usize,
) -> usize {
    let mut end = phrases[index].bytes.end;
    let mut seen = BTreeSet::new();
    'relations: loop {
        for part in &description.understood {
            let TextMeaning::Relation { objects, targets, .. } = &part.meaning else { continue };
            // "the plate on the right to the left side": a destination.
            let is_destination = targets.is_empty()
                && words
                    .iter()
                    .any(|word| word.text == "to" && (end..part.span.start).contains(&word.bytes.start));
            let follows =
                part.span.start >= end && is_connected(words, end, part.span.start) && !is_destination;
            let of_this = phrases[index].objects.iter().any(|object| objects.contains(object));
            if !follows || !of_this || !seen.insert(part.span.start) {
                continue;
            }
            let target_at = phrases[index + 1..]
                .iter()
                .find(|phrase| phrase.objects.iter().any(|object| targets.contains(object)));
            end = match target_at {
                // "to the left of the two plates": up to the end of the target.
                Some(target) if is_connected(words, part.span.end, target.bytes.start) => target.bytes.end,
                _ if targets.is_empty() => part.span.end,
                _ => return end,
            };
            continue 'relations;
        }
        return trailing_side(text, words, end);
    }
}

/// The next phrase, if it says what is in or on the objects of this one ("the cup with the spoon").
fn contents(words: &[Word], phrases: &[NounPhrase], index: usize) -> Option<usize> {
    let (phrase, contents) = (&phrases[index], phrases.get(index + 1)?);
    let between = words
        .iter()
        .filter(|word| word.bytes.start >= phrase.bytes.end && word.bytes.end <= contents.start)
        .map(|word| word.text.as_str());
    let between: Vec<&str> = between.collect();
    let holds = matches!(between[..], ["with" | "containing" | "holding" | "under" | "underneath"]);
    holds.then_some(index + 1)
}

/// "on the left side of the table" beyond "on the left".
fn trailing_side(text: &str, words: &[Word], end: usize) -> usize {
    let mut to = end;
    for word in words.iter().filter(|word| word.bytes.start >= end) {
        if word.text != "side" || !is_joined(text, to, word.bytes.start) {
            break;
        }
        to = word.bytes.end;
    }
    to
}

/// Whether only connecting words are between two places of the text.
fn is_connected(words: &[Word], from: usize, to: usize) -> bool {
    let between = words.iter().filter(|word| word.bytes.start >= from && word.bytes.end <= to);
    let mut between = between.map(|word| word.text.as_str());
    between.all(|word| CONNECTORS.contains(&word) || is_determiner(word) || is_rank(word))
}
