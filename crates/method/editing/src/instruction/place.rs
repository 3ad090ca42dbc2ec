//! Places in an instruction: relations to objects, regions of the table, distances from its edges, displacements.

use super::Reason;
use super::cursor::{Cursor, Outcome};
use crate::references::vocabulary;
use catalog::Affordance;
use scene::RelationKind::{
    self, AtLeft, AtRight, Behind, Between, In, InFrontOf, LeftOf, NextTo, On, RightOf,
};
use scene::{EditPlace, SupportRelation};

const RELATIONS: &[(&str, RelationKind)] = &[
    ("to the left side of", LeftOf),
    ("to the right side of", RightOf),
    ("on the left side of", LeftOf),
    ("on the right side of", RightOf),
    ("to the left of", LeftOf),
    ("to the right of", RightOf),
    ("on the left of", LeftOf),
    ("on the right of", RightOf),
    ("at the left of", LeftOf),
    ("at the right of", RightOf),
    ("left of", LeftOf),
    ("right of", RightOf),
    ("in front of", InFrontOf),
    ("in back of", Behind),
    ("behind", Behind),
    ("next to", NextTo),
    ("close to", NextTo),
    ("near to", NextTo),
    ("adjacent to", NextTo),
    ("beside", NextTo),
    ("alongside", NextTo),
    ("near", NextTo),
    ("away from", NextTo),
    ("from", NextTo),
    ("on top of", On),
    ("onto", On),
    ("on to", On),
    ("on", On),
    ("upon", On),
    ("atop", On),
    ("inside of", In),
    ("inside", In),
    ("into", In),
    ("in", In),
    ("to", NextTo),
    ("by", NextTo),
    ("at", NextTo),
];

/// Groups of the catalog whose objects are made to carry others.
const CARRIERS: &[&str] = &["carrier", "dish", "board", "mat", "tableware", "cloth"];

impl Cursor {
    /// The place at the cursor.
    pub fn place(&mut self) -> Outcome<EditPlace> {
        let start = self.at;
        let place = self.one_place()?;
        let and_edge = self.connector_at(self.at) > 0
            && self.distance_at(self.at + self.connector_at(self.at)).is_some();
        if and_edge {
            return Err(self.error(start, self.tokens.len(), Reason::TwoPlaces));
        }
        // "on the table next to the laptop" is one place.
        let on_table = place.relation == Some(On) && place.target.is_none();
        let relative = place.relation.is_some_and(RelationKind::target_is_object);
        let more = self.preposition_at(self.at).is_some();
        if on_table && more {
            return self.one_place();
        }
        if relative && self.is_at(self.at, "on the table") {
            self.at += 3;
        }
        Ok(place)
    }

    pub fn one_place(&mut self) -> Outcome<EditPlace> {
        let start = self.at;
        if self.take_any(&["there", "in its place", "in the same place"]) {
            let known = self.discourse.place.clone();
            return known.ok_or_else(|| self.error(start, self.at, Reason::NoAntecedent));
        }
        let distance_m = self.distance_at(start).map(|(distance_m, length)| {
            self.at += length;
            distance_m
        });
        self.at += usize::from(self.is_at(self.at, "away from the") && distance_m.is_some());
        if let Some(offset) = self.offset(distance_m)? {
            return Ok(offset);
        }
        if !self.is_at(self.at, "right of") {
            let _ =
                self.take_any(&["directly", "just", "immediately", "exactly", "right", "halfway", "midway"]);
        }
        // "to its left" is to the left of it.
        let sides = [
            ("to its left", LeftOf),
            ("to its right", RightOf),
            ("on its left", LeftOf),
            ("on its right", RightOf),
        ];
        if let Some((pattern, kind)) = sides.into_iter().find(|(pattern, _)| self.is_at(self.at, pattern)) {
            self.at += 2;
            "it".clone_into(&mut self.tokens[self.at].word);
            return self.relation(start, pattern, kind, distance_m);
        }
        if let Some((region, is_edge, at)) = self.region_at(self.at) {
            self.at = at;
            return self.region(start, region, is_edge, distance_m);
        }
        for (pattern, kind) in RELATIONS {
            if self.is_at(self.at, pattern) {
                self.at += pattern.split(' ').count();
                return self.relation(start, pattern, *kind, distance_m);
            }
        }
        if self.is_at(self.at, "between") || self.is_at(self.at, "in between") {
            self.at += if self.is_at(self.at, "in") { 2 } else { 1 };
            return self.between();
        }
        self.not_understood(
            start,
            "say on, in, next to, left of, right of, in front of, behind or between and an object, or a part of \
             the table",
        )
    }

