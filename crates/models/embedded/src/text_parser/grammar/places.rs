//! Named parts of the table top: "in the back left corner", "10 cm from the left edge", "one in each corner", and table
//! coordinates.

use std::ops::Range;

use glam::DVec2;

use super::{Parser, Place};
use crate::text_parser::account::Claimed;
use crate::text_parser::measures::read_length;
use crate::text_parser::phrase::group_of;
use crate::text_parser::prepositions::{corner_of, place_at};
use crate::text_parser::property::Property;
use crate::text_parser::tokens::{Token, match_phrase};
use scene::RelationKind;
use scene::text_account::UnrecognizedReason;

/// Range of table coordinates, meters from the center of the table top.
const MAX_COORDINATE_M: f64 = 2.5;

impl Parser<'_, '_> {
    /// Assigns a region of the table top to the subject, or to the phrase that follows.
    pub(super) fn place(&mut self, clause_start: bool) -> bool {
        let Some((places, length)) = place_at(self.tokens, self.at, &Self::is_table_word) else {
            return false;
        };
        let noun = self.word(0) == Some("the");
        if noun && self.at > 0 && self.word_at(self.at - 1).is_some_and(|before| before != "and") {
            return false;
        }
        // "on the left notebook" names an object.
        let ends_in_side = matches!(
            self.word(length - 1),
            Some("left" | "right" | "front" | "back" | "rear" | "middle" | "center")
        );
        if ends_in_side && self.word(1) == Some("the") && self.noun_of_text_at(self.at + length) {
            return false;
        }
        let tokens = self.at..self.at + length;
        self.at += length;
        if noun {
            // The place is the subject.
            self.at += usize::from(matches!(self.word(0), Some("holds" | "has" | "contains" | "carries")));
            self.subject.clear();
            let places = places.into_iter().map(|kind| (Place { kind, distance_m: None }, tokens.clone()));
            self.pending_places = places.collect();
            return true;
        }
        if self.opposite_places(&places, tokens.clone()) {
            return true;
        }
        let places = places.into_iter().map(|kind| Place { kind, distance_m: None });
        // "beside the bowl on the left": the place tells which bowl.
        if let Some((target, _)) = self.last_target.filter(|(_, end)| *end == tokens.start)
            && self.tokens[..tokens.start]
                .iter()
                .rev()
                .filter_map(Token::word)
                .take(3)
                .any(|word| word == "the")
            && !self.subject.is_empty()
        {
            for place in places {
                self.set_place(target, place, tokens.clone());
            }
            return true;
        }
        let places: Vec<Place> = places.collect();
        // "a cow in the back left corner looking at a dog in the front right corner": what the first cannot have is
        // said of the second.
        if let (Some((target, _)), Some(&subject)) =
            (self.last_target.filter(|(_, end)| *end == tokens.start), self.subject.last())
        {
            let excluded = |place: &Place| {
                let known = &self.parsed.mentions[subject].places;
                known.iter().any(|known| exclude_each_other(known.kind, place.kind))
            };
            if places.iter().any(excluded) {
                for place in places {
                    self.set_place(target, place, tokens.clone());
                }
                return true;
            }
        }
        // "two pears in a basket at the back": the basket is there.
        if let Some(carrier) = self.carrier_before(tokens.start) {
            for &place in &places {
                self.set_place(carrier, place, tokens.clone());
            }
        }
        self.place_subject(places, tokens, clause_start);
        true
    }

    /// "two vases at the left and right edge", "a fork and a knife on the left and on the right": one at each.
    /// Whether the rule applies.
    fn opposite_places(&mut self, places: &[RelationKind], tokens: Range<usize>) -> bool {
        if self.word(0) != Some("and") {
            return false;
        }
        let mut p = self.at + 1;
        p += usize::from(matches!(self.word_at(p), Some("at" | "on" | "to" | "in")));
        p += usize::from(self.word_at(p) == Some("the"));
        let other = match self.word_at(p) {
            Some("left") => RelationKind::AtLeft,
            Some("right") => RelationKind::AtRight,
            Some("front") => RelationKind::AtFront,
            Some("back" | "rear") => RelationKind::AtBack,
            _ => return false,
        };
        p += 1;
        p += usize::from(matches!(
            self.word_at(p),
            Some("edge" | "edges" | "side" | "sides" | "end" | "ends")
        ));
        let ends = matches!(self.tokens.get(p), None | Some(Token::Pause | Token::End))
            || matches!(self.word_at(p), Some("of" | "and" | "with"));
        let [place] = places else { return false };
        if !ends {
            return false;
        }
        let subjects = self.attached();
        let pair = match subjects[..] {
            [first, second] if !self.is_several(first) && !self.is_several(second) => Some((first, second)),
            [both] if self.parsed.mentions[both].count == Some([2, 2]) => Some((both, self.one_of(both))),
            _ => None,
        };
        let Some((first, second)) = pair else { return false };
        let end = match match_phrase(self.tokens, p, "of the table") {
            Some(length) => p + length,
            None => p,
        };
        for (mention, kind) in [(first, *place), (second, other)] {
            self.set_place(mention, Place { kind, distance_m: None }, tokens.start..end);
        }
        self.at = end;
        true
    }

