//! "Stand" and "rest" as verbs: "a cake stand" and "a spoon rest" are objects, "the monitor stands at the back" and
//! "the cups stand side by side" are not.

use super::lexicon::Lexicon;
use super::prepositions::{place_at, preposition_at};
use super::tokens::{Source, Token, match_phrase, word};

/// Phrases that follow only a verb with several subjects.
const MUTUAL: &[&str] = &[
    "side by side",
    "next to each other",
    "next to one another",
    "beside each other",
    "opposite each other",
    "facing each other",
    "close together",
    "together",
    "apart",
    "in a row",
    "in a line",
    "in a circle",
];

/// Replaces such verbs by forms of "be", which no name of an object contains.
pub(super) fn separate(lexicon: &Lexicon, source: &mut Source) {
    for at in 1..source.tokens.len() {
        let replacement = match word(&source.tokens, at) {
            Some("stands" | "rests") if is_singular_verb(&source.tokens, at) => "is",
            Some("stand" | "rest") if is_plural_verb(lexicon, &source.tokens, at) => "are",
            _ => continue,
        };
        source.tokens[at] = Token::Word(replacement.to_owned());
    }
}

fn is_position(tokens: &[Token], at: usize) -> bool {
    preposition_at(tokens, at).is_some()
        || place_at(tokens, at, &|word| matches!(word, "table" | "desk" | "bench")).is_some()
        || matches!(word(tokens, at), Some("upright" | "alone" | "centered" | "facing"))
        || MUTUAL.iter().any(|phrase| match_phrase(tokens, at, phrase).is_some())
}

/// Words before `at` in its sentence, nearest first.
fn before(tokens: &[Token], at: usize) -> impl Iterator<Item = &str> {
    tokens[..at].iter().rev().map_while(Token::word)
}

/// "the monitor stands at the back"; not "two laptop stands at the back".
fn is_singular_verb(tokens: &[Token], at: usize) -> bool {
    let is_article =
        |word: &str| matches!(word, "a" | "an" | "the" | "that" | "this" | "one" | "each" | "every");
    is_position(tokens, at + 1)
        && !is_article(word(tokens, at - 1).unwrap_or("the"))
        && before(tokens, at).take(5).find(|word| is_article(word) || is_number(word)).is_some_and(is_article)
}

fn is_number(word: &str) -> bool {
    matches!(word, "two" | "three" | "four" | "five" | "six" | "some" | "several" | "both" | "no" | "and")
}

/// "the cups stand in a row", "the red cup and the blue cup stand side by side"; not "a cake stand on the table".
fn is_plural_verb(lexicon: &Lexicon, tokens: &[Token], at: usize) -> bool {
    let plural =
        lexicon.longest_at(tokens, at - 1).is_some_and(|(entry, length)| entry.plural && length == 1);
    let joined = before(tokens, at).take(8).any(|word| word == "and");
    let mutual = MUTUAL.iter().any(|phrase| match_phrase(tokens, at + 1, phrase).is_some());
    let definite = before(tokens, at).take(4).any(|word| word == "the");
    plural && is_position(tokens, at + 1) || joined && (mutual || definite && is_position(tokens, at + 1))
}

#[cfg(test)]
mod tests {
    use super::super::LEXICON;
    use super::*;

    #[test]
    fn verbs_are_distinguished_from_parts_of_names() {
        for (text, expected) in [
            ("A monitor stands centered at the back", "a monitor is centered at the back"),
            ("The cup and the jar stand side by side", "the cup and the jar are side by side"),
            ("The jars stand on a tray", "the jars are on a tray"),
            ("A spoon rests on a plate", "a spoon is on a plate"),
            ("A cake stand next to a jar", "a cake stand next to a jar"),
            ("A spoon rest on the table", "a spoon rest on the table"),
            ("Two laptop stands at the back", "two laptop stands at the back"),
            ("On the desk stands a lamp", "on the desk stands a lamp"),
        ] {
            let mut source = Source::read(text);
            separate(&LEXICON, &mut source);
            let words: Vec<&str> = source.tokens.iter().filter_map(Token::word).collect();
            assert_eq!(words.join(" "), expected, "{text}");
        }
    }
}