    pub fn relation(
        &mut self,
        start: usize,
        pattern: &str,
        kind: RelationKind,
        mut distance_m: Option<f64>,
    ) -> Outcome<EditPlace> {
        let vague = matches!(pattern, "from" | "away from" | "by" | "at") && distance_m.is_none();
        if vague && !matches!(pattern, "by") {
            return Err(self.error(start, self.at, Reason::HowFar));
        }
        let target = self.landmark(kind)?;
        let kind = if pattern == "to" { self.destination_relation(start, &target)? } else { kind };
        if let Some((by_m, length)) = self.trailing_distance() {
            distance_m = Some(by_m);
            self.at += length;
        }
        let is_table = target.split_once(' ').is_some_and(|(article, noun)| {
            matches!(article, "the" | "my" | "this" | "our") && vocabulary().is_table(noun)
        });
        if is_table {
            return match kind {
                On => Ok(EditPlace { relation: Some(On), ..EditPlace::default() }),
                LeftOf => Ok(EditPlace::at(AtLeft)),
                RightOf => Ok(EditPlace::at(AtRight)),
                _ => Err(self.error(start, self.at, Reason::NotUnderstood("name a part of the table"))),
            };
        }
        if kind.is_support() && distance_m.is_some() {
            return Err(self.error(start, self.at, Reason::NotUnderstood("a distance needs a direction")));
        }
        self.discourse.landmark = Some((kind, target.clone()));
        Ok(EditPlace { distance_m, ..EditPlace::related(kind, target) })
    }

    /// Relation that "to" an object means: into a container, onto an object that is made to carry others, else next to
    /// it.
    fn destination_relation(&self, start: usize, target: &str) -> Outcome<RelationKind> {
        match super::nouns::category_of(target) {
            Some(category) if category.label.ends_with("tray") => Ok(On),
            Some(category) if category.affords(Affordance::Container) => Ok(In),
            Some(category) if CARRIERS.contains(&category.group.as_str()) => Ok(On),
            Some(category) if !category.affords(Affordance::Support) => Ok(NextTo),
            _ => Err(self.error(start, self.at, Reason::Destination)),
        }
    }

    /// "by 10 cm", "10 cm away" after the object.
    pub fn trailing_distance(&self) -> Option<(f64, usize)> {
        if self.is_at(self.at, "by") {
            return self.distance_at(self.at + 1).map(|(distance_m, length)| (distance_m, 1 + length));
        }
        let comma = usize::from(self.word(self.at) == ",");
        let (distance_m, length) = self.distance_at(self.at + comma)?;
        self.is_at(self.at + comma + length, "away").then_some((distance_m, comma + length + 1))
    }

    /// The object that a relation is to.
    pub fn landmark(&mut self, kind: RelationKind) -> Outcome<String> {
        let start = self.at;
        let each =
            matches!(self.word(start), "each" | "every" | "all" | "both" | "these" | "those" | "everything");
        if each {
            let end = self.phrase_end(start, &|_| false);
            return Err(self.error(start, end, Reason::SeveralLandmarks));
        }
        if let Some(phrase) = self.landmark_pronoun(kind)? {
            return Ok(phrase);
        }
        let table = self.table_end(start);
        let stops = |index: usize| {
            self.distance_at(index).is_some()
                || self.is_at(index, "by")
                || self.is_at(index, "on the table")
                || self.is_at(index, "facing")
        };
        let end = table.unwrap_or_else(|| self.phrase_end(start, &stops));
        if end == start {
            return self.not_understood(start, "name the object that the place is relative to");
        }
        if matches!(self.word(end - 1), "corner" | "edge" | "side" | "end" | "border") {
            return self
                .not_understood(start, "say which part of the table: the back left corner, the left edge");
        }
        if self.is_at(start, "a") || self.is_at(start, "an") {
            return Err(self.error(start, end, Reason::NewLandmark));
        }
        let phrase = self.target_text(start, end);
        if super::discourse::is_plural(&phrase) {
            return Err(self.error(start, end, Reason::SeveralLandmarks));
        }
        self.at = end;
        Ok(phrase)
    }

