//! The noun-phrase chunker: "two small light blue ceramic mugs", "a stack of three books", "a 30 cm
//! wide oak table", "them".
//!
//! A phrase consists of determiners and quantities, then modifiers, then the head (head.rs). Words that are both
//! modifier and noun ("glass", "orange") are modifiers if a noun follows in the same phrase (modifiers.rs).

mod attributes;
mod boundary;
mod compounds;
mod groups;
mod head;
mod modifiers;
mod packages;
mod pronouns;
mod selectors;

use std::ops::Range;

use super::lexicon::{Lexicon, Meaning};
use super::measures::read_measure;
use super::property::Property;
use super::quantity::quantity;
use super::tokens::{Token, word};
pub(super) use attributes::Attributes;
use attributes::Variant;
pub(super) use boundary::is_boundary;
pub(super) use groups::group_of;
use modifiers::{adjective_position, is_attribute, modifier};
pub(super) use modifiers::{color_of, predicate};
use scene::RelationKind;
use scene::text_account::UnrecognizedReason;
pub(super) use selectors::Selector;
use selectors::side_of_rank;

/// The determiner of a phrase.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Determiner {
    /// "a", a number or a bare noun: a new referent.
    New,
    /// "the", "that", "its": possibly an earlier mention.
    Definite,
    /// "each", "every".
    Each,
}

/// The head of a phrase.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Head {
    Objects(Vec<Meaning>),
    /// "it", "this".
    It,
    /// "them".
    Them,
    /// A head that the text leaves out: "a red and a blue mug", "the blue one".
    One,
    /// "all objects", "everything".
    All,
    Unknown(String),
}

/// A word for a group: "a row of".
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Group {
    Row,
    Column,
    Circle,
    Grid,
    Pile,
    Pyramid,
}

/// A property and the tokens that describe it.
pub(super) type PropertySpan = (Property, Range<usize>);

#[derive(Clone, Debug, PartialEq)]
pub(super) struct NounPhrase {
    pub determiner: Determiner,
    /// Minimum and maximum count; `None` if the phrase leaves it open.
    pub count: Option<[u32; 2]>,
    pub plural: bool,
    /// "a stack of".
    pub stacked: bool,
    pub group: Option<(Group, Range<usize>)>,
    /// Columns of "a 2 x 3 grid", "two rows of three".
    pub columns: Option<usize>,
    /// Number of objects of each of several stacks.
    pub stack_size: Option<usize>,
    /// States before the noun ("an upside-down bowl").
    pub states: Vec<(String, Range<usize>)>,
    /// "no mugs".
    pub negated: bool,
    pub selector: Option<Selector>,
    /// The side from which a rank counts ("the second book from the left"), with its words.
    pub counted_from: Option<(RelationKind, Range<usize>)>,
    /// "the same fruit".
    pub same: bool,
    pub attributes: Attributes,
    pub head: Head,
    /// Modifiers and head as written in the text, with the head in the singular where the text has it so.
    pub words: String,
    /// The noun of the text, where the category of the head only stands in for what it names.
    pub stand_in: Option<String>,
    /// All tokens of the phrase.
    pub tokens: Range<usize>,
    pub head_tokens: Range<usize>,
    pub properties: Vec<PropertySpan>,
    /// Numbers and quantities.
    pub counts: Vec<Range<usize>>,
    /// Words of the phrase without an effect.
    pub reports: Vec<(Range<usize>, UnrecognizedReason)>,
}

#[cfg(test)]
thread_local! {
    /// Number of calls of [`noun_phrase`], the most expensive operation of the parser.
    pub(super) static CALLS: std::cell::Cell<usize> = const { std::cell::Cell::new(0) };
}

