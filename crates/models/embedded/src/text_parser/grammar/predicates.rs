//! Attributes after a verb or in brackets: "the laptop is silver", "a mug (red)", "a plate and a bowl, both white".

use super::Parser;
use super::references::merge;
use crate::text_parser::phrase::predicate;
use crate::text_parser::tokens::{Token, match_phrase};
use scene::text_account::UnrecognizedReason;

const COPULAS: &[&str] = &[
    "is",
    "are",
    "being",
    "was",
    "were",
    "in",
    "must be",
    "should be",
    "shall be",
    "will be",
    "can be",
    "could be",
    "may be",
    "has to be",
    "have to be",
    "needs to be",
    "need to be",
    "ought to be",
];

impl Parser<'_, '_> {
    /// Attributes of the subject. Whether the rule applies.
    pub(super) fn attributes(&mut self) -> bool {
        let verb = COPULAS.iter().filter_map(|phrase| match_phrase(self.tokens, self.at, phrase)).max();
        let bracket =
            self.at > 0 && matches!(self.tokens[self.at - 1], Token::Pause) && !self.subject.is_empty();
        let gap = self.predicate_at == Some(self.at);
        if verb.is_none() && !bracket && !gap {
            return false;
        }
        let start = self.at + verb.unwrap_or(0);
        let Some((attributes, properties, end)) = predicate(self.lexicon, self.tokens, start) else {
            return false;
        };
        let closes = matches!(self.tokens.get(end), None | Some(Token::Pause | Token::End))
            || gap && matches!(self.word_at(end), Some("and"));
        if verb.is_none() {
            // "a bowl, orange, ..." is a list of nouns.
            let open = self.at > 0 && self.source.is_open_bracket(self.at - 1);
            let noun = !gap && !open && self.lexicon.longest_at(self.tokens, self.at).is_some();
            // "a mug, a lime, and a lemon".
            let article = matches!(self.word(0), Some("a" | "an"));
            if !closes || noun || article {
                return false;
            }
        }
        let described = self.predicate_subjects(verb.is_some());
        if described.is_empty() {
            return false;
        }
        self.parsed.account.used(self.at..end);
        self.at = end;
        let other_color = described.iter().any(|&mention| {
            let known = &self.parsed.mentions[mention].attributes.color_words;
            !known.is_empty() && !attributes.color_words.is_empty() && *known != attributes.color_words
        });
        if other_color {
            for (_, range) in properties {
                self.report(range, UnrecognizedReason::Contradiction);
            }
            return true;
        }
        for &mention in &described {
            merge(&mut self.parsed.mentions[mention].attributes, attributes.clone());
        }
        for (property, range) in properties {
            self.claim_property(range, property, described.clone());
        }
        if verb.is_some() {
            self.predicated = self.subject.len();
        }
        true
    }

    /// The mentions that a predicate at the current position describes.
    fn predicate_subjects(&self, has_verb: bool) -> Vec<usize> {
        let Some(&last) = self.subject.last() else { return self.salient_list.clone() };
        match self.word(0) {
            // "a plate and a bowl, both white".
            Some("both" | "all" | "each") => self.subject.clone(),
            _ if !has_verb => vec![last],
            Some("is" | "was" | "has" | "needs" | "in") => vec![last],
            // What the last predicate of the sentence has described is not the subject of this one.
            _ => match self.subject.get(self.predicated..) {
                Some(more) if !more.is_empty() => more.to_vec(),
                _ => self.subject.clone(),
            },
        }
    }
}