    /// The end of "the table" where a place or nothing follows.
    fn table_end(&self, start: usize) -> Option<usize> {
        let article = matches!(self.word(start), "the" | "my" | "this" | "our");
        let noun =
            |length: usize| vocabulary().is_table(&self.text(start + 1, start + 1 + length).to_lowercase());
        let end =
            [2, 1].into_iter().find(|&length| article && noun(length)).map(|length| start + 1 + length)?;
        (self.is_boundary(end) || self.preposition_at(end).is_some()).then_some(end)
    }

    /// Phrase that "it" of a place stands for: the topic, or the last landmark in "a fork left of the plate and a knife
    /// right of it".
    pub fn landmark_pronoun(&mut self, kind: RelationKind) -> Outcome<Option<String>> {
        let start = self.at;
        let pronoun = matches!(self.word(start), "it" | "them")
            || (matches!(self.word(start), "that" | "this") && self.is_boundary(start + 1));
        if !pronoun {
            return Ok(None);
        }
        let landmark = self.discourse.landmark.clone();
        if let Some((before, phrase)) = &landmark
            && is_opposite(*before, kind)
            && self.word(start) == "it"
        {
            self.at += 1;
            return Ok(Some(phrase.clone()));
        }
        let beside = |kind: RelationKind| kind.target_is_object();
        if landmark.as_ref().is_some_and(|(before, _)| beside(*before) && beside(kind)) {
            return Err(self.error(start, start + 1, Reason::UnclearPronoun));
        }
        let targets = self.pronoun()?.unwrap_or_default();
        let [target] = &targets[..] else {
            return Err(self.error(start, start + 1, Reason::SeveralLandmarks));
        };
        if super::discourse::is_plural(&target.phrase) {
            return Err(self.error(start, start + 1, Reason::SeveralLandmarks));
        }
        let support = match kind {
            On => Some(SupportRelation::On),
            In => Some(SupportRelation::In),
            _ => None,
        };
        if let (Some(support), Some((_, other))) = (support, landmark)
            && other != target.phrase
            && !super::nouns::supports(&target.phrase, support)
            && super::nouns::supports(&other, support)
        {
            return Err(self.error(start, start + 1, Reason::UnclearPronoun));
        }
        Ok(Some(target.phrase.clone()))
    }

    /// Reads the words after "between".
    pub fn between(&mut self) -> Outcome<EditPlace> {
        let start = self.at;
        let place = |first: String, second: String| EditPlace {
            second_target: Some(second),
            ..EditPlace::related(Between, first)
        };
        if let Some(length) = self.length_of_any(start, &["the two", "both", "both of the", "the"]) {
            let end = self.phrase_end(start, &|_| false);
            let noun = self.text(start + length, end);
            let alone = self.connector_at(end) == 0 || !self.is_phrase(end + self.connector_at(end));
            if super::discourse::is_plural(&format!("two {noun}"))
                && alone
                && super::discourse::is_plural(&noun)
                || self.is_at(start, "the two")
            {
                self.at = end;
                return Ok(place(
                    format!("the first of the two {noun}"),
                    format!("the second of the two {noun}"),
                ));
            }
        }
        if self.is_at(start, "them") {
            return match self.pronoun()?.as_deref() {
                Some([first, second]) => Ok(place(first.phrase.clone(), second.phrase.clone())),
                _ => Err(self.error(start, self.at, Reason::UnclearPronoun)),
            };
        }
        let first = self.landmark(Between)?;
        if !self.take("and") {
            return self.not_understood(start, "name two objects: between the mug and the plate");
        }
        let second = self.landmark(Between)?;
        Ok(place(first, second))
    }
}

fn is_opposite(a: RelationKind, b: RelationKind) -> bool {
    matches!((a, b), (LeftOf, RightOf) | (RightOf, LeftOf) | (InFrontOf, Behind) | (Behind, InFrontOf))
}