    /// Whether a noun begins that the text has mentioned before.
    fn noun_of_text_at(&self, at: usize) -> bool {
        let one = self.word_at(at) == Some("one");
        one || self.lexicon.longest_at(self.tokens, at).is_some_and(|(entry, _)| {
            let known = |mention: &super::Mention| {
                mention.meanings.iter().any(|meaning| entry.meanings.contains(meaning))
            };
            self.parsed.mentions.iter().any(known)
        })
    }

    pub(super) fn place_subject(&mut self, places: Vec<Place>, tokens: Range<usize>, clause_start: bool) {
        if self.fronted(clause_start) || self.subject.is_empty() {
            self.subject.clear();
            self.pending.clear();
            self.parsed.account.used(tokens.clone());
            self.pending_places = places.into_iter().map(|place| (place, tokens.clone())).collect();
            return;
        }
        for mention in self.attached() {
            for &place in &places {
                self.set_place(mention, place, tokens.clone());
            }
        }
    }

    /// Assigns a place to a mention; a place that contradicts an earlier one is reported.
    pub(super) fn set_place(&mut self, mention: usize, place: Place, tokens: Range<usize>) {
        let known = &self.parsed.mentions[mention].places;
        if known.iter().any(|known| exclude_each_other(known.kind, place.kind)) {
            self.report(tokens, UnrecognizedReason::Contradiction);
            return;
        }
        let claim = Claimed::Relation { kind: place.kind, from: vec![mention], to: Vec::new() };
        self.parsed.account.claim(tokens, claim);
        let places = &mut self.parsed.mentions[mention].places;
        if !places.contains(&place) {
            places.push(place);
        }
    }

    /// "kettle top right", "plate dead center", and the heading "upper right corner: a clock". Whether the rule
    /// applies.
    pub(super) fn bare_place(&mut self, clause_start: bool) -> bool {
        let mut sides = Vec::new();
        let mut p = self.at + usize::from(self.word(0) == Some("dead"));
        while let Some(side) = self.word_at(p).and_then(side_of) {
            sides.push(side);
            p += 1;
        }
        let noun = matches!(
            self.word_at(p),
            Some(
                "corner"
                    | "side"
                    | "edge"
                    | "half"
                    | "area"
                    | "row"
                    | "column"
                    | "line"
                    | "end"
                    | "part"
                    | "zone"
            )
        );
        let line = self.word_at(p).and_then(group_of).filter(|_| noun);
        p += usize::from(noun);
        let heading = self.is_colon(p) && self.subject.is_empty() && clause_start;
        let ends = matches!(self.tokens.get(p), None | Some(Token::Pause | Token::End))
            || self.word_at(p) == Some("and");
        let place = match corner_of(sides)[..] {
            [place] => Place { kind: place, distance_m: None },
            _ => return false,
        };
        let tokens = self.at..p;
        if heading {
            self.at = p;
            self.parsed.account.used(tokens.clone());
            self.pending_places = vec![(place, tokens)];
            // "back row: two bottles".
            self.each_member = line.map(Some);
            return true;
        }
        if self.subject.is_empty() || !ends || self.follows_pause() {
            return false;
        }
        self.at = p;
        for mention in self.attached() {
            self.set_place(mention, place, tokens.clone());
        }
        true
    }