impl NounPhrase {
    /// A phrase of these tokens without words of its own.
    fn empty(tokens: Range<usize>) -> Self {
        Self {
            determiner: Determiner::New,
            count: None,
            plural: false,
            stacked: false,
            group: None,
            columns: None,
            stack_size: None,
            states: Vec::new(),
            negated: false,
            selector: None,
            counted_from: None,
            same: false,
            attributes: Attributes::plain(),
            head: Head::It,
            words: String::new(),
            stand_in: None,
            head_tokens: tokens.clone(),
            tokens,
            properties: Vec::new(),
            counts: Vec::new(),
            reports: Vec::new(),
        }
    }

    /// The phrase as it is where all of its tokens stand `by` tokens later.
    pub fn shifted(mut self, by: usize) -> Self {
        let shift = |tokens: &mut Range<usize>| *tokens = tokens.start + by..tokens.end + by;
        shift(&mut self.tokens);
        shift(&mut self.head_tokens);
        self.properties.iter_mut().for_each(|(_, tokens)| shift(tokens));
        self.states.iter_mut().for_each(|(_, tokens)| shift(tokens));
        self.counts.iter_mut().for_each(shift);
        self.reports.iter_mut().for_each(|(tokens, _)| shift(tokens));
        if let Some((_, tokens)) = &mut self.group {
            shift(tokens);
        }
        if let Some((_, tokens)) = &mut self.counted_from {
            shift(tokens);
        }
        self
    }

    /// "one" and "two" of "two mugs, one upside down".
    pub fn part(count: [u32; 2], tokens: Range<usize>) -> Self {
        Self { count: Some(count), head: Head::One, ..Self::empty(tokens) }
    }
}

/// Parses the noun phrase at `at`; returns it with the position after it. `None` if no phrase starts here.
pub(super) fn noun_phrase(lexicon: &Lexicon, tokens: &[Token], at: usize) -> Option<(NounPhrase, usize)> {
    #[cfg(test)]
    CALLS.with(|calls| calls.set(calls.get() + 1));
    let phrase = NounPhrase::empty(at..at);
    let mut chunk = Chunk {
        lexicon,
        tokens,
        at,
        phrase,
        words: Vec::new(),
        modifiers: Vec::new(),
        determined: false,
        alone: false,
    };
    let end = chunk.pronoun().or_else(|| {
        chunk.determiners()?;
        if chunk.alone {
            chunk.phrase.head = Head::One;
            return Some(chunk.measured(chunk.at));
        }
        chunk.head()
    })?;
    let side =
        chunk.phrase.selector.filter(|_| !chunk.alone).and_then(|rank| side_of_rank(rank, tokens, end));
    let end = end + side.map_or(0, |(_, length)| length);
    chunk.phrase.counted_from = side.map(|(side, length)| (side, end - length..end));
    chunk.phrase.tokens = at..end;
    // "a red, green and blue cube" is one of each; "a red and white mug" is one mug.
    let colors = chunk.phrase.attributes.colors.len() as u32;
    if chunk.phrase.count == Some([1, 1]) && colors > 2 {
        chunk.phrase.count = Some([colors; 2]);
        chunk.phrase.plural = true;
    }
    if chunk.phrase.head_tokens.is_empty() {
        chunk.phrase.head_tokens = headless(&chunk.phrase, at..end);
    }
    Some((chunk.phrase, end))
}

/// Tokens that name the objects of a phrase without a head: its last word without another meaning ("one" of "the blue
/// one").
fn headless(phrase: &NounPhrase, tokens: Range<usize>) -> Range<usize> {
    if phrase.properties.is_empty() && phrase.counts.is_empty() && phrase.states.is_empty() {
        return tokens;
    }
    let spans = phrase.properties.iter().map(|(_, span)| span);
    let says: Vec<&Range<usize>> =
        spans.chain(&phrase.counts).chain(phrase.states.iter().map(|(_, span)| span)).collect();
    let name = tokens.clone().rev().find(|token| says.iter().all(|span| !span.contains(token)));
    name.map_or(tokens.end..tokens.end, |token| token..token + 1)
}

/// Maximum number of tokens before the head.
const MAX_BEFORE_HEAD: usize = 32;

