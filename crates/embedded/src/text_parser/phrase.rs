//! The noun-phrase chunker: "two small light blue ceramic mugs", "a stack of three books", "a 30 cm
//! wide oak table", "them".
//!
//! A phrase consists of determiners and quantities, then modifiers, then the head (head.rs). Words that are both
//! modifier and noun ("glass", "orange") are modifiers if a noun follows in the same phrase (modifiers.rs).

mod boundary;
mod head;
mod modifiers;

use std::ops::Range;

use super::lexicon::{Lexicon, Meaning};
use super::measures::{Measure, read_measure};
use super::quantity::quantity;
use super::tokens::{Token, match_phrase, word};
pub(super) use boundary::is_boundary;
use geometry::Rgb;
use modifiers::modifier;
pub(super) use modifiers::{color_of, predicate};
use scene::RelationKind;
use scene::text_account::UnrecognizedReason;

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

/// What selects among several objects of a category, beside their attributes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Selector {
    Side(RelationKind),
    /// "the second mug".
    Ordinal(usize),
    /// "the other mug".
    Other,
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
pub(super) type PropertySpan = (&'static str, Range<usize>);

/// Attributes given by the modifiers of a phrase.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Attributes {
    /// Two or more for "red and blue mugs".
    pub colors: Vec<Rgb>,
    pub color_words: Vec<String>,
    pub substance: Option<String>,
    /// Color implied by the material.
    pub material_color: Option<Rgb>,
    pub table_finish: Option<String>,
    /// Factor on all extents.
    pub scale: f64,
    /// Factors on single extents (axis letter, factor).
    pub stretches: Vec<(char, f64)>,
    pub measures: Vec<Measure>,
    pub volume_m3: Option<f64>,
    pub mass_kg: Option<f64>,
    /// A key of `[shapes]`.
    pub shape: Option<String>,
}

impl Attributes {
    pub fn plain() -> Self {
        Self { scale: 1.0, ..Self::default() }
    }
}

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
    pub attributes: Attributes,
    pub head: Head,
    /// Modifiers and head as written in the text, with the head in the singular where the text has it so.
    pub words: String,
    /// All tokens of the phrase.
    pub tokens: Range<usize>,
    pub head_tokens: Range<usize>,
    pub properties: Vec<PropertySpan>,
    /// Words of the phrase without an effect.
    pub reports: Vec<(Range<usize>, UnrecognizedReason)>,
}

#[cfg(test)]
thread_local! {
    /// Number of calls of [`noun_phrase`], the most expensive operation of the parser.
    pub(super) static CALLS: std::cell::Cell<usize> = const { std::cell::Cell::new(0) };
}

/// Parses the noun phrase at `at`; returns it with the position after it. `None` if no phrase starts here.
pub(super) fn noun_phrase(lexicon: &Lexicon, tokens: &[Token], at: usize) -> Option<(NounPhrase, usize)> {
    #[cfg(test)]
    CALLS.with(|calls| calls.set(calls.get() + 1));
    let phrase = NounPhrase {
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
        attributes: Attributes::plain(),
        head: Head::It,
        words: String::new(),
        tokens: at..at,
        head_tokens: at..at,
        properties: Vec::new(),
        reports: Vec::new(),
    };
    let mut chunk = Chunk { lexicon, tokens, at, phrase, words: Vec::new(), determined: false };
    let end = chunk.pronoun().or_else(|| {
        chunk.determiners()?;
        chunk.head()
    })?;
    chunk.phrase.tokens = at..end;
    if chunk.phrase.head_tokens.is_empty() {
        chunk.phrase.head_tokens = at..end;
    }
    Some((chunk.phrase, end))
}

/// A phrase in progress.
pub(super) struct Chunk<'a, 'c> {
    pub lexicon: &'a Lexicon<'c>,
    pub tokens: &'a [Token],
    pub at: usize,
    pub phrase: NounPhrase,
    pub words: Vec<String>,
    pub determined: bool,
}