    /// "at (0.2, -0.1)", "at x = 0.2 m, y = 10 cm".
    pub(super) fn coordinates(&mut self) -> bool {
        let start = self.at;
        let mut p = start;
        if !matches!(self.word_at(p), Some("at" | "position" | "coordinates" | "coordinate" | "x" | "point"))
        {
            return false;
        }
        while matches!(
            self.word_at(p),
            Some("at" | "position" | "coordinates" | "coordinate" | "the" | "table" | "point")
        ) {
            p += 1;
        }
        let mut values = Vec::new();
        let mut plain = [false; 2];
        let mut is_named = false;
        while values.len() < 2 {
            while matches!(self.tokens.get(p), Some(Token::Pause))
                || matches!(self.word_at(p), Some("x" | "y" | "and" | "is"))
            {
                is_named = is_named || self.word_at(p) == Some("x");
                p += 1;
            }
            if let Some((meters, length)) = self.signed_length(p) {
                values.push(meters);
                p += length;
            } else if let Some(Token::Number(number)) = self.tokens.get(p) {
                plain[values.len()] = true;
                values.push(*number);
                p += 1;
            } else {
                return false;
            }
        }
        let bracketed = (start..p).any(|token| self.source.is_open_bracket(token));
        if !bracketed && !is_named {
            return false;
        }
        if matches!(self.tokens.get(p), Some(Token::Pause)) && bracketed {
            p += 1;
        }
        // "(10, 20) cm".
        if let Some(unit) = self.word_at(p).and_then(|word| self.lexicon.vocabulary.units.get(word)) {
            for (value, _) in values.iter_mut().zip(plain).filter(|(_, plain)| *plain) {
                *value *= unit;
            }
            p += 1;
        }
        let relative = [
            "relative to the table center",
            "relative to the center of the table",
            "relative to the center",
            "from the center of the table",
            "from the center",
            "from the table center",
        ];
        p += relative.iter().filter_map(|phrase| match_phrase(self.tokens, p, phrase)).max().unwrap_or(0);
        let position = DVec2::new(values[0], values[1]);
        let subjects = self.attached();
        if subjects.is_empty() {
            self.report(start..p, UnrecognizedReason::NoReferent);
        } else if position.abs().max_element() > MAX_COORDINATE_M {
            self.report(start..p, UnrecognizedReason::OutOfRange);
        } else {
            for &mention in &subjects {
                self.parsed.mentions[mention].position_m = Some(position);
            }
            self.claim_property(start..p, Property::Position, subjects);
        }
        self.at = p;
        true
    }

    /// A length with a unit whose number may be negative.
    fn signed_length(&self, at: usize) -> Option<(f64, usize)> {
        read_length(self.lexicon.vocabulary, self.tokens, at)
    }
}

/// The side of the table that a word names in notes.
fn side_of(word: &str) -> Option<RelationKind> {
    Some(match word {
        "left" => RelationKind::AtLeft,
        "right" => RelationKind::AtRight,
        "top" | "upper" | "back" | "rear" | "far" => RelationKind::AtBack,
        "bottom" | "lower" | "front" | "near" => RelationKind::AtFront,
        "center" | "centre" | "middle" => RelationKind::AtCenter,
        _ => return None,
    })
}

/// Whether an object cannot have both places.
pub(super) fn exclude_each_other(a: RelationKind, b: RelationKind) -> bool {
    use RelationKind::{
        AtBack, AtBackLeft, AtBackRight, AtCenter, AtFront, AtFrontLeft, AtFrontRight, AtLeft, AtRight,
    };
    let sides = |kind: RelationKind| match kind {
        AtLeft => Some((-1, 0)),
        AtRight => Some((1, 0)),
        AtBack => Some((0, 1)),
        AtFront => Some((0, -1)),
        AtBackLeft => Some((-1, 1)),
        AtBackRight => Some((1, 1)),
        AtFrontLeft => Some((-1, -1)),
        AtFrontRight => Some((1, -1)),
        AtCenter => Some((0, 0)),
        _ => None,
    };
    match (sides(a), sides(b)) {
        (Some((0, 0)), Some(other)) | (Some(other), Some((0, 0))) => other.0 != 0 && other.1 != 0,
        (Some(a), Some(b)) => a.0 * b.0 < 0 || a.1 * b.1 < 0,
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn opposite_places_exclude_each_other() {
        use RelationKind::{AtBackLeft, AtCenter, AtFront, AtLeft, AtRight, Facing};
        for (a, b, excluded) in [
            (AtLeft, AtRight, true),
            (AtBackLeft, AtFront, true),
            (AtBackLeft, AtLeft, false),
            (AtCenter, AtBackLeft, true),
            (AtCenter, AtFront, false),
            (AtLeft, Facing, false),
        ] {
            assert_eq!(exclude_each_other(a, b), excluded, "{a:?} {b:?}");
        }
    }
}
