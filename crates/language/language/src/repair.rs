//! Corrections within a sentence: "four oranges, no wait, six", "the green pepper, no, the yellow one".
//!
//! What is meant begins with a word of the kind with which that begins what is taken back (Levelt, "Monitoring and
//! self-repair in speech", Cognition 14 (1983)): an article, a number, a color or a preposition. A number or a color
//! alone takes the place of the one before it.

use std::ops::Range;

use crate::lexicon::lexicon;
use crate::measures::number_at;
use crate::tokens::{Token, tokens};
use crate::vocabulary::vocabulary;

/// A correction of a text, in bytes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SelfRepair {
    /// Words that are taken back, and those that say so.
    pub retracted: Range<usize>,
    /// A word that is left, and the words that are meant in its place.
    pub replaced: Option<(Range<usize>, Range<usize>)>,
}

/// Longest part that is taken back, tokens.
const LONGEST: usize = 8;

/// Kind of the word with which both parts of a correction begin.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Determiner,
    Number,
    Color,
    Preposition,
}

/// The corrections in a text, in their order.
///
/// ```
/// let text = "two, no, three plates";
/// let found = &language::repair::repairs(text)[0];
/// assert_eq!(&text[found.retracted.clone()], "two, no, ");
/// ```
pub fn repairs(text: &str) -> Vec<SelfRepair> {
    repaired(text, tokens(text)).1
}

/// Tokens as they are meant, and the corrections by which they are.
pub(crate) fn repaired(text: &str, tokens: Vec<Token>) -> (Vec<Token>, Vec<SelfRepair>) {
    let (mut words, mut found) = (Words { text, tokens }, Vec::new());
    let mut at = 1;
    while at < words.tokens.len() {
        match words.repair_at(at) {
            Some(repair) => {
                words.apply(&repair);
                found.push(repair);
                at = 1;
            }
            None => at += 1,
        }
    }
    (words.tokens, found)
}

struct Words<'a> {
    text: &'a str,
    tokens: Vec<Token>,
}

