//! Noun phrases: which objects, new or existing, and how many.
//!
//! A phrase is a quantity ("both", "two of"), a determiner, modifiers and a noun, what says which one is meant ("on the
//! tray", "from the left", "that is red") and exceptions ("except the blue one"). How far it goes is open where a place
//! follows; every extent is a reading of its own.

use std::ops::Range;

use crate::chart::{Chart, Span, cheapest};
use crate::measures::{fraction_at, number_at, vague_count_at};
use crate::outermost::outermost;
use crate::vocabulary::vocabulary;

/// Cost of a noun that is not known.
const UNKNOWN_NOUN: f64 = 3.0;
/// Cost of a modifier that is not known.
const UNKNOWN_MODIFIER: f64 = 2.0;
/// Cost of a definite phrase that means no object of the scene.
const UNRESOLVED: f64 = 3.0;
/// Of one that does.
const RESOLVED: f64 = -0.3;

/// Manner in which a phrase refers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reference {
    /// "it", "them", "both": objects that were named before.
    Pronoun,
    /// Objects that exist.
    Definite,
    /// New objects, or any that fit.
    Indefinite,
}

/// Number of objects that a phrase means.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Quantity {
    One,
    Count(u32),
    /// A plural without a number.
    Plural,
    All,
    /// "each plate": as all, but one at a time.
    Each,
    /// "half of the fruit"
    Fraction(f64),
}

impl Quantity {
    /// Whether it may be several objects.
    pub fn is_plural(self) -> bool {
        !matches!(self, Self::One | Self::Count(1))
    }
}

/// A noun phrase.
#[derive(Clone, Debug, PartialEq)]
pub struct NounPhrase {
    pub tokens: Range<usize>,
    pub reference: Reference,
    pub quantity: Quantity,
    /// Modifiers and noun, without quantity, determiner and what follows.
    pub body: Range<usize>,
    /// The noun alone, in lower case.
    pub noun: String,
    /// Whether any so many of a whole are meant ("two of the apples").
    pub is_choice: bool,
    /// "everything else", "the others": all that was not named.
    pub is_rest: bool,
    /// "another mug", "more mugs", "a new one".
    pub is_additional: bool,
}

/// The words before the body.
struct Opening {
    at: usize,
    reference: Reference,
    quantity: Option<Quantity>,
    is_choice: bool,
    is_additional: bool,
}

/// Modifiers and noun.
struct Body {
    end: usize,
    cost: f64,
    noun: Range<usize>,
    has_rank: bool,
    /// Whether the noun is none that is known.
    is_unknown: bool,
}

