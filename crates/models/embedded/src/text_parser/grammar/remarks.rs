//! Remarks that ask for no object: "set up a scene in which ...", "this is only a test", "the handles don't matter",
//! and what is written on an object ("a box labeled 'nails'").

use super::Parser;
use crate::text_parser::measures::read_length;
use crate::text_parser::phrase::{Group, noun_phrase};
use crate::text_parser::phrases::phrases;
use crate::text_parser::tokens::{Token, match_phrase};
use scene::text_account::UnrecognizedReason;

impl Parser<'_, '_> {
    /// A remark at the current position. Whether the rule applies.
    pub(super) fn remark(&mut self) -> bool {
        self.set_up()
            || self.preference()
            || self.arranged_group()
            || self.self_description()
            || self.indifference()
            || self.writing()
    }

    fn begins(&self) -> bool {
        match self.at.checked_sub(1).map(|before| &self.tokens[before]) {
            None | Some(Token::Pause | Token::End) => true,
            Some(Token::Word(word)) => matches!(word.as_str(), "and" | "but" | "please" | "so" | "to"),
            Some(Token::Number(_)) => false,
        }
    }

    /// "set up a scene in which ...", "lay out a table with ...": what follows is described, not to be moved.
    fn set_up(&mut self) -> bool {
        let Some(length) = [
            "set up",
            "lay out",
            "put together",
            "put down",
            "set out",
            "setup",
            "initial state",
            "start state",
            "initial scene",
            "give me something like",
            "give us something like",
            "show me something like",
            "something like",
        ]
        .iter()
        .find_map(|phrase| match_phrase(self.tokens, self.at, phrase)) else {
            return false;
        };
        let p = self.at + length + usize::from(matches!(self.word(length), Some("me" | "us")));
        let indefinite = matches!(self.word_at(p), Some("a" | "an" | "one" | "some" | "several"))
            || matches!(self.tokens.get(p), Some(Token::Number(_)))
            || self.word_at(p).is_some_and(|word| self.lexicon.vocabulary.numbers.contains_key(word));
        // "set up: apple left, bowl right".
        let heads = self.is_colon(p);
        if !(indefinite || heads) || !self.begins() || self.instructed {
            return false;
        }
        self.parsed.account.used(self.at..p);
        self.at = p;
        self.clause_start = true;
        true
    }

    /// "use pencils in place of pens: three pencils, ...": the list says how many. Whether the rule applies.
    fn preference(&mut self) -> bool {
        if !self.begins() || !matches!(self.word(0), Some("use" | "choose" | "take" | "prefer")) {
            return false;
        }
        let Some((_, end)) = noun_phrase(self.lexicon, self.tokens, self.at + 1) else { return false };
        let instead = ["in place of", "instead of", "rather than", "in lieu of"]
            .iter()
            .find_map(|phrase| match_phrase(self.tokens, end, phrase));
        let Some(length) = instead else { return false };
        let Some((_, last)) = noun_phrase(self.lexicon, self.tokens, end + length) else { return false };
        // Before a list, the preferred objects are those of the list.
        let lists = self.is_colon(last);
        self.parsed.account.used(self.at..if lists { end } else { self.at + 1 });
        self.at = if lists { end } else { self.at + 1 };
        true
    }

    /// "put the six pawns in two rows of three": objects that the text has not named are described. Whether it applies.
    fn arranged_group(&mut self) -> bool {
        let verb = matches!(self.word(0), Some("put" | "place" | "arrange" | "set" | "lay"));
        let keeps = matches!(self.word(0), Some("keep" | "leave"));
        if !(verb || keeps) || !self.begins() || self.instructed || !self.parsed.mentions.is_empty() {
            return false;
        }
        let Some((phrase, end)) = noun_phrase(self.lexicon, self.tokens, self.at + 1) else { return false };
        // "keep the knife 25 cm away from the edge" says where it is.
        if keeps && read_length(self.lexicon.vocabulary, self.tokens, self.after_hedges(end)).is_some() {
            self.parsed.account.used(self.at..self.at + 1);
            self.at += 1;
            return true;
        }
        let group = self.phrase_at(end).and_then(|(group, _, _)| group);
        if !matches!(group, Some(Group::Grid | Group::Circle | Group::Pyramid | Group::Pile))
            || phrase.count.is_none()
        {
            return false;
        }
        self.parsed.account.used(self.at..self.at + 1);
        self.at += 1;
        true
    }

    /// "this is only a test".
    fn self_description(&mut self) -> bool {
        let is = ["this is", "that is", "it is"]
            .iter()
            .find_map(|phrase| match_phrase(self.tokens, self.at, phrase));
        let Some(length) = is.filter(|_| self.begins()) else { return false };
        let mut p = self.at + length;
        while matches!(
            self.word_at(p),
            Some(
                "only"
                    | "just"
                    | "simply"
                    | "merely"
                    | "not"
                    | "a"
                    | "an"
                    | "the"
                    | "my"
                    | "quick"
                    | "simple"
            )
        ) {
            p += 1;
        }
        let ends = matches!(self.tokens.get(p + 1), None | Some(Token::Pause | Token::End));
        if !self.word_at(p).is_some_and(|word| phrases().remark.kinds.has(word)) || !ends {
            return false;
        }
        self.report(self.at..p + 1, UnrecognizedReason::NotExpressible);
        self.at = p + 1;
        true
    }

    /// "handles don't matter".
    fn indifference(&mut self) -> bool {
        if !self.begins() {
            return false;
        }
        for words in 1..=4 {
            if self.word(words - 1).is_none() {
                return false;
            }
            let p = self.at + words;
            if let Some(length) = phrases().remark.indifferent.longest_at(self.tokens, p) {
                self.report(self.at..p + length, UnrecognizedReason::NotExpressible);
                self.at = p + length;
                return true;
            }
        }
        false
    }

    /// "labeled \"nails\"", "that says 'sugar'": writing is no object.
    fn writing(&mut self) -> bool {
        let Some(length) = [
            "labeled as",
            "labelled as",
            "labeled",
            "labelled",
            "with the word",
            "with the words",
            "with the label",
            "with the text",
            "that says",
            "which says",
            "that reads",
            "which reads",
            "saying",
            "reading",
            "titled",
            "named",
            "called",
            "marked",
        ]
        .iter()
        .filter_map(|phrase| match_phrase(self.tokens, self.at, phrase))
        .max() else {
            return false;
        };
        let first = self.at + length;
        let certain = matches!(self.word(0), Some("labeled" | "labelled"));
        let end = match self.source.quotation(first) {
            Some(end) => end,
            None if certain => {
                let phrase = noun_phrase(self.lexicon, self.tokens, first);
                phrase.map_or(first + usize::from(self.word_at(first).is_some()), |(_, end)| end)
            }
            None => return false,
        };
        if self.subject.is_empty() {
            return false;
        }
        self.report(self.at..end, UnrecognizedReason::NotExpressible);
        self.at = end;
        true
    }
}