/// A phrase in progress.
pub(super) struct Chunk<'a, 'c> {
    pub lexicon: &'a Lexicon<'c>,
    pub tokens: &'a [Token],
    pub at: usize,
    pub phrase: NounPhrase,
    pub words: Vec<String>,
    /// Nouns and unknown words before the head; they make another object of it ("a dumbbell rack").
    pub modifiers: Vec<String>,
    pub determined: bool,
    /// Whether a selector stands without a noun ("the other").
    pub alone: bool,
}

impl<'a> Chunk<'a, '_> {
    pub fn word(&self, ahead: usize) -> Option<&'a str> {
        word(self.tokens, self.at + ahead)
    }

    /// A state before a noun; the number of tokens.
    fn state(&mut self) -> Option<usize> {
        let states = &self.lexicon.vocabulary.states;
        let object = self.lexicon.longest_at(self.tokens, self.at);
        // "an open laptop": the whole and the noun alone have one meaning, so that the rest of the words is the state.
        let within = |length: usize| {
            object.is_some_and(|(whole, whole_length)| {
                let noun = self.lexicon.longest_at(self.tokens, self.at + length);
                length <= whole_length
                    && noun.is_none_or(|(noun, _)| noun.meanings.first() != whole.meanings.first())
            })
        };
        let mut phrase = String::new();
        let mut best = None;
        for k in 0..4 {
            let Some(next) = self.word(k) else { break };
            if k > 0 {
                phrase.push(' ');
            }
            phrase.push_str(next);
            if let Some(state) = states.get(&phrase)
                && !within(k + 1)
                && noun_ahead(self.lexicon, self.tokens, self.at + k + 1)
            {
                best = Some((state.clone(), k + 1));
            }
        }
        // "one lying bottle": elsewhere "lying" is a verb.
        if matches!(self.word(0), Some("lying" | "standing"))
            && self.lexicon.longest_at(self.tokens, self.at + 1).is_some()
        {
            let state = if self.word(0) == Some("lying") { "lying_on_side" } else { "upright" };
            best = Some((state.to_owned(), 1));
        }
        let (state, length) = best?;
        self.phrase.states.push((state, self.at..self.at + length));
        Some(length)
    }

    /// Notes the words of a number; "two" and "pairs of" are one.
    fn counted(&mut self, tokens: Range<usize>) {
        match self.phrase.counts.last_mut().filter(|last| last.end == tokens.start) {
            Some(last) => last.end = tokens.end,
            None => self.phrase.counts.push(tokens),
        }
    }

    fn property(&mut self, property: Property, length: usize) {
        self.phrase.properties.push((property, self.at..self.at + length));
    }

    /// Determiners, quantities and modifiers; `None` if the text ends before a head.
    fn determiners(&mut self) -> Option<()> {
        let vocabulary = self.lexicon.vocabulary;
        let start = self.at;
        while self.at < self.tokens.len() {
            // Longer runs of numbers and modifiers are no phrase.
            if self.at - start > MAX_BEFORE_HEAD {
                return None;
            }
            // "the other 20 cm wide".
            if self.alone && read_measure(vocabulary, self.tokens, self.at).is_some() {
                return Some(());
            }
            if self.grid() {
                continue;
            }
            if let Some((reading, length)) = read_measure(vocabulary, self.tokens, self.at)
                && self.lexicon.longest_at(self.tokens, self.at).is_none_or(|(_, n)| n < length)
            {
                // "a height of 12 cm" has no head of its own.
                if matches!(self.tokens.get(self.at + length), None | Some(Token::Pause | Token::End)) {
                    return None;
                }
                let property = self.phrase.attributes.add_reading(reading);
                self.property(property, length);
                self.at += length;
                self.determined = true;
                continue;
            }
            // "both oranges" are the two that there are.
            if self.word(0) == Some("both") {
                self.phrase.determiner = Determiner::Definite;
                let joins = matches!(self.word(1), Some("the" | "a" | "an" | "my"));
                self.phrase.count = Some([2, 2]).filter(|_| !joins);
                self.counted(self.at..self.at + 1);
                self.determined = true;
                self.at += 1 + usize::from(self.word(1) == Some("of"));
                continue;
            }
            if let Some((range, length)) = quantity(self.lexicon, self.tokens, self.at)
                && self.lexicon.longest_at(self.tokens, self.at).is_none_or(|(_, n)| n < length)
                && !(self.determined && self.is_one(self.at))
            {
                self.count(range);
                self.counted(self.at..self.at + length);
                self.at += length;
                continue;
            }
            let Some(w) = self.word(0) else {
                if self.comma_joins() {
                    self.at += 1;
                    continue;
                }
                return self.is_elliptic().then_some(());
            };
            let known = self.lexicon.longest_at(self.tokens, self.at);
            let joint = self.of_length();
            let of = joint > 0;
            match w {
                "no" | "zero" => self.phrase.negated = true,
                "a" | "an" | "another" => {
                    self.phrase.count.get_or_insert([1, 1]);
                    self.determined = true;
                }
                "the" | "this" | "that" | "these" | "those" | "its" | "their" | "his" | "her" | "my"
                | "your" => {
                    // "each of the three cups".
                    if self.phrase.determiner != Determiner::Each {
                        self.phrase.determiner = Determiner::Definite;
                    }
                    self.determined = true;
                }
                "each" | "every" => {
                    self.phrase.determiner = Determiner::Each;
                    self.determined = true;
                    self.at += usize::from(self.word(1) == Some("of"));
                }
                "all" => {
                    self.phrase.determiner = Determiner::Definite;
                    self.determined = true;
                    if of {
                        self.at += 1;
                    }
                }
                "pair" | "pairs" if of => self.pair(),
                _ if of
                    && vocabulary.grammar.piles.contains(w)
                    && known.is_none_or(|(_, length)| length == 1 && self.is_of_many(joint)) =>
                {
                    self.phrase.stacked = true;
                    if matches!(w, "pile" | "piles" | "heap") {
                        self.phrase.group = Some((Group::Pile, self.at..self.at + 1 + joint));
                    }
                    self.phrase.count = self.phrase.count.filter(|count| *count != [1, 1]);
                    if self.phrase.count.is_some() {
                        self.phrase.stack_size = Some(0);
                    }
                    self.determined = true;
                    self.property(Property::Arrangement, 1 + joint);
                    self.at += joint;
                }
                _ if of && group_of(w).is_some() && (known.is_none() || self.is_of_many(joint)) => {
                    let (group, rows) = (group_of(w)?, self.phrase.count);
                    let in_columns = w == "columns";
                    let tokens = self.at..self.at + 1 + joint;
                    self.phrase.group = Some((group, tokens.clone()));
                    self.phrase.count = rows.filter(|rows| group == Group::Row && rows[0] > 1);
                    if self.phrase.count.is_some() {
                        self.phrase.group = Some((Group::Grid, tokens));
                        self.phrase.columns = Some(match rows {
                            Some([columns, _]) if in_columns => columns as usize,
                            _ => 0,
                        });
                    }
                    self.determined = true;
                    self.at += joint;
                }
                _ if known.is_none() && vocabulary.grammar.partitives.contains(w) && of => {
                    // "a set of mugs" leaves the number open, "a slice of bread" is one.
                    if matches!(w, "set" | "sets" | "mix" | "range" | "arrangement") {
                        self.phrase.count = None;
                    }
                    // "some sort of bowl".
                    if matches!(w, "sort" | "kind" | "type")
                        && self.phrase.count.is_some_and(|c| c[0] != c[1])
                    {
                        self.phrase.count = Some([1, 1]);
                    }
                    self.determined = true;
                    self.at += 1;
                }
                "stacked" => {
                    self.phrase.stacked = true;
                    self.property(Property::Arrangement, 1);
                }
                "same" | "identical" | "more" | "additional" | "further" | "extra"
                    if self.determined && starts_noun(self.lexicon, self.tokens, self.at + 1) =>
                {
                    self.phrase.same |= w == "same" && self.phrase.determiner == Determiner::Definite;
                }
                "own" | "alternating" if adjective_position(self.lexicon, self.tokens, self.at + 1) => {}
                "only" | "sole" if self.phrase.determiner == Determiner::Definite => {}
                _ if self.selector() => {}
                _ if vocabulary.grammar.determiners.contains(w) && w != "other" => self.determined = true,
                _ if self.phrase.properties.is_empty() && self.is_noun_alone(w) => return Some(()),
                _ => match modifier(self.lexicon, self.tokens, self.at, &mut self.phrase.attributes) {
                    Some(found) if found.contradicts => {
                        let range = self.at..self.at + found.length;
                        self.phrase.reports.push((range, UnrecognizedReason::Contradiction));
                        self.at += found.length;
                        continue;
                    }
                    Some(found) => {
                        let range = self.at..self.at + found.length;
                        self.words
                            .extend(self.tokens[range].iter().filter_map(Token::word).map(str::to_owned));
                        self.property(found.property, found.length);
                        self.at += found.length;
                        self.determined = true;
                        continue;
                    }
                    None => {
                        let Some(length) = self.state() else { return Some(()) };
                        self.at += length;
                        self.determined = true;
                        continue;
                    }
                },
            }
            self.at += 1;
        }
        // "... and 1 green" at the end of the text.
        self.is_elliptic().then_some(())
    }

    /// Whether the phrase may end without a head: "a black, a white and a red bowl", "the other.".
    fn is_elliptic(&self) -> bool {
        let counted = self.phrase.count.is_some() || self.phrase.determiner != Determiner::New;
        let described = self.phrase.properties.iter().any(|(property, _)| *property != Property::Arrangement);
        counted && described || self.alone
    }

    /// "a small, red mug": another modifier of the same noun follows the comma.
    fn comma_joins(&self) -> bool {
        let follows = self.phrase.properties.last().is_some_and(|(_, range)| range.end == self.at);
        matches!(self.tokens.get(self.at), Some(Token::Pause))
            && follows
            && self.word(1).is_some_and(|next| is_attribute(self.lexicon.vocabulary, next))
            && adjective_position(self.lexicon, self.tokens, self.at + 1)
    }

    /// Whether the word is "one" as a pronoun.
    fn is_one(&self, at: usize) -> bool {
        matches!(word(self.tokens, at), Some("one" | "ones"))
            && word(self.tokens, at + 1).is_none_or(|next| is_boundary(self.lexicon.vocabulary, next))
    }

    fn count(&mut self, range: [u32; 2]) {
        self.phrase.count = Some(match self.phrase.count {
            // "a dozen", "two pairs": the inner number counts.
            Some([1, 1]) | None => range,
            // "two different mugs".
            Some(known) if range[0] != range[1] => known,
            Some([low, high]) => {
                if self.phrase.columns == Some(0) {
                    self.phrase.columns = Some(range[0] as usize);
                }
                if self.phrase.stack_size == Some(0) {
                    self.phrase.stack_size = Some(range[0] as usize);
                }
                [low.saturating_mul(range[0]), high.saturating_mul(range[1])]
            }
        });
        self.determined = true;
    }
}

/// Whether a noun of the lexicon follows within this phrase, after modifiers and adjectives.
pub(super) fn noun_ahead(lexicon: &Lexicon, tokens: &[Token], at: usize) -> bool {
    for p in at..(at + 5).min(tokens.len()) {
        let Some(w) = word(tokens, p) else { return false };
        if lexicon.longest_at(tokens, p).is_some() {
            return true;
        }
        if is_boundary(lexicon.vocabulary, w) || quantity(lexicon, tokens, p).is_some() {
            return false;
        }
    }
    false
}

/// Whether a noun phrase with a known head begins here, after its determiner.
fn starts_noun(lexicon: &Lexicon, tokens: &[Token], at: usize) -> bool {
    noun_ahead(lexicon, tokens, at) || quantity(lexicon, tokens, at).is_some()
}
