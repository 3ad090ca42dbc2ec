//! The head of a noun phrase: the last noun decides. With an unknown head, nothing follows from its modifiers ("watch
//! strap"). With a known head, a noun before it makes another object, for which the category of the head stands in ("a
//! blender jug"), unless the lexicon of nouns knows the compound as a kind of the category ("a dessert plate").

use std::ops::Range;

use super::boundary::is_boundary;
use super::modifiers::modifier;
use super::{Chunk, Determiner, Head, NounPhrase, noun_ahead};
use crate::text_parser::lexicon::{Entry, Meaning};
use crate::text_parser::measures::trailing;
use crate::text_parser::phrases::phrases;
use crate::text_parser::property::Property;
use crate::text_parser::quantity::quantity;
use crate::text_parser::tokens::{Token, word};
use scene::text_account::UnrecognizedReason;

/// Maximum number of words between the determiner and the head.
const MAX_MODIFIERS: usize = 8;

impl Chunk<'_, '_> {
    /// Reads adjectives and nouns; the position after the phrase.
    pub(super) fn head(&mut self) -> Option<usize> {
        self.adjectives()?;
        // "another with 5 cm sides".
        if self.phrase.head == Head::One && word(self.tokens, self.at - 1) == Some("another") {
            return Some(self.measured(self.at));
        }
        if matches!(self.phrase.head, Head::One | Head::All) {
            return Some(self.at);
        }
        if let Some(length) = self.compound_at(self.at) {
            return self.unknown_compound(self.at, self.at + length);
        }
        let Some((entry, length)) = self.lexicon.longest_at(self.tokens, self.at) else {
            return self.unknown(self.at);
        };
        let first = self.at;
        let (mut entry, mut start, mut end) = (entry.clone(), self.at, self.at + length);
        if let Some(found) = self.with_of(&entry, start, end) {
            (entry, end) = found;
        }
        // "laptop charger": an unknown noun after a known one is the head.
        let mut unknown: Option<Range<usize>> = None;
        while !entry.plural || entry.one_by_default || unknown.is_some() {
            let at = unknown.as_ref().map_or(end, |unknown| unknown.end);
            if at - first > MAX_MODIFIERS {
                break;
            }
            if let Some((next, more)) = self.lexicon.longest_at(self.tokens, at)
                && !self.is_vague_list(&entry, next)
            {
                if unknown.is_none() && self.is_package_of(&entry, at, more) {
                    (entry.plural, end) = (next.plural, at + more);
                    break;
                }
                self.words.extend(words_of(self.tokens, start..at));
                let is_toy = word(self.tokens, start) == Some("toy");
                if !matches!(entry.meanings[0], Meaning::Table(_))
                    && !is_toy
                    && entry.meanings[0] != next.meanings[0]
                {
                    self.modifiers
                        .extend(words_of(self.tokens, start..unknown.as_ref().map_or(at, |u| u.start)));
                }
                if let Some(unknown) = unknown.take() {
                    self.modifiers.extend(words_of(self.tokens, unknown.clone()));
                    self.phrase.reports.push((unknown, UnrecognizedReason::UnknownWord));
                }
                (entry, start, end) = (next.clone(), at, at + more);
                if let Some(found) = self.with_of(&entry, start, end) {
                    (entry, end) = found;
                }
                continue;
            }
            match word(self.tokens, at) {
                Some(w) if unknown.is_none() && self.is_roll_of(&entry, w) => {
                    (entry.plural, end) = (w == "rolls", at + 1);
                    break;
                }
                Some(w) if self.continues_compound(&entry, w, at) => {
                    let from = unknown.map_or(at, |unknown| unknown.start);
                    unknown = Some(from..at + 1);
                }
                _ => break,
            }
        }
        if let Some(unknown) = unknown {
            // "an office desk setup" is the desk.
            let scene_word = words_of(self.tokens, unknown.clone())
                .all(|w| self.lexicon.vocabulary.grammar.scene_words.contains(&w));
            if !(scene_word && matches!(entry.meanings[0], Meaning::Table(_))) {
                return self.unknown_compound(first, unknown.end);
            }
            self.phrase.head = Head::Objects(entry.meanings);
            self.phrase.head_tokens = start..unknown.end;
            return Some(unknown.end);
        }
        let end = self.more_contents(start, end);
        Some(self.known(entry, start, end))
    }

    /// A vague set or a category after a vague word in a list ("toys books") is another phrase.
    fn is_vague_list(&self, entry: &Entry, next: &Entry) -> bool {
        matches!(entry.meanings[0], Meaning::Table(_)) && matches!(next.meanings[0], Meaning::Vague(_))
    }

