//! Distances: "20 cm to the right of the plate", "10 cm from the left edge", "5 cm apart", "with a gap of 5 cm".

use std::ops::Range;

use glam::DVec2;

use super::steps::is_object;
use super::{Link, LinkKind, Parser, Place, Referent};
use crate::text_parser::account::Claimed;
use crate::text_parser::measures::{Axis, read_length};
use crate::text_parser::phrase::{Group, NounPhrase, noun_phrase};
use crate::text_parser::prepositions::{Preposition, preposition_at};
use crate::text_parser::property::Property;
use crate::text_parser::tokens::{Token, match_phrase};
use scene::RelationKind;
use scene::text_account::UnrecognizedReason;

/// Range of free distances, meters.
const DISTANCES_M: std::ops::RangeInclusive<f64> = 0.0..=2.0;

impl Parser<'_, '_> {
    /// A distance at the current position. Whether the rule applies.
    pub(super) fn distance(&mut self, clause_start: bool) -> bool {
        let start = self.at;
        let mut p = start;
        while matches!(
            self.word_at(p),
            Some(
                "with"
                    | "keep"
                    | "no"
                    | "more"
                    | "less"
                    | "than"
                    | "leave"
                    | "maintain"
                    | "a"
                    | "at"
                    | "about"
                    | "approximately"
                    | "exactly"
                    | "roughly"
                    | "the"
                    | "distance"
                    | "gap"
                    | "of"
                    | "spaced"
                    | "space"
                    | "spacing"
                    | "each"
                    | "separated"
                    | "by"
                    | "around"
                    | "within"
                    | "set"
                    | "placed"
                    | "and"
                    | "is"
                    | "are"
                    | "should"
                    | "must"
                    | "be"
                    | "least"
                    | "most"
                    | "stands"
                    | "stand"
                    | "located"
                    | "positioned"
                    | "lies"
                    | "sits"
            )
        ) && p < start + 6
            && read_length(self.lexicon.vocabulary, self.tokens, p).is_none()
        {
            p += 1;
        }
        let Some((meters, length)) = read_length(self.lexicon.vocabulary, self.tokens, p) else {
            return false;
        };
        let is_gap = (start..p).any(|token| {
            matches!(self.word_at(token), Some("gap" | "spacing" | "space" | "spaced" | "separated"))
        });
        let after = p + length;
        if self.distance_from_center(meters, start, after)
            || self.distance_between(meters, start, after)
            || self.distance_of_relation(meters, start..p, after)
        {
            return true;
        }
        let apart = [
            "apart from each other",
            "apart",
            "from each other",
            "from one another",
            "between them",
            "between each",
            "between each other",
            "between each of them",
            "between the two",
            "of space between them",
            "of space in between",
            "of distance between them",
            "of room between them",
            "of free space between them",
            "space between them",
            "spacing between them",
            "distance between them",
            "of space",
            "gap between them",
            "in between",
            "gaps between them",
            "away from each other",
            "gaps",
            "gap",
            "between neighbors",
            "spacing",
        ]
        .iter()
        .filter_map(|phrase| match_phrase(self.tokens, after, phrase))
        .max();
        if apart.is_some()
            || (is_gap && !matches!(self.word_at(after), Some("from" | "to" | "away" | "between")))
        {
            let end = after + apart.unwrap_or(0);
            self.at = end;
            self.apart(meters, start..end);
            return true;
        }
        // "10 cm between the mug and the plate" has its objects after it.
        if let Some((kind, length)) = self.edge_at(after) {
            let end = after + length;
            self.at = end;
            self.last_edge = Some(kind);
            if !DISTANCES_M.contains(&meters) {
                self.report(start..end, UnrecognizedReason::OutOfRange);
            } else {
                let mut places = vec![Place { kind, distance_m: Some(meters) }];
                let mut last = end;
                // "from both the left edge and the back edge".
                if self.word(0) == Some("and")
                    && let Some((kind, length)) = self.edge_after(end + 1)
                {
                    places.push(Place { kind, distance_m: Some(meters) });
                    last = end + 1 + length;
                    self.at = last;
                }
                self.place_subject(places, start..last, clause_start);
            }
            return true;
        }
        // "a blue cube 10 cm to its left".
        let before = std::mem::replace(&mut self.at, after);
        if let Some(kind) = self.side_of_it().filter(|_| DISTANCES_M.contains(&meters)) {
            self.relate_or_wait(kind, clause_start, start..self.at, Some(meters));
            return true;
        }
        self.at = before;
        let within = (start..p).any(|token| self.word_at(token) == Some("within"));
        let away = ["away from", "from", "off"]
            .iter()
            .chain(within.then_some(&"of"))
            .filter_map(|phrase| match_phrase(self.tokens, after, phrase))
            .max();
        // "25 cm away from the front edge, the plate 5 cm away from it".
        if let (Some(length), Some(kind)) = (away, self.last_edge)
            && self.word_at(after + length) == Some("it")
            && DISTANCES_M.contains(&meters)
        {
            self.at = after + length + 1;
            let place = Place { kind, distance_m: Some(meters) };
            self.place_subject(vec![place], start..self.at, clause_start);
            return true;
        }
        let (preposition, length) = match (preposition_at(self.tokens, after), away) {
            (Some((preposition, length)), None) if !preposition.kind.is_support() => (preposition, length),
            (_, Some(length)) => (
                Preposition {
                    kind: RelationKind::NextTo,
                    inverse: false,
                    may_stand_alone: false,
                    two_targets: false,
                },
                length,
            ),
            _ => return false,
        };
        if !DISTANCES_M.contains(&meters) {
            self.report(start..after, UnrecognizedReason::OutOfRange);
            self.at = after;
            self.prepositional(preposition, length, clause_start, None);
            return true;
        }
        self.at = after;
        self.prepositional(preposition, length, clause_start, Some((meters, start)));
        true
    }

