//! Objects and particles of instructions.

use super::{Parser, Referent};
use crate::text_parser::phrase::{Determiner, Head, NounPhrase, noun_phrase};
use crate::text_parser::tokens::{Token, match_phrase};
use crate::text_parser::verbs::{Frame, verbs};

use super::action::{Action, Part, PathKind};

/// Whether the noun is a part that moves with its object or that is pressed.
fn is_part(word: &str) -> bool {
    matches!(
        word,
        "door"
            | "lid"
            | "drawer"
            | "button"
            | "handle"
            | "cap"
            | "switch"
            | "lever"
            | "cover"
            | "doors"
            | "drawers"
            | "knobs"
            | "knob"
    )
}

impl Parser<'_, '_> {
    /// A particle after the object: "pick the mug up", "turn it over", "turn the lamp on".
    pub(super) fn particle(&mut self, action: &mut Action) -> bool {
        let Some(word) = self.word(0) else { return false };
        if !matches!(
            word,
            "up" | "down"
                | "over"
                | "out"
                | "away"
                | "off"
                | "on"
                | "back"
                | "together"
                | "apart"
                | "around"
                | "open"
                | "closed"
                | "shut"
        ) {
            return false;
        }
        let verb = self.word_at(action.verb.start).unwrap_or_default().to_owned();
        if !action.objects.is_empty()
            && let Some(frame) = verbs().with_particle(&verb, word)
        {
            action.frame = frame;
        } else if matches!(word, "open") && !action.objects.is_empty() {
            action.frame = Frame::Open;
        } else if matches!(word, "closed" | "shut") && !action.objects.is_empty() {
            action.frame = Frame::Close;
        } else if matches!(word, "on") || action.objects.is_empty() && matches!(word, "open" | "closed") {
            return false;
        }
        action.particles.push(self.at..self.at + 1);
        self.parsed.account.used(self.at..self.at + 1);
        self.at += 1;
        true
    }

    /// A noun phrase: an object, or the second object of "swap A and B", "hand me the mug".
    pub(super) fn object(&mut self, action: &mut Action) -> bool {
        if matches!(self.word(0), Some("me" | "us")) {
            self.parsed.account.used(self.at..self.at + 1);
            self.at += 1;
            return true;
        }
        // "the positions of the apple and the orange", "the contents of the cup".
        let of = [
            "the positions of",
            "the places of",
            "the position of",
            "the contents of",
            "the content of",
            "positions of",
        ]
        .iter()
        .find_map(|phrase| match_phrase(self.tokens, self.at, phrase));
        if let Some(length) = of {
            self.parsed.account.used(self.at..self.at + length);
            self.at += length;
        }
        let found = self.whole_of_part(self.at).or_else(|| noun_phrase(self.lexicon, self.tokens, self.at));
        let Some((phrase, end)) = found else { return of.is_some() };
        if phrase.negated {
            return false;
        }
        if matches!(action.frame, Frame::Pour | Frame::Fill)
            && self.is_substance(&phrase)
            && self.source_ahead(end)
        {
            self.parsed.account.used(phrase.tokens);
            self.at = end;
            action.substance = true;
            return true;
        }
        self.at = end;
        // Objects of an earlier sentence are meant by "one of the mugs" and "a mug" after "three mugs".
        let take = phrase.count.filter(|count| count[0] == count[1]).map(|count| count[0]);
        let before = self.parsed.mentions.len();
        let referent = match self.part_of_earlier(&phrase) {
            Some(mention) => {
                self.parsed.account.used(phrase.tokens.clone());
                self.parsed
                    .account
                    .claim(phrase.head_tokens.clone(), crate::text_parser::account::Claimed::Object(mention));
                Referent::Mentions(vec![mention])
            }
            None => self.refer(phrase, false),
        };
        match referent {
            Referent::Mentions(list) => {
                let take = take.filter(|_| list.iter().all(|&mention| mention < before));
                action.objects.extend(list.iter().map(|&mention| Part { mention, take }));
                if let [.., last] = list[..] {
                    self.salient = Some(last);
                    self.salient_list = action.objects.iter().map(|part| part.mention).collect();
                    if self.word(0) == Some("of") {
                        self.contents_of(last);
                    }
                }
            }
            Referent::Table => action.paths.push(self.path(PathKind::Table, end..end)),
            Referent::Nothing => action.unknown = true,
        }
        true
    }