    /// Whether the word after a known noun makes it a modifier of an unknown noun.
    fn continues_compound(&self, entry: &Entry, w: &str, at: usize) -> bool {
        let vocabulary = self.lexicon.vocabulary;
        let grammar = &vocabulary.grammar;
        if grammar.compound_heads.contains(w) {
            return true;
        }
        // "the egg falls into the bowl".
        let falls =
            phrases().list.falls.has(w) && phrases().path.directed.longest_at(self.tokens, at + 1).is_some();
        if falls {
            return false;
        }
        if self.is_noun_here(entry, w, at) {
            return true;
        }
        let table_word = matches!(entry.meanings[0], Meaning::Table(_)) && grammar.scene_words.contains(w);
        if table_word {
            return true;
        }
        if is_boundary(vocabulary, w) || grammar.after_noun.contains(w) || vocabulary.numbers.contains_key(w)
        {
            return false;
        }
        if grammar.parts.contains(w) {
            return !matches!(entry.meanings[0], Meaning::Table(_)) || !grammar.scene_words.contains(w);
        }
        // "the lamp illuminates the desk": a verb.
        let verb = word(self.tokens, at + 1).is_some_and(|next| {
            vocabulary.grammar.determiners.contains(next) || next == "it" || next == "them"
        });
        !vocabulary.is_ordinary(w) && !verb
    }

    /// Ordinary and unknown adjectives before a noun of this phrase. `None` if no phrase begins here.
    fn adjectives(&mut self) -> Option<()> {
        let mut skipped = 0;
        while self.lexicon.longest_at(self.tokens, self.at).is_none() {
            let vocabulary = self.lexicon.vocabulary;
            if matches!(self.word(0), Some("one" | "ones")) && self.determined {
                self.at += 1;
                self.phrase.head = Head::One;
                return Some(());
            }
            if self.word(0).is_some_and(|w| self.is_noun_alone(w))
                && !noun_ahead(self.lexicon, self.tokens, self.at + 1)
            {
                return Some(());
            }
            let described = !self.phrase.properties.is_empty() && self.determined;
            let Some(w) = self.word(0).filter(|w| !is_boundary(vocabulary, w)) else {
                // "a red and a blue mug".
                let joins = matches!(self.word(0), Some("and" | "or")) || self.word(0).is_none();
                let elliptic =
                    self.phrase.properties.iter().any(|(property, _)| *property != Property::Arrangement);
                let selected = self.phrase.selector.is_some() && self.determined
                    || self.at > 0 && word(self.tokens, self.at - 1) == Some("another");
                if described && elliptic && joins || selected {
                    self.phrase.head = Head::One;
                    return Some(());
                }
                // "the left and the right mug" and "all".
                return None;
            };
            let ordinary = vocabulary.is_ordinary(w);
            let noun_follows = noun_ahead(self.lexicon, self.tokens, self.at + 1);
            if self.compound_at(self.at).is_some() {
                return Some(());
            }
            if vocabulary.grammar.parts.contains(w) && !noun_follows {
                return self.all_objects();
            }
            if ordinary && !noun_follows {
                return None;
            }
            if !ordinary && !noun_follows {
                return Some(());
            }
            if let Some(found) = modifier(self.lexicon, self.tokens, self.at, &mut self.phrase.attributes) {
                let range = self.at..self.at + found.length;
                self.words.extend(words_of(self.tokens, range.clone()));
                self.phrase.properties.push((found.property, range));
                self.at += found.length;
                continue;
            }
            if let Some((range, length)) = quantity(self.lexicon, self.tokens, self.at) {
                self.phrase.count = Some(range);
                self.counted(self.at..self.at + length);
                self.at += length;
                continue;
            }
            let grammar = &vocabulary.grammar;
            // "a messy office desk": words of the theme and of its completion.
            let of_theme = grammar.openers.contains(w)
                || grammar.closers.contains(w)
                || self.lexicon.themes.has_word(w)
                || grammar.scene_words.contains(w);
            // What the parser reports is no part of the label.
            if of_theme || !ordinary {
                self.words.push(w.to_owned());
            }
            if !of_theme {
                let reason =
                    if ordinary { UnrecognizedReason::NotSupported } else { UnrecognizedReason::UnknownWord };
                if !ordinary {
                    self.modifiers.push(w.to_owned());
                }
                self.phrase.reports.push((self.at..self.at + 1, reason));
            }
            self.at += 1;
            skipped += 1;
            if skipped > MAX_MODIFIERS {
                return None;
            }
        }
        Some(())
    }