    /// "right of the keyboard (5 cm)": a length in brackets after the object is the distance, not the object's size.
    pub(super) fn bracketed_distance(&self, phrase: &mut NounPhrase, kind: RelationKind) -> Option<f64> {
        if kind.is_support() || self.subject.is_empty() {
            return None;
        }
        let (property, range) = phrase.properties.last()?;
        let is_bracketed = *property == Property::Size
            && range.start == phrase.head_tokens.end + 1
            && self.source.is_open_bracket(range.start - 1);
        let meters = match phrase.attributes.measures.last() {
            Some(measure) if is_bracketed && measure.axis == Axis::Unspecified => measure.meters,
            _ => return None,
        };
        if !DISTANCES_M.contains(&meters) || phrase.attributes.measures.len() > 1 {
            return None;
        }
        phrase.properties.pop();
        phrase.attributes.measures.pop();
        Some(meters)
    }

    /// The position after "no more than", "about" and the like.
    pub(super) fn after_hedges(&self, at: usize) -> usize {
        let hedges = [
            "no more than",
            "not more than",
            "less than",
            "more than",
            "at least",
            "at most",
            "within",
            "about",
            "exactly",
            "roughly",
            "approximately",
            "around",
            "some",
        ];
        let longest = hedges.iter().filter_map(|phrase| match_phrase(self.tokens, at, phrase)).max();
        at + longest.unwrap_or(0)
    }

    /// "from the left edge (of the table)".
    pub(super) fn edge_at(&self, at: usize) -> Option<(RelationKind, usize)> {
        let mut p = at;
        p += match_phrase(self.tokens, p, "away from")
            .or_else(|| match_phrase(self.tokens, p, "in from"))
            .or_else(|| match_phrase(self.tokens, p, "from"))?;
        let (kind, length) = self.edge_after(p)?;
        Some((kind, p + length - at))
    }

