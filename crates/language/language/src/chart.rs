//! Every reading of every part of a text, each computed once.
//!
//! A part has a cost: 0 where it is what such words mostly mean, more where it is unusual. Readings of a whole text are
//! compared by the sum of the costs of their parts.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::ops::Range;
use std::rc::Rc;

use crate::lexicon::lexicon;
use crate::nominal::NounPhrase;
use crate::place::Place;
use crate::repair::repaired;
use crate::tokens::{Token, tokens};

/// A reading of the tokens from some index to `end`.
#[derive(Clone, Debug, PartialEq)]
pub struct Span<T> {
    pub end: usize,
    pub cost: f64,
    pub value: T,
}

/// Objects that phrases may mean.
pub trait Referents {
    /// Whether words are a noun for objects, in the singular or the plural.
    fn is_noun(&self, words: &str) -> bool;

    /// Whether a definite phrase means objects of the scene; `None` where there is no scene.
    fn resolves(&self, phrase: &str) -> Option<bool>;
}

/// Nouns of English and of the catalog, without a scene.
#[derive(Clone, Copy, Debug)]
pub struct EnglishNouns;

impl Referents for EnglishNouns {
    fn is_noun(&self, words: &str) -> bool {
        crate::nouns::is_noun(words)
    }

    fn resolves(&self, _phrase: &str) -> Option<bool> {
        None
    }
}

type Memo<T> = RefCell<BTreeMap<usize, Rc<Vec<Span<T>>>>>;

/// The parts of one text.
pub(crate) struct Chart<'a> {
    pub text: &'a str,
    /// As they are meant: without what the text takes back.
    pub tokens: Vec<Token>,
    /// Bytes that the text takes back.
    retracted: Vec<Range<usize>>,
    pub referents: &'a dyn Referents,
    phrases: Memo<NounPhrase>,
    lists: Memo<Vec<NounPhrase>>,
    places: Memo<Place>,
    resolved: RefCell<BTreeMap<(usize, usize), Option<bool>>>,
}

impl<'a> Chart<'a> {
    pub fn new(text: &'a str, referents: &'a dyn Referents) -> Self {
        let (tokens, repairs) = repaired(text, tokens(text));
        Self {
            text,
            tokens,
            retracted: repairs.into_iter().map(|repair| repair.retracted).collect(),
            referents,
            phrases: Memo::default(),
            lists: Memo::default(),
            places: Memo::default(),
            resolved: RefCell::default(),
        }
    }

    /// The word at an index; empty beyond the end and where it is quoted.
    pub fn word(&self, at: usize) -> &str {
        self.tokens.get(at).filter(|token| !token.is_quoted).map_or("", |token| token.word.as_str())
    }

    /// The words of a range in lower case.
    pub fn words(&self, range: Range<usize>) -> String {
        let words: Vec<&str> = self.tokens[range].iter().map(|token| token.word.as_str()).collect();
        words.join(" ").replace(" 's", "'s")
    }

    /// A range as written, without what is taken back.
    pub fn written(&self, range: Range<usize>) -> String {
        let bytes = self.bytes(&range);
        if !self.retracted.iter().any(|gone| gone.start < bytes.end && bytes.start < gone.end) {
            return self.text[bytes].to_owned();
        }
        let mut written = String::new();
        let mut end = None;
        for token in &self.tokens[range] {
            if end.is_some_and(|end| end != token.span.start) && token.word != "," {
                written.push(' ');
            }
            written.push_str(&self.text[token.span.clone()]);
            end = Some(token.span.end);
        }
        written
    }

    /// The part of the text that has a range, with what is taken back within it.
    pub fn quoted(&self, range: Range<usize>) -> String {
        self.text[self.bytes(&range)].to_owned()
    }

    /// Bytes of a range, from the first to the last. A correction puts a word before those that it follows in the text.
    pub fn bytes(&self, range: &Range<usize>) -> Range<usize> {
        let tokens = self.tokens.get(range.clone()).unwrap_or_default();
        let start = tokens.iter().map(|token| token.span.start).min().unwrap_or(self.text.len());
        let end = tokens.iter().map(|token| token.span.end).max();
        start..end.unwrap_or(start)
    }

    /// Number of tokens of each phrase of a class at an index.
    pub fn lengths(&self, class: &str, at: usize) -> Vec<usize> {
        lexicon().lengths(class, &self.tokens, at)
    }

    /// Number of tokens of the longest phrase of a class at an index.
    pub fn longest(&self, class: &str, at: usize) -> Option<usize> {
        self.lengths(class, at).into_iter().max()
    }

    pub fn phrases_at(&self, at: usize) -> Rc<Vec<Span<NounPhrase>>> {
        memoized(&self.phrases, at, || self.read_phrases(at))
    }

    /// Phrases joined by "and" or commas, of one and more.
    pub fn lists_at(&self, at: usize) -> Rc<Vec<Span<Vec<NounPhrase>>>> {
        memoized(&self.lists, at, || self.read_lists(at))
    }

    pub fn places_at(&self, at: usize) -> Rc<Vec<Span<Place>>> {
        memoized(&self.places, at, || self.read_places(at))
    }

    /// Whether a definite phrase means objects of the scene.
    pub fn resolves(&self, range: &Range<usize>) -> Option<bool> {
        let key = (range.start, range.end);
        if let Some(known) = self.resolved.borrow().get(&key) {
            return *known;
        }
        let resolves = self.referents.resolves(&self.written(range.clone()));
        self.resolved.borrow_mut().insert(key, resolves);
        resolves
    }
}

fn memoized<T>(memo: &Memo<T>, at: usize, read: impl FnOnce() -> Vec<Span<T>>) -> Rc<Vec<Span<T>>> {
    if let Some(known) = memo.borrow().get(&at) {
        return known.clone();
    }
    let found = Rc::new(read());
    memo.borrow_mut().insert(at, found.clone());
    found
}

/// Keeps the cheapest of several readings that end at the same index.
pub(crate) fn cheapest<T>(mut found: Vec<Span<T>>) -> Vec<Span<T>> {
    found.sort_by(|a, b| a.end.cmp(&b.end).then(a.cost.total_cmp(&b.cost)));
    found.dedup_by_key(|span| span.end);
    found
}