impl Chart<'_> {
    pub(crate) fn read_phrases(&self, at: usize) -> Vec<Span<NounPhrase>> {
        let mut found = self.pronouns(at);
        found.extend(self.totals(at));
        found.extend(self.names(at));
        for opening in self.openings(at) {
            for body in self.bodies(opening.at, opening.reference == Reference::Definite) {
                let mut phrase = self.phrase(at, &opening, &body);
                let is_bare = opening.at == at;
                // "vase in the center", "leftmost apple": what is there needs no article.
                let is_singular = !phrase.quantity.is_plural();
                if is_bare && is_singular && (body.has_rank || self.resolves(&phrase.tokens) == Some(true)) {
                    phrase.reference = Reference::Definite;
                }
                // Without an article it is likelier another word, unless it is there.
                let absent = is_bare && is_singular && self.resolves(&phrase.tokens) == Some(false);
                let cost = body.cost
                    + if is_bare && is_singular { 0.6 } else { 0.0 }
                    + if absent { 2.5 } else { 0.0 };
                // "pour some wine": a word before it that is not known is likelier a verb.
                if is_bare && (body.is_unknown || body.cost >= UNKNOWN_MODIFIER) {
                    continue;
                }
                found.push(Span {
                    end: body.end,
                    cost: cost + self.evidence(&phrase),
                    value: phrase.clone(),
                });
                self.extend(&phrase, body.end, cost, body.has_rank, 0, &mut found);
            }
        }
        cheapest(found)
    }

    /// The cost of what the scene says of a phrase.
    fn evidence(&self, phrase: &NounPhrase) -> f64 {
        if phrase.reference != Reference::Definite || phrase.is_rest {
            return 0.0;
        }
        match self.resolves(&phrase.tokens) {
            Some(true) => RESOLVED,
            Some(false) => UNRESOLVED,
            None => 0.0,
        }
    }

    /// "it", "them", "these", "both of them", "one of them".
    fn pronouns(&self, at: usize) -> Vec<Span<NounPhrase>> {
        let mut found = Vec::new();
        let mut add = |length: usize, quantity: Quantity| {
            found.push(Span {
                end: at + length,
                cost: 0.0,
                value: self.bare(at..at + length, Reference::Pronoun, quantity),
            });
        };
        match self.word(at) {
            "it" | "itself" | "that" | "this" => add(1, Quantity::One),
            "them" | "these" | "those" | "they" | "both" => add(1, Quantity::All),
            "each" if self.word(at + 1) != "of" => add(1, Quantity::Each),
            _ => {}
        }
        let of_them =
            |at: usize| self.word(at) == "of" && matches!(self.word(at + 1), "them" | "these" | "those");
        if matches!(self.word(at), "all" | "both" | "each") && of_them(at + 1) {
            add(3, if self.word(at) == "each" { Quantity::Each } else { Quantity::All });
        }
        if matches!(self.word(at), "they" | "them") && matches!(self.word(at + 1), "all" | "both") {
            add(2, Quantity::All);
        }
        found
    }

    /// "everything", "everything else on the tray", "the rest", "the others".
    fn totals(&self, at: usize) -> Vec<Span<NounPhrase>> {
        let patterns: [(&str, bool); 14] = [
            ("anything else", true),
            ("anything", false),
            ("everything", false),
            ("everything else", true),
            ("all else", true),
            ("all the rest", true),
            ("the rest", true),
            ("the others", true),
            ("all the others", true),
            ("all others", true),
            ("everything that is left", true),
            ("all other objects", true),
            ("all the other objects", true),
            ("whatever", false),
        ];
        let mut found = Vec::new();
        for (pattern, is_rest) in patterns {
            let words = crate::lexicon::split(pattern);
            if !crate::lexicon::begins_with(&self.tokens, at, &words) {
                continue;
            }
            let end = at + words.len();
            let mut phrase = self.bare(at..end, Reference::Definite, Quantity::All);
            phrase.is_rest = is_rest;
            found.push(Span { end, cost: 0.0, value: phrase.clone() });
            self.extend(&phrase, end, 0.0, false, 0, &mut found);
        }
        found
    }

    /// "mug_1".
    fn names(&self, at: usize) -> Vec<Span<NounPhrase>> {
        let is_name = self.word(at).contains('_') && self.word(at).ends_with(|c: char| c.is_ascii_digit());
        if !is_name {
            return Vec::new();
        }
        vec![Span {
            end: at + 1,
            cost: 0.0,
            value: self.bare(at..at + 1, Reference::Definite, Quantity::One),
        }]
    }

    pub(crate) fn bare(&self, tokens: Range<usize>, reference: Reference, quantity: Quantity) -> NounPhrase {
        let noun = self.words(tokens.clone());
        let body = tokens.clone();
        let (is_choice, is_rest, is_additional) = (false, false, false);
        NounPhrase { tokens, reference, quantity, body, noun, is_choice, is_rest, is_additional }
    }

    /// Quantities and determiners at an index, also none.
    fn openings(&self, at: usize) -> Vec<Opening> {
        let plain = |at, reference, quantity| Opening {
            at,
            reference,
            quantity,
            is_choice: false,
            is_additional: false,
        };
        let mut found = vec![plain(at, Reference::Indefinite, None)];
        let definite = |at: usize| self.longest("definite", at);
        if let Some(length) = definite(at) {
            found.push(plain(at + length, Reference::Definite, None));
            if let Some((value, count)) = number_at(&self.tokens, at + length)
                && value.fract() == 0.0
                && value >= 1.0
            {
                found.push(plain(
                    at + length + count,
                    Reference::Definite,
                    Some(Quantity::Count(value as u32)),
                ));
            }
        }
        if let Some(length) = self.longest("indefinite", at) {
            let is_additional = self.word(at) == "another";
            let quantity = if self.word(at) == "some" { None } else { Some(Quantity::One) };
            found.push(Opening { is_additional, ..plain(at + length, Reference::Indefinite, quantity) });
        }
        for (quantity, length, reference) in self.quantities(at) {
            let mut after = at + length;
            let is_additional =
                matches!(self.word(after), "more" | "additional" | "extra" | "further" | "new");
            if is_additional && reference == Reference::Indefinite {
                after += 1;
            }
            found.push(Opening { is_additional, ..plain(after, reference, Some(quantity)) });
            // "all four plates"
            if quantity == Quantity::All
                && let Some((_, length)) = number_at(&self.tokens, after)
            {
                found.push(plain(after + length, reference, Some(quantity)));
            }
            let of = usize::from(self.word(after) == "of");
            if let Some(length) = definite(after + of) {
                let is_choice =
                    matches!(quantity, Quantity::One | Quantity::Count(_) | Quantity::Fraction(_));
                let mut next = after + of + length;
                // "two of the three mugs", "all the six cubes".
                if let Some((_, length)) = number_at(&self.tokens, next) {
                    found.push(Opening {
                        is_choice,
                        ..plain(next + length, Reference::Definite, Some(quantity))
                    });
                }
                if is_choice && of == 0 && !matches!(quantity, Quantity::Fraction(_)) {
                    next = usize::MAX;
                }
                if next != usize::MAX {
                    found.push(Opening { is_choice, ..plain(next, Reference::Definite, Some(quantity)) });
                }
            }
        }
        found
    }

    /// Quantities before a noun or before "of the".
    fn quantities(&self, at: usize) -> Vec<(Quantity, usize, Reference)> {
        let mut found = Vec::new();
        match self.word(at) {
            "all" => found.push((Quantity::All, 1, Reference::Definite)),
            "both" => found.push((Quantity::All, 1, Reference::Definite)),
            "every" | "each" => found.push((Quantity::Each, 1, Reference::Definite)),
            "either" | "any" => found.push((Quantity::One, 1, Reference::Definite)),
            _ => {}
        }
        if let Some((value, length)) = fraction_at(&self.tokens, at) {
            found.push((Quantity::Fraction(value), length, Reference::Definite));
        }
        if let Some((count, length)) = vague_count_at(&self.tokens, at) {
            found.push((Quantity::Count(count), length, Reference::Indefinite));
        }
        if let Some((value, length)) = number_at(&self.tokens, at)
            && value.fract() == 0.0
            && (1.0..1e6).contains(&value)
        {
            found.push((Quantity::Count(value as u32), length, Reference::Indefinite));
        }
        if matches!(self.word(at), "more" | "additional" | "extra" | "further" | "new") {
            found.push((Quantity::Plural, 0, Reference::Indefinite));
        }
        found
    }

    fn phrase(&self, at: usize, opening: &Opening, body: &Body) -> NounPhrase {
        let noun = self.words(body.noun.clone());
        let is_many = is_plural_noun(&noun);
        let quantity = opening.quantity.unwrap_or(if is_many { Quantity::Plural } else { Quantity::One });
        NounPhrase {
            tokens: at..body.end,
            reference: opening.reference,
            quantity,
            body: opening.at..body.end,
            noun,
            is_choice: opening.is_choice,
            is_rest: false,
            is_additional: opening.is_additional,
        }
    }

    /// Modifiers and a noun from an index on.
    fn bodies(&self, at: usize, is_definite: bool) -> Vec<Body> {
        let mut found = Vec::new();
        self.read_bodies(at, 0.0, false, is_definite, 0, &mut found);
        let mut kept: Vec<Body> = Vec::new();
        found.sort_by(|a: &Body, b: &Body| a.end.cmp(&b.end).then(a.cost.total_cmp(&b.cost)));
        for body in found {
            if kept.last().is_none_or(|last| last.end != body.end) {
                kept.push(body);
            }
        }
        kept
    }

    fn read_bodies(
        &self,
        at: usize,
        cost: f64,
        ranked: bool,
        definite: bool,
        depth: usize,
        found: &mut Vec<Body>,
    ) {
        if depth > 5 || self.tokens.get(at).is_none_or(|token| token.is_quoted) {
            return;
        }
        for length in 1..=4.min(self.tokens.len() - at) {
            let end = at + length;
            let words = self.words(at..end);
            let ends_as_can = words.ends_with(" can") && self.referents.is_noun(&words);
            let described = self.word(end - 1) == "can" && length == 1 && self.is_described(at);
            let closed = |token: &crate::tokens::Token| token.is_quoted || self.is_function_word(&token.word);
            // "something to drink"
            let is_open_noun = self.word(at) == "something" && self.referents.is_noun(&words);
            if self.word(at) == "something" && !is_open_noun {
                continue;
            }
            if !ends_as_can && !is_open_noun && !described && self.tokens[at..end].iter().any(closed) {
                break;
            }
            let is_one = length == 1 && matches!(words.as_str(), "one" | "ones");
            if self.referents.is_noun(&words) || is_one {
                // "the apple green": the color is what is said of the apple.
                let after_noun =
                    at.checked_sub(1).is_some_and(|before| self.referents.is_noun(self.word(before)));
                let cost = cost + if after_noun && vocabulary().is_color(&words) { 1.0 } else { 0.0 };
                found.push(Body { end, cost, noun: at..end, has_rank: ranked, is_unknown: false });
                self.read_complement(at, end, cost, ranked, found);
            } else if length == 1 && words.chars().all(char::is_alphabetic) {
                found.push(Body {
                    end,
                    cost: cost + UNKNOWN_NOUN,
                    noun: at..end,
                    has_rank: ranked,
                    is_unknown: true,
                });
            }
        }
        // Without a noun: "the second of the two plates", "the leftmost and the rightmost cube".
        if definite && depth > 0 && cost < 1.0 && (ranked || self.word(at) == "of") {
            found.push(Body { end: at, cost: cost + 0.8, noun: at..at, has_rank: ranked, is_unknown: false });
        }
        for length in self.lengths("adjective", at) {
            let is_rank = vocabulary().is_order(self.word(at));
            self.read_bodies(at + length, cost, ranked || is_rank, definite, depth + 1, found);
        }
        let word = self.word(at);
        let digits = word.starts_with(|c: char| c.is_ascii_digit()) && word.ends_with(char::is_alphabetic);
        if digits {
            self.read_bodies(at + 1, cost, true, definite, depth + 1, found);
        }
        for length in [2, 1] {
            let words = if at + length <= self.tokens.len() { self.words(at..at + length) } else { continue };
            if vocabulary().is_color(&words) || vocabulary().is_material(&words) {
                self.read_bodies(at + length, cost, ranked, definite, depth + 1, found);
            }
        }
        let is_number = number_at(&self.tokens, at).is_some();
        if !word.is_empty()
            && !is_number
            && !self.is_function_word(word)
            && word.chars().all(char::is_alphabetic)
        {
            let of_noun = self.referents.is_noun(word);
            let price = if of_noun { 0.15 } else { UNKNOWN_MODIFIER };
            self.read_bodies(at + 1, cost + price, ranked, definite, depth + 1, found);
        }
    }

    /// Whether a determiner, a color or an adjective stands before an index.
    fn is_described(&self, at: usize) -> bool {
        let Some(before) = at.checked_sub(1) else { return false };
        let word = self.word(before);
        let determiner = ["definite", "indefinite", "all", "adjective"]
            .iter()
            .any(|class| self.lengths(class, before).contains(&1));
        determiner || vocabulary().is_color(word) || number_at(&self.tokens, before).is_some()
    }

    fn is_function_word(&self, word: &str) -> bool {
        crate::lexicon::lexicon().is_function_word(word)
    }

    /// "glass of water", "stack of three books".
    fn read_complement(&self, start: usize, end: usize, cost: f64, ranked: bool, found: &mut Vec<Body>) {
        if self.word(end) != "of" || self.longest("definite", end + 1).is_some() {
            return;
        }
        let number = number_at(&self.tokens, end + 1).map_or(0, |(_, length)| length);
        let mut inner = Vec::new();
        self.read_bodies(end + 1 + number, 0.0, false, false, 3, &mut inner);
        for body in inner {
            let cost = cost + body.cost.min(0.5);
            found.push(Body {
                end: body.end,
                cost,
                noun: start..body.end,
                has_rank: ranked,
                is_unknown: false,
            });
        }
    }

    /// Words after a noun that say which object is meant.
    fn extend(
        &self,
        phrase: &NounPhrase,
        end: usize,
        cost: f64,
        ranked: bool,
        depth: usize,
        found: &mut Vec<Span<NounPhrase>>,
    ) {
        if depth > 1 {
            return;
        }
        for (next, price) in self.qualifiers(
            end,
            ranked,
            phrase.quantity.is_plural() || phrase.tokens.start + 1 < phrase.body.start,
        ) {
            let mut longer = phrase.clone();
            longer.tokens.end = next;
            // A new object has no place yet: what follows is where it goes.
            let price = if phrase.reference == Reference::Indefinite { price + 1.0 } else { price };
            let total = cost + price;
            found.push(Span { end: next, cost: total + self.evidence(&longer), value: longer.clone() });
            self.extend(&longer, next, total, ranked, depth + 1, found);
        }
    }

    /// The ends of what may follow a noun, with their costs.
    fn qualifiers(&self, at: usize, ranked: bool, is_plural: bool) -> Vec<(usize, f64)> {
        let mut found = Vec::new();
        let sides = ["left", "right", "front", "back", "top", "bottom"];
        if self.word(at) == "from" && self.word(at + 1) == "the" && sides.contains(&self.word(at + 2)) {
            found.push((at + 3, if ranked { -0.5 } else { 1.5 }));
        }
        let after_relative = self.lengths("relative", at).into_iter().chain([0]);
        for start in after_relative.map(|length| at + length) {
            let words: Vec<&str> = (start..start + 7).map(|at| self.word(at)).collect();
            if let Some((_, length)) = outermost(&words) {
                found.push((start + length, -0.2));
            }
        }
        if self.word(at) == "of" && self.longest("definite", at + 1).is_some() {
            found.extend(self.phrases_at(at + 1).iter().map(|span| (span.end, span.cost + 0.2)));
        }
        let place = |price: f64, found: &mut Vec<(usize, f64)>, from: usize| {
            for span in self.places_at(from).iter() {
                if let Some(attachment) = span.value.attachment() {
                    found.push((span.end, span.cost + attachment + price));
                }
            }
        };
        place(0.0, &mut found, at);
        for length in self.lengths("relative", at) {
            place(-0.4, &mut found, at + length);
            let not = usize::from(self.word(at + length) == "not");
            for body in self.appearances_at(at + length + not) {
                found.push((body.end, 0.2));
            }
        }
        let relatives = self.lengths("relative", at);
        let starts = std::iter::once(0).chain(relatives.iter().copied());
        for (class, price, skipped) in starts.flat_map(|skipped| {
            [("supporting", 0.4, skipped), ("closest", 0.2, skipped), ("farthest", 0.2, skipped)]
        }) {
            for length in self.lengths(class, at + skipped).into_iter().map(|length| length + skipped) {
                for span in self.phrases_at(at + length).iter() {
                    let in_it = matches!(self.word(span.end), "in" | "on" | "inside")
                        && matches!(self.word(span.end + 1), "it" | "them");
                    found.push((span.end + if in_it { 2 } else { 0 }, span.cost + price));
                }
            }
        }
        for length in self.lengths("exceptions", at).into_iter().filter(|_| is_plural) {
            found.extend(self.lists_at(at + length).iter().map(|span| (span.end, span.cost)));
        }
        found
    }

    pub(crate) fn read_lists(&self, at: usize) -> Vec<Span<Vec<NounPhrase>>> {
        let mut found: Vec<Span<Vec<NounPhrase>>> = Vec::new();
        let mut open: Vec<Span<Vec<NounPhrase>>> = self
            .phrases_at(at)
            .iter()
            .map(|span| Span { end: span.end, cost: span.cost, value: vec![span.value.clone()] })
            .collect();
        while let Some(list) = open.pop() {
            if list.value.len() < 8 {
                for next in self.joined(list.end) {
                    // "behind that, a pepper mill" is no list.
                    let after_pronoun =
                        list.value.last().is_some_and(|last| last.reference == Reference::Pronoun);
                    let price = if after_pronoun { 1.5 } else { 0.3 };
                    for span in self.phrases_at(next).iter() {
                        let mut value = list.value.clone();
                        value.push(span.value.clone());
                        open.push(Span { end: span.end, cost: list.cost + span.cost + price, value });
                    }
                }
            }
            // Of equal ends the cheapest is kept, so that the number of open lists stays small.
            match found.iter_mut().find(|known| known.end == list.end) {
                Some(known) if known.cost <= list.cost => {}
                Some(known) => *known = list,
                None => found.push(list),
            }
        }
        cheapest(found)
    }

    /// Indices after ",", "and", ", and", "as well as".
    fn joined(&self, at: usize) -> Vec<usize> {
        let comma = usize::from(self.word(at) == ",");
        let and = match self.word(at + comma) {
            "and" | "plus" => 1,
            "as" if self.word(at + comma + 1) == "well" && self.word(at + comma + 2) == "as" => 3,
            _ => 0,
        };
        if comma + and > 0 { vec![at + comma + and] } else { Vec::new() }
    }
}

/// Whether a noun is a plural that has a singular.
pub(crate) fn is_plural_noun(noun: &str) -> bool {
    let head = noun.split(" of ").next().unwrap_or_default();
    if vocabulary().is_plural_only(head) {
        return false;
    }
    let singular = vocabulary().singular_of(head);
    singular.is_some_and(|singular| {
        singular != head && (crate::nouns::is_noun(&singular) || !crate::nouns::is_noun(head))
    }) || head == "ones"
}