    /// "the left edge (of the table)".
    fn edge_after(&self, at: usize) -> Option<(RelationKind, usize)> {
        let mut p = at;
        while matches!(self.word_at(p), Some("both" | "the" | "table" | "tables" | "desk" | "desks" | "its"))
        {
            p += 1;
        }
        let kind = match self.word_at(p)? {
            "left" => RelationKind::FromLeftEdge,
            "right" => RelationKind::FromRightEdge,
            "front" | "near" | "bottom" => RelationKind::FromFrontEdge,
            "back" | "rear" | "far" | "top" => RelationKind::FromBackEdge,
            "edge" => {
                let end = p + 1 + self.of_table(p + 1);
                return Some((RelationKind::FromFrontEdge, end - at));
            }
            _ => return None,
        };
        p += 1;
        while matches!(self.word_at(p), Some("hand" | "side")) {
            p += 1;
        }
        if !matches!(self.word_at(p), Some("edge" | "border" | "end")) && self.word_at(p - 1) != Some("side")
        {
            return None;
        }
        p += usize::from(matches!(self.word_at(p), Some("edge" | "border" | "end")));
        p += self.of_table(p);
        Some((kind, p - at))
    }

    /// Number of tokens of "of the table".
    fn of_table(&self, at: usize) -> usize {
        if self.word_at(at) != Some("of") {
            return 0;
        }
        let noun = at + 1 + usize::from(matches!(self.word_at(at + 1), Some("the" | "this" | "that")));
        if self.word_at(noun).is_some_and(Self::is_table_word) { noun + 1 - at } else { 0 }
    }

    /// A gap between the objects of the current list, or of its last plural member.
    pub(super) fn apart(&mut self, meters: f64, tokens: Range<usize>) {
        if !DISTANCES_M.contains(&meters) {
            self.report(tokens, UnrecognizedReason::OutOfRange);
            return;
        }
        if let Some(last) = self.parsed.arrangements.last_mut()
            && last.gap_m.is_none()
            && last.mentions.iter().any(|m| self.subject.contains(m) || self.salient_list.contains(m))
        {
            last.gap_m = Some(meters);
            let mentions = last.mentions.clone();
            self.claim_property(tokens, Property::Distance, mentions);
            return;
        }
        let mut members = self.members();
        // "two towers: one of ..., one of ..., 20 cm apart".
        let stacks: Vec<usize> =
            self.subject.iter().copied().filter(|&m| self.parsed.mentions[m].stacked).collect();
        if let [.., first, second] = stacks[..] {
            members = vec![first, second];
        }
        match members[..] {
            [] => self.report(tokens, UnrecognizedReason::NoReferent),
            [first, second]
                if stacks.len() > 1
                    || !self.parsed.mentions[first].plural && !self.parsed.mentions[second].plural =>
            {
                let kind = LinkKind::Relation(RelationKind::NextTo);
                let known = self.parsed.links.iter_mut().find(|link| {
                    [(first, second), (second, first)].contains(&(link.from, link.to))
                        && !matches!(link.kind, LinkKind::Relation(kind) if kind.is_support())
                });
                match known {
                    Some(link) => link.distance_m = Some(meters),
                    None => self
                        .parsed
                        .links
                        .push(Link { distance_m: Some(meters), ..Link::new(second, kind, first) }),
                }
                let claim =
                    Claimed::Relation { kind: RelationKind::NextTo, from: vec![second], to: vec![first] };
                self.parsed.account.claim(tokens, claim);
            }
            _ => {
                self.arrange(members, Group::Row, None, tokens);
                if let Some(last) = self.parsed.arrangements.last_mut() {
                    last.gap_m = Some(meters);
                }
            }
        }
    }

    /// "25 cm to the left of the center": a position on the table. Whether the rule applies.
    fn distance_from_center(&mut self, meters: f64, start: usize, after: usize) -> bool {
        let Some((preposition, length)) = preposition_at(self.tokens, after) else { return false };
        let direction = match preposition.kind {
            RelationKind::LeftOf => DVec2::NEG_X,
            RelationKind::RightOf => DVec2::X,
            RelationKind::Behind => DVec2::Y,
            RelationKind::InFrontOf => DVec2::NEG_Y,
            _ => return false,
        };
        let center = [
            "the center of the table",
            "the table center",
            "the center",
            "the middle of the table",
            "the middle",
        ]
        .iter()
        .filter_map(|phrase| match_phrase(self.tokens, after + length, phrase))
        .max();
        let Some(center) = center else { return false };
        let end = after + length + center;
        let subjects = self.attached();
        if self.word_at(end) == Some("of") || subjects.is_empty() || !DISTANCES_M.contains(&meters) {
            return false;
        }
        for &mention in &subjects {
            let known = self.parsed.mentions[mention].position_m.unwrap_or(DVec2::ZERO);
            self.parsed.mentions[mention].position_m = Some(known + meters * direction);
        }
        self.claim_property(start..end, Property::Position, subjects);
        self.at = end;
        true
    }