impl<'a> Chunk<'a, '_> {
    pub fn word(&self, ahead: usize) -> Option<&'a str> {
        word(self.tokens, self.at + ahead)
    }

    /// A pronoun; the position after it.
    fn pronoun(&mut self) -> Option<usize> {
        let p = self.at;
        let noun = starts_noun(self.lexicon, self.tokens, p + 1);
        // "one of them".
        if let Some((range, length)) = quantity(self.lexicon, self.tokens, p)
            && self.word(length - 1) == Some("of")
            && matches!(self.word(length), Some("them" | "these" | "those" | "which"))
        {
            self.phrase.count = Some(range);
            self.phrase.head = Head::One;
            return Some(p + length + 1);
        }
        let determiner_follows = self.word(1).is_some_and(|next| {
            matches!(
                next,
                "the" | "a" | "an" | "my" | "on" | "in" | "inside" | "under" | "at" | "to" | "of" | "with"
            )
        });
        match self.word(0)? {
            "it" | "this" | "that" | "itself" if !noun => Some(p + 1),
            "each" | "every"
                if !noun
                    && !matches!(self.word(1), Some("one" | "person" | "guest" | "place" | "corner")) =>
            {
                self.phrase.determiner = Determiner::Each;
                let of = self.word(1) == Some("of") && matches!(self.word(2), Some("them" | "these"));
                Some(if of { p + 3 } else { p + 1 })
            }
            "each" | "every" if self.word(1) == Some("one") => {
                self.phrase.determiner = Determiner::Each;
                Some(p + 2)
            }
            "both" if determiner_follows && self.word(1) != Some("of") => None,
            "them" | "these" | "those" | "both" | "they" if !noun => {
                self.phrase.head = Head::Them;
                let of = self.word(1) == Some("of") && matches!(self.word(2), Some("them" | "these"));
                Some(if of { p + 3 } else { p + 1 })
            }
            "all" if self.word(1) == Some("of") && matches!(self.word(2), Some("them" | "these")) => {
                self.phrase.head = Head::Them;
                Some(p + 3)
            }
            "latter" | "former" if p > 0 => Some(p + 1),
            "the"
                if matches!(self.word(1), Some("latter" | "former" | "same")) && self.phrase_ends(p + 2) =>
            {
                Some(p + 2)
            }
            "everything" => {
                self.phrase.head = Head::All;
                let on_table = self.word(1) == Some("on")
                    && self.word(2) == Some("the")
                    && matches!(self.word(3), Some("table" | "desk"));
                Some(if on_table { p + 4 } else { p + 1 })
            }
            _ => None,
        }
    }

    /// Whether no noun follows.
    fn phrase_ends(&self, at: usize) -> bool {
        !noun_ahead(self.lexicon, self.tokens, at)
    }

    /// A state before a noun; the number of tokens.
    fn state(&mut self) -> Option<usize> {
        let states = &self.lexicon.vocabulary.states;
        let object = self.lexicon.longest_at(self.tokens, self.at).map_or(0, |(_, length)| length);
        let mut phrase = String::new();
        let mut best = None;
        for k in 0..4 {
            let Some(next) = self.word(k) else { break };
            if k > 0 {
                phrase.push(' ');
            }
            phrase.push_str(next);
            if let Some(state) = states.get(&phrase)
                && k + 1 > object
                && noun_ahead(self.lexicon, self.tokens, self.at + k + 1)
            {
                best = Some((state.clone(), k + 1));
            }
        }
        let (state, length) = best?;
        self.phrase.states.push((state, self.at..self.at + length));
        Some(length)
    }

    fn property(&mut self, property: &'static str, length: usize) {
        self.phrase.properties.push((property, self.at..self.at + length));
    }

    /// Determiners, quantities and modifiers; `None` if the text ends before a head.
    fn determiners(&mut self) -> Option<()> {
        let vocabulary = self.lexicon.vocabulary;
        while self.at < self.tokens.len() {
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
                self.determined = true;
                self.at += 1 + usize::from(self.word(1) == Some("of"));
                continue;
            }
            if let Some((range, length)) = quantity(self.lexicon, self.tokens, self.at)
                && self.lexicon.longest_at(self.tokens, self.at).is_none_or(|(_, n)| n < length)
                && !(self.phrase.determiner == Determiner::Definite && self.is_one(self.at))
            {
                self.count(range);
                self.at += length;
                continue;
            }
            let w = self.word(0)?;
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
                    self.phrase.determiner = Determiner::Definite;
                    self.determined = true;
                }
                "each" | "every" => {
                    self.phrase.determiner = Determiner::Each;
                    self.determined = true;
                }
                "all" => {
                    self.phrase.determiner = Determiner::Definite;
                    self.determined = true;
                    if of {
                        self.at += 1;
                    }
                }
                "pair" | "pairs" if of => self.pair(),
                _ if known.is_none() && vocabulary.grammar.piles.contains(w) && of => {
                    self.phrase.stacked = true;
                    if matches!(w, "pile" | "piles" | "heap") {
                        self.phrase.group = Some((Group::Pile, self.at..self.at + 2));
                    }
                    self.phrase.count = self.phrase.count.filter(|count| *count != [1, 1]);
                    if self.phrase.count.is_some() {
                        self.phrase.stack_size = Some(0);
                    }
                    self.determined = true;
                    self.property("arrangement", 1 + joint);
                    self.at += joint;
                }
                _ if known.is_none() && of && group_of(w).is_some() => {
                    let (group, rows) = (group_of(w)?, self.phrase.count);
                    let in_columns = w == "columns";
                    self.phrase.group = Some((group, self.at..self.at + 2));
                    self.phrase.count = rows.filter(|rows| group == Group::Row && rows[0] > 1);
                    if self.phrase.count.is_some() {
                        self.phrase.group = Some((Group::Grid, self.at..self.at + 2));
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
                    self.determined = true;
                    self.at += 1;
                }
                "stacked" => {
                    self.phrase.stacked = true;
                    self.property("arrangement", 1);
                }
                "same" | "identical" | "more" | "additional" | "further" | "extra"
                    if self.determined && starts_noun(self.lexicon, self.tokens, self.at + 1) => {}
                _ if self.selector() => {}
                _ if vocabulary.grammar.determiners.contains(w) && w != "other" => self.determined = true,
                _ => match modifier(self.lexicon, self.tokens, self.at, &mut self.phrase.attributes) {
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
        None
    }

    /// Number of tokens of "of", "made of", "consisting of" after the current word.
    fn of_length(&self) -> usize {
        ["of", "made of", "made up of", "made from", "built of", "built from", "consisting of", "composed of"]
            .iter()
            .filter_map(|phrase| match_phrase(self.tokens, self.at + 1, phrase))
            .max()
            .unwrap_or(0)
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

    fn pair(&mut self) {
        let (_, two) = self.phrase.count.map_or((1, 1), |[low, high]| (low, high));
        // "a pair of scissors" is one; two of anything else.
        let next = self.lexicon.longest_at(self.tokens, self.at + 2);
        let single = next.is_some_and(|(entry, _)| entry.one_by_default);
        let each = if single { 1 } else { 2 };
        self.phrase.count = Some([two.saturating_mul(each); 2]);
        self.determined = true;
        self.at += 1;
    }

    /// "a 2 x 3 grid of": rows by columns.
    fn grid(&mut self) -> bool {
        let numbers = [self.at, self.at + 2].map(|p| match self.tokens.get(p) {
            Some(Token::Number(number)) => Some(number.clamp(0.0, 64.0) as u32),
            _ => word(self.tokens, p).and_then(|w| self.lexicon.vocabulary.numbers.get(w)).copied(),
        });
        let [Some(rows), Some(columns)] = numbers else { return false };
        let joined = matches!(self.word(1), Some("x" | "by"));
        if !joined
            || !matches!(self.word(3), Some("grid" | "array"))
            || self.word(4) != Some("of")
            || rows * columns == 0
        {
            return false;
        }
        self.phrase.group = Some((Group::Grid, self.at..self.at + 5));
        self.phrase.columns = Some(columns as usize);
        self.phrase.count = Some([rows * columns; 2]);
        self.determined = true;
        self.at += 5;
        true
    }

    /// "the left mug", "the second mug", "the other mug".
    fn selector(&mut self) -> bool {
        let Some(w) = self.word(0) else { return false };
        if self.phrase.determiner != Determiner::Definite
            || !starts_noun(self.lexicon, self.tokens, self.at + 1) && !self.is_one(self.at + 1)
        {
            return false;
        }
        let selector = match w {
            "left" | "leftmost" => Selector::Side(RelationKind::AtLeft),
            "right" | "rightmost" => Selector::Side(RelationKind::AtRight),
            "front" => Selector::Side(RelationKind::AtFront),
            "back" | "rear" => Selector::Side(RelationKind::AtBack),
            "middle" | "center" | "central" => Selector::Side(RelationKind::AtCenter),
            "first" => Selector::Ordinal(0),
            "second" => Selector::Ordinal(1),
            "third" => Selector::Ordinal(2),
            "fourth" => Selector::Ordinal(3),
            "other" | "remaining" => Selector::Other,
            _ => return false,
        };
        self.phrase.selector = Some(selector);
        true
    }
}

fn group_of(word: &str) -> Option<Group> {
    Some(match word {
        "row" | "rows" | "line" | "lines" => Group::Row,
        "column" => Group::Column,
        // "two columns of three" are two objects wide.
        "columns" => Group::Row,
        "circle" | "ring" | "semicircle" => Group::Circle,
        "grid" | "array" | "square" => Group::Grid,
        "heap" => Group::Pile,
        "pyramid" => Group::Pyramid,
        _ => return None,
    })
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
