//! Selectors among several objects of a category: "the left mug", "the second one", "the other", "the topmost plate".

use super::modifiers::is_attribute;
use super::{Chunk, Determiner, is_boundary, noun_ahead, starts_noun};
use crate::text_parser::measures::read_measure;
use crate::text_parser::tokens::{Token, match_phrase, word};
use scene::RelationKind;

/// Selector among several objects of a category, beside their attributes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::text_parser) enum Selector {
    Side(RelationKind),
    /// "the second mug".
    Ordinal(usize),
    /// "the other mug", "the others".
    Other,
    /// "the topmost plate".
    Top,
    /// "the lowest plate".
    Bottom,
    /// "the former".
    Former,
    /// "the latter".
    Latter,
}

impl Chunk<'_, '_> {
    /// A selector after "the". Whether the rule applies; the caller skips the word.
    pub(super) fn selector(&mut self) -> bool {
        let Some(w) = self.word(0) else { return false };
        if self.phrase.determiner != Determiner::Definite {
            return false;
        }
        let Some(selector) = selector_of(w) else { return false };
        let noun = match read_measure(self.lexicon.vocabulary, self.tokens, self.at + 1) {
            // "the other 20 cm wide", but "the other 20 cm box".
            Some((_, length)) => noun_ahead(self.lexicon, self.tokens, self.at + 1 + length),
            None => starts_noun(self.lexicon, self.tokens, self.at + 1) || self.is_one(self.at + 1),
        };
        let named = self.lexicon.longest_at(self.tokens, self.at).is_some_and(|(_, length)| length > 1);
        if named || !noun && !self.stands_alone(selector) {
            return false;
        }
        self.alone = !noun;
        self.phrase.selector = Some(selector);
        true
    }

    /// "the other is blue", "the second holds a pear": the noun is left out.
    fn stands_alone(&self, selector: Selector) -> bool {
        // "the top" is also a part of an object.
        let is_end = matches!(
            word(self.tokens, self.at),
            Some("topmost" | "uppermost" | "highest" | "bottommost" | "lowest" | "lowermost")
        );
        if !is_end && !matches!(selector, Selector::Other | Selector::Ordinal(_)) {
            return false;
        }
        let vocabulary = self.lexicon.vocabulary;
        match self.tokens.get(self.at + 1) {
            None | Some(Token::Pause | Token::End) => true,
            Some(Token::Number(_)) => read_measure(vocabulary, self.tokens, self.at + 1).is_some(),
            Some(Token::Word(next)) => {
                next != "of"
                    && (is_boundary(vocabulary, next)
                        || is_attribute(vocabulary, next)
                        || vocabulary.states.contains_key(next)
                        || word(self.tokens, self.at + 2)
                            .is_some_and(|third| vocabulary.states.contains_key(&format!("{next} {third}"))))
            }
        }
    }
}

/// "from the left" at `at` behind a noun with a rank: the side from which it counts, and the number of words.
pub(super) fn side_of_rank(rank: Selector, tokens: &[Token], at: usize) -> Option<(RelationKind, usize)> {
    let Selector::Ordinal(_) = rank else { return None };
    let from = match_phrase(tokens, at, "from the")?;
    let Some(Selector::Side(side)) = word(tokens, at + from).and_then(selector_of) else { return None };
    let goes_on = matches!(
        word(tokens, at + from + 1),
        Some("of" | "side" | "edge" | "corner" | "half" | "end" | "part" | "third" | "drawer" | "shelf")
    );
    (!goes_on).then_some((side, from + 1))
}

fn selector_of(word: &str) -> Option<Selector> {
    Some(match word {
        "left" | "leftmost" => Selector::Side(RelationKind::AtLeft),
        "right" | "rightmost" => Selector::Side(RelationKind::AtRight),
        "front" => Selector::Side(RelationKind::AtFront),
        "back" | "rear" => Selector::Side(RelationKind::AtBack),
        "middle" | "center" | "central" => Selector::Side(RelationKind::AtCenter),
        "first" => Selector::Ordinal(0),
        "second" => Selector::Ordinal(1),
        "third" => Selector::Ordinal(2),
        "fourth" => Selector::Ordinal(3),
        "other" | "others" | "remaining" | "rest" => Selector::Other,
        "top" | "topmost" | "uppermost" | "highest" => Selector::Top,
        "bottom" | "bottommost" | "lowest" | "lowermost" => Selector::Bottom,
        _ => return None,
    })
}