    /// An earlier plural mention of which the phrase takes some.
    pub(super) fn part_of_earlier(&self, phrase: &NounPhrase) -> Option<usize> {
        let Head::Objects(meanings) = &phrase.head else { return None };
        let [low, high] = phrase.count?;
        if phrase.determiner != Determiner::New || low != high {
            return None;
        }
        let color = &phrase.attributes.color_words;
        self.parsed.mentions.iter().rposition(|mention| {
            mention.meanings.iter().any(|meaning| meanings.contains(meaning))
                && mention.count.is_some_and(|count| count[0] > low)
                && (color.is_empty() || *color == mention.attributes.color_words)
        })
    }

    /// Whether the phrase names a substance.
    pub(super) fn is_substance(&self, phrase: &NounPhrase) -> bool {
        let words = &self.lexicon.vocabulary;
        let name = phrase.words.rsplit(' ').next().unwrap_or_default();
        words.grammar.substances.contains(name)
            || words.drinks.values().flatten().any(|drink| *drink == phrase.words)
            || matches!(name, "beans" | "contents" | "content")
    }

    /// Whether a source follows in this sentence.
    pub(super) fn source_ahead(&self, from: usize) -> bool {
        (from..self.tokens.len())
            .take(12)
            .take_while(|&p| !matches!(self.tokens[p], Token::End))
            .any(|p| matches!(self.word_at(p), Some("from" | "out")))
    }

    /// "the lid of the toolbox", "the microwave door": the object with that part, and the position after it.
    pub(super) fn whole_of_part(&self, at: usize) -> Option<(NounPhrase, usize)> {
        let mut p = at;
        while matches!(
            self.word_at(p),
            Some("the" | "its" | "top" | "bottom" | "upper" | "lower" | "middle" | "left" | "right")
        ) {
            p += 1;
        }
        if self.word_at(p).is_some_and(is_part) && self.word_at(p + 1) == Some("of") {
            let (mut phrase, end) = noun_phrase(self.lexicon, self.tokens, p + 2)?;
            phrase.tokens.start = at;
            return matches!(phrase.head, Head::Objects(_)).then_some((phrase, end));
        }
        let (mut phrase, end) = noun_phrase(self.lexicon, self.tokens, at)?;
        let Head::Unknown(_) = phrase.head else { return None };
        let range = phrase.head_tokens.clone();
        let last = range.end.checked_sub(1)?;
        let (entry, length) = self.lexicon.longest_at(self.tokens, range.start)?;
        if !self.word_at(last).is_some_and(is_part) || range.start + length != last {
            return None;
        }
        phrase.head = Head::Objects(entry.meanings.clone());
        phrase.words =
            self.tokens[range.start..last].iter().filter_map(Token::word).collect::<Vec<_>>().join(" ");
        Some((phrase, end))
    }

    /// "clockwise", "by 90 degrees", "by a quarter turn" after "rotate".
    pub(super) fn turn(&mut self, action: &Action) -> bool {
        if action.frame != Frame::Rotate || action.objects.is_empty() {
            return false;
        }
        let is_angle = match &self.tokens[self.at] {
            Token::Number(_) => true,
            Token::Word(word) => {
                matches!(
                    word.as_str(),
                    "by" | "clockwise"
                        | "counterclockwise"
                        | "anticlockwise"
                        | "counter"
                        | "degrees"
                        | "degree"
                        | "quarter"
                        | "half"
                        | "full"
                        | "turn"
                        | "turns"
                        | "about"
                        | "through"
                ) || word == "a" && matches!(self.word(1), Some("quarter" | "half" | "full"))
                    || self.lexicon.vocabulary.numbers.contains_key(word)
            }
            _ => false,
        };
        if is_angle {
            self.parsed.account.used(self.at..self.at + 1);
            self.at += 1;
        }
        is_angle
    }
}