impl Words<'_> {
    fn word(&self, at: usize) -> &str {
        self.tokens.get(at).filter(|token| !token.is_quoted).map_or("", |token| token.word.as_str())
    }

    /// Whether a mark or a dash divides a token from the one before it.
    fn is_apart(&self, at: usize) -> bool {
        let (Some(before), Some(token)) = (self.tokens.get(at.wrapping_sub(1)), self.tokens.get(at)) else {
            return true;
        };
        let between = self.text.get(before.span.end..token.span.start).unwrap_or_default();
        matches!(before.word.as_str(), "," | ":") || between.contains(['-', '–', '—', '(', ')', '…'])
    }

    /// The correction whose words "no, wait" stand at an index.
    fn repair_at(&self, at: usize) -> Option<SelfRepair> {
        let longest = |class: &str| lexicon().lengths(class, &self.tokens, at).into_iter().max();
        let plain = longest("correction").map(|length| at + length);
        let mut start = plain.or_else(|| {
            let end = at + longest("correction_apart").filter(|_| self.is_apart(at))?;
            self.is_apart(end + usize::from(self.word(end) == ",")).then_some(end)
        })?;
        start += usize::from(self.word(start) == ",");
        // The pause before it belongs to the correction.
        let end = if self.word(at - 1) == "," { at - 1 } else { at };
        let from =
            (end.saturating_sub(LONGEST)..end).rev().find(|&k| self.word(k) == ".").map_or(0, |k| k + 1);
        let from = from.max(end.saturating_sub(LONGEST));
        if let Some(length) = self.value_alone(start) {
            return self.replacing(from..end, start..start + length);
        }
        let kind = self.kinds(start)?;
        let before = (from..end).rev().find(|&k| self.kinds(k) == Some(kind) && self.begins(k))?;
        // "onto the tray, or rather behind it": what is taken back is what "it" means.
        if kind == Kind::Preposition && matches!(self.word(start + 1), "it" | "them" | "that" | "this") {
            return None;
        }
        Some(SelfRepair {
            retracted: self.tokens[before].span.start..self.tokens[start].span.start,
            replaced: self.named_one(before..end, start),
        })
    }

    /// A number or a color without a noun replaces the last one of its kind.
    fn replacing(&self, before: Range<usize>, value: Range<usize>) -> Option<SelfRepair> {
        let kind = self.value_kind(value.start)?;
        let of_kind =
            |k: usize| self.value_kind(k).filter(|found| *found == kind).map(|_| self.value_length(k));
        let (at, length) = before.clone().rev().find_map(|k| Some((k, of_kind(k)?)))?;
        let spans =
            |range: Range<usize>| self.tokens[range.start].span.start..self.tokens[range.end - 1].span.end;
        let last = self.tokens.get(before.end)?;
        Some(SelfRepair {
            retracted: last.span.start..self.tokens[value.end - 1].span.end,
            replaced: Some((spans(at..at + length), spans(value))),
        })
    }

    /// Number of tokens of a number or a color that no noun follows.
    fn value_alone(&self, at: usize) -> Option<usize> {
        self.value_kind(at)?;
        let end = at + self.value_length(at);
        let is_end = matches!(self.word(end), "" | "," | "." | "and" | ":" | "of" | "please" | "instead");
        (is_end || self.is_apart(end) || self.is_preposition(end)).then(|| end - at)
    }

    /// A number with its unit, or a color.
    fn value_kind(&self, at: usize) -> Option<Kind> {
        if self.tokens.get(at).is_none_or(|token| token.is_quoted) || matches!(self.word(at), "a" | "an") {
            return None;
        }
        if number_at(&self.tokens, at).is_some() {
            Some(Kind::Number)
        } else {
            vocabulary().is_color(self.word(at)).then_some(Kind::Color)
        }
    }

    fn value_length(&self, at: usize) -> usize {
        let Some((_, length)) = number_at(&self.tokens, at) else { return 1 };
        let is_unit =
            matches!(self.word(at + length), "cm" | "mm" | "m" | "centimeters" | "inches" | "degrees");
        length + usize::from(is_unit)
    }

    fn is_preposition(&self, at: usize) -> bool {
        const RELATIONS: &[&str] = &[
            "left_of",
            "right_of",
            "in_front_of",
            "behind",
            "next_to",
            "on",
            "in",
            "between",
            "from",
            "out_of",
        ];
        self.word(at) == "to"
            || self.word(at) == "at"
            || RELATIONS.iter().any(|class| !lexicon().lengths(class, &self.tokens, at).is_empty())
    }

    fn kinds(&self, at: usize) -> Option<Kind> {
        let is_determiner = ["definite", "indefinite"]
            .iter()
            .any(|class| !lexicon().lengths(class, &self.tokens, at).is_empty());
        // "an apple" and "two apples" are of one kind.
        if is_determiner
            || self.value_kind(at) == Some(Kind::Number)
            || matches!(self.word(at), "some" | "no")
        {
            Some(Kind::Determiner)
        } else if self.is_preposition(at) {
            Some(Kind::Preposition)
        } else {
            self.value_kind(at)
        }
    }

    /// Whether a phrase begins at a token: "the two mugs" begins with "the".
    fn begins(&self, at: usize) -> bool {
        let Some(before) = at.checked_sub(1) else { return true };
        self.kinds(at) != Some(Kind::Determiner) || self.kinds(before) != Some(Kind::Determiner)
    }

    /// The token of "the yellow one" with the noun of the phrase that is taken back.
    fn named_one(&self, before: Range<usize>, start: usize) -> Option<(Range<usize>, Range<usize>)> {
        let describes = |at: usize| {
            self.kinds(at).is_some_and(|kind| kind != Kind::Preposition)
                || !lexicon().lengths("adjective", &self.tokens, at).is_empty()
        };
        let one = (start + 1..start + 4).find(|&k| matches!(self.word(k), "one" | "ones"))?;
        let noun = before.clone().find(|&k| !describes(k))?;
        let is_noun = |k: &usize| {
            !lexicon().is_function_word(self.word(*k))
                && !self.is_preposition(*k)
                && !self.word(*k).is_empty()
        };
        let end = (noun..before.end).take_while(is_noun).last()? + 1;
        let (first, last) = (&self.tokens[noun], &self.tokens[end - 1]);
        Some((self.tokens[one].span.clone(), first.span.start..last.span.end))
    }

    fn apply(&mut self, repair: &SelfRepair) {
        let within = |token: &Token, range: &Range<usize>| {
            range.start <= token.span.start && token.span.end <= range.end
        };
        let mut meant = Vec::with_capacity(self.tokens.len());
        for token in &self.tokens {
            match &repair.replaced {
                Some((old, new)) if within(token, old) => {
                    if token.span.start == old.start {
                        meant.extend(self.tokens.iter().filter(|token| within(token, new)).cloned());
                    }
                }
                _ if within(token, &repair.retracted) => {}
                _ => meant.push(token.clone()),
            }
        }
        self.tokens = meant;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn meant(text: &str) -> String {
        let (tokens, _) = repaired(text, tokens(text));
        tokens.iter().map(|token| token.word.as_str()).collect::<Vec<_>>().join(" ")
    }

    #[test]
    fn corrections_leave_what_is_meant() {
        for (text, expected) in [
            ("Four oranges, no wait, six, in a wire basket", "six oranges , in a wire basket"),
            (
                "put the green bell pepper, no, the yellow one into the colander",
                "put the yellow bell pepper into the colander",
            ),
            ("a red mug, I mean a blue one, next to the plate", "a blue mug , next to the plate"),
            ("two, sorry, three plates", "three plates"),
            (
                "put the fork to the left, no, to the right of the plate",
                "put the fork to the right of the plate",
            ),
            (
                "a bowl with three apples - make that four - and a banana",
                "a bowl with four apples and a banana",
            ),
            ("the plate, no, the bowl goes on the tray", "the bowl goes on the tray"),
            ("a mug, sorry, a cup and a spoon", "a cup and a spoon"),
            ("put the mug on the left, sorry, the right side", "put the mug on the right side"),
            ("an apple and a pear, no wait, two pears", "an apple and two pears"),
            ("a blue, no, green mug", "a green mug"),
            ("make it blue - no wait, green", "make it green"),
            ("the second from the left, no, from the right", "the second from the right"),
            ("move it 10 cm, no, 15 cm to the left", "move it 15 cm to the left"),
            ("move it 10 cm to the left, no, 15 cm", "move it 15 cm to the left"),
            ("four plates, no, five, no, six", "six plates"),
            ("the tall blue cups (I mean the red ones) go away", "the red cups go away"),
        ] {
            assert_eq!(meant(text), expected, "{text}");
        }
    }

    #[test]
    fn other_words_that_negate_or_excuse_change_nothing() {
        for text in [
            "a plate , a cup , no knife",
            "no plates , no cups",
            "sorry , can you move the mug",
            "move the mug , sorry , i was distracted",
            "move the mug onto the tray , or rather behind it",
            "i mean the red one",
            "take the cup . i mean the red one",
            "there are no plates , no , really",
            "are there plates ? no , the bowl is alone",
        ] {
            assert_eq!(meant(text), text.replace('?', "."), "{text}");
        }
    }
}