    /// "the objects" are all objects; "a person" and "six objects" have no object of their own.
    fn all_objects(&mut self) -> Option<()> {
        let all = matches!(self.word(0)?, "objects" | "items" | "things" | "stuff");
        if !all || self.phrase.determiner != Determiner::Definite || self.phrase.count.is_some() {
            return None;
        }
        self.at += 1;
        self.phrase.head = Head::All;
        Some(())
    }

    fn known(&mut self, entry: Entry, start: usize, end: usize) -> usize {
        self.phrase.stand_in = self.stood_in_for(&entry, start, end);
        let phrase = &mut self.phrase;
        self.words.extend(words_of(self.tokens, start..end));
        phrase.plural = entry.plural || (entry.one_by_default && phrase.count.is_some_and(|c| c[1] > 1));
        if phrase.count == Some([1, 1]) && entry.plural && !self.determined {
            phrase.count = None;
        }
        // "some bread", "some coffee": one of it.
        if entry.one_by_default && !entry.plural && phrase.count.is_some_and(|c| c[0] != c[1]) {
            phrase.count = Some([1, 1]);
            phrase.plural = false;
        }
        phrase.head = Head::Objects(entry.meanings);
        phrase.head_tokens = start..end;
        phrase.words = self.words.join(" ");
        let end = self.trailing_count(end);
        let (readings, after) = trailing(self.lexicon.vocabulary, self.tokens, end);
        for (reading, range) in readings {
            let property = self.phrase.attributes.add_reading(reading);
            self.phrase.properties.push((property, range));
        }
        after.max(end)
    }

    /// "mug x3", "mugs (3)", "mug: 3".
    fn trailing_count(&mut self, end: usize) -> usize {
        let number = |at: usize| match self.tokens.get(at) {
            Some(Token::Number(number)) if number.fract() == 0.0 && *number >= 1.0 => Some(*number as u32),
            _ => None,
        };
        let (count, after) = match (word(self.tokens, end), self.tokens.get(end)) {
            (Some("x"), _) => (number(end + 1), end + 2),
            (None, Some(Token::Pause)) => {
                let closes = matches!(self.tokens.get(end + 2), None | Some(Token::Pause | Token::End));
                (number(end + 1).filter(|_| closes), end + 2)
            }
            _ => (None, end),
        };
        match (count, self.phrase.count) {
            (Some(count), None | Some([1, 1])) => {
                self.phrase.count = Some([count; 2]);
                self.counted(end..after);
                self.phrase.plural |= count > 1;
                after
            }
            _ => end,
        }
    }

    /// A compound with an unknown head: the words from its first noun on.
    fn unknown_compound(&mut self, start: usize, end: usize) -> Option<usize> {
        self.phrase.head = Head::Unknown(words_of(self.tokens, start..end).collect::<Vec<_>>().join(" "));
        self.phrase.head_tokens = start..end;
        self.words.extend(words_of(self.tokens, start..end));
        self.phrase.words = self.words.join(" ");
        Some(self.measured(end))
    }

    pub(super) fn measured(&mut self, end: usize) -> usize {
        let end = self.trailing_count(end);
        let (readings, after) = trailing(self.lexicon.vocabulary, self.tokens, end);
        for (reading, range) in readings {
            let property = self.phrase.attributes.add_reading(reading);
            self.phrase.properties.push((property, range));
        }
        after.max(end)
    }

    /// Consecutive unknown words.
    fn unknown(&mut self, at: usize) -> Option<usize> {
        let vocabulary = self.lexicon.vocabulary;
        let mut end = at;
        while let Some(w) = word(self.tokens, end) {
            let part = vocabulary.grammar.parts.contains(w) && end > at;
            let ordinary = vocabulary.is_ordinary(w) && !part;
            let verb = end > at
                && word(self.tokens, end + 1)
                    .is_some_and(|next| vocabulary.grammar.determiners.contains(next));
            if ordinary || verb || is_boundary(vocabulary, w) || end - at == 4 {
                break;
            }
            end += 1;
        }
        self.unknown_compound(at, end.max(at + 1))
    }
}

pub(super) fn words_of(tokens: &[Token], range: Range<usize>) -> impl Iterator<Item = String> {
    tokens[range].iter().filter_map(Token::word).map(str::to_owned)
}

impl NounPhrase {
    /// Whether the phrase names the table.
    pub fn is_table(&self) -> bool {
        matches!(&self.head, Head::Objects(meanings) if matches!(meanings[0], Meaning::Table(_)))
    }
}
