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
    pub tokens: Vec<Token>,
    pub referents: &'a dyn Referents,
    phrases: Memo<NounPhrase>,
    lists: Memo<Vec<NounPhrase>>,
    places: Memo<Place>,
    resolved: RefCell<BTreeMap<(usize, usize), Option<bool>>>,
}

impl<'a> Chart<'a> {
    pub fn new(text: &'a str, referents: &'a dyn Referents) -> Self {
        Self {
            text,
            tokens: tokens(text),
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

    /// A range as written.
    pub fn written(&self, range: Range<usize>) -> String {
        match (self.tokens.get(range.start), range.end.checked_sub(1).and_then(|last| self.tokens.get(last)))
        {
            (Some(first), Some(last)) if !range.is_empty() => {
                self.text[first.span.start..last.span.end].to_owned()
            }
            _ => String::new(),
        }
    }

    /// Bytes of a range.
    pub fn bytes(&self, range: &Range<usize>) -> Range<usize> {
        let start = self.tokens.get(range.start).map_or(self.text.len(), |token| token.span.start);
        let end = range.end.checked_sub(1).and_then(|last| self.tokens.get(last));
        start..end.map_or(start, |token| token.span.end).max(start)
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