    /// "behind the plate, 5 cm away", "next to the plate at a distance of 5 cm". Whether the rule applies.
    fn distance_of_relation(&mut self, meters: f64, before: Range<usize>, after: usize) -> bool {
        let named = before.clone().any(|token| self.word_at(token) == Some("distance"));
        let away = ["distance to it", "distance from it", "away from it", "distance", "away"]
            .iter()
            .find_map(|phrase| match_phrase(self.tokens, after, phrase));
        let end = after + away.unwrap_or(0);
        let ends = matches!(self.tokens.get(end), None | Some(Token::Pause | Token::End))
            || self.word_at(end) == Some("and");
        let Some(&last) = self.subject.last() else { return false };
        let link = self.parsed.links.iter_mut().rev().find(|link| {
            link.from == last
                && link.distance_m.is_none()
                && matches!(link.kind, LinkKind::Relation(kind) if !kind.is_support())
        });
        let (true, Some(link)) = (ends && (named || away.is_some()) && DISTANCES_M.contains(&meters), link)
        else {
            return false;
        };
        link.distance_m = Some(meters);
        self.claim_property(before.start..end, Property::Distance, vec![last]);
        self.at = end;
        true
    }

    /// "keep 10 cm between the fork and the knife", "with 5 cm between the bottles". Whether the rule applies.
    fn distance_between(&mut self, meters: f64, start: usize, after: usize) -> bool {
        let between = [
            "between",
            "of space between",
            "of distance between",
            "gap between",
            "space between",
            "spacing between",
            "distance between",
        ]
        .iter()
        .find_map(|phrase| match_phrase(self.tokens, after, phrase));
        let Some(length) = between.filter(|_| DISTANCES_M.contains(&meters)) else { return false };
        let Some((phrase, end)) = noun_phrase(self.lexicon, self.tokens, after + length) else {
            return false;
        };
        let second = (self.word_at(end) == Some("and"))
            .then(|| noun_phrase(self.lexicon, self.tokens, end + 1))
            .flatten();
        if !is_object(&phrase.head) || phrase.is_table() || second.is_none() && !phrase.plural {
            return false;
        }
        self.at = end;
        let before = self.subject.clone();
        self.subject = self.objects_of(phrase, second);
        self.apart(meters, start..after + length);
        self.subject = if before.is_empty() { std::mem::take(&mut self.subject) } else { before };
        self.salient_list = self.subject.clone();
        true
    }

    /// The objects that a phrase names, and those of a second phrase with the token after it: "the mug and the bowl".
    pub(super) fn objects_of(
        &mut self,
        first: NounPhrase,
        second: Option<(NounPhrase, usize)>,
    ) -> Vec<usize> {
        let mut members = match self.refer(first, true) {
            Referent::Mentions(list) => list,
            _ => Vec::new(),
        };
        if let Some((phrase, end)) = second {
            self.at = end;
            if let Referent::Mentions(list) = self.refer(phrase, true) {
                members.extend(list);
            }
        }
        for &member in &members {
            self.parsed.mentions[member].forward = false;
        }
        members
    }

    /// The mentions that "apart", "in a row" and the like apply to: the last member of the list if it is plural,
    /// the parts of a plural, otherwise the list.
    pub(super) fn members(&self) -> Vec<usize> {
        let list = if self.subject.is_empty() { &self.salient_list } else { &self.subject };
        if let Some(last) = list.last()
            && self.parts.len() > 1
            && self.parts.contains(last)
        {
            return self.parts.clone();
        }
        match list.last() {
            Some(&last) if self.is_several(last) => vec![last],
            _ => list.clone(),
        }
    }

    pub(super) fn is_several(&self, mention: usize) -> bool {
        let mention = &self.parsed.mentions[mention];
        mention.plural || mention.count.is_some_and(|count| count[1] > 1)
    }
}
