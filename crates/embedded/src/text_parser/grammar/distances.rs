//! Distances: "20 cm to the right of the plate", "10 cm from the left edge", "5 cm apart", "with a gap of 5 cm".

use std::ops::Range;

use super::{Link, LinkKind, Parser, Place};
use crate::text_parser::account::Claimed;
use crate::text_parser::measures::read_length;
use crate::text_parser::phrase::Group;
use crate::text_parser::prepositions::{Preposition, preposition_at};
use crate::text_parser::tokens::match_phrase;
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
        let within = (start..p).any(|token| self.word_at(token) == Some("within"));
        let away = ["away from", "from", "off"]
            .iter()
            .chain(within.then_some(&"of"))
            .filter_map(|phrase| match_phrase(self.tokens, after, phrase))
            .max();
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

    /// "from the left edge (of the table)".
    fn edge_at(&self, at: usize) -> Option<(RelationKind, usize)> {
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
    fn apart(&mut self, meters: f64, tokens: Range<usize>) {
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
            self.claim_property(tokens, "distance", mentions);
            return;
        }
        let members = self.members();
        match members[..] {
            [] => self.report(tokens, UnrecognizedReason::NoReferent),
            [first, second]
                if !self.parsed.mentions[first].plural && !self.parsed.mentions[second].plural =>
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

    /// The mentions that "apart", "in a row" and the like apply to: the last member of the list if it is plural,
    /// otherwise the list.
    pub(super) fn members(&self) -> Vec<usize> {
        let list = if self.subject.is_empty() { &self.salient_list } else { &self.subject };
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
