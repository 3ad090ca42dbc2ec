//! Relations with two targets or two prepositions: "with a tray in between", "a spoon between them", "to the left of
//! and behind the plate", "2 cm from the plate on its right side".

use std::ops::Range;

use super::{Link, LinkKind, Parser, PendingRelation};
use crate::text_parser::account::Claimed;
use crate::text_parser::phrase::{Determiner, Head, noun_phrase};
use crate::text_parser::prepositions::{Preposition, place_at, preposition_at};
use scene::RelationKind;

impl Parser<'_, '_> {
    /// A second preposition with the same object: "on and under the tray". Moves to its end.
    pub(super) fn coordinated(&mut self, first: Preposition) -> Option<(Preposition, Range<usize>)> {
        let start = self.at + 1;
        let (preposition, length) = preposition_at(self.tokens, start)?;
        let joins = matches!(self.word(0), Some("and" | "or" | "but"));
        let has_object = noun_phrase(self.lexicon, self.tokens, start + length).is_some_and(|(phrase, _)| {
            phrase.determiner != Determiner::New || phrase.head == Head::It || !first.may_stand_alone
        });
        if !joins || !has_object || place_at(self.tokens, start, &Self::is_table_word).is_some() {
            return None;
        }
        self.at = start + length;
        Some((preposition, start..self.at))
    }

    /// The last two objects before these.
    pub(super) fn pair_before(&self, items: &[usize]) -> Option<(usize, usize)> {
        let lists = [&self.subject, &self.salient_list];
        for list in lists {
            let others: Vec<usize> = list.iter().copied().filter(|m| !items.contains(m)).collect();
            match others[..] {
                [.., first, second] => return Some((first, second)),
                [one] => {
                    let partner = self.parsed.links.iter().rev().find_map(|link| {
                        let other = if link.from == one { link.to } else { link.from };
                        (one == link.from || one == link.to).then_some(other).filter(|m| !items.contains(m))
                    });
                    if let Some(partner) = partner {
                        return Some((one, partner));
                    }
                    if self.is_several(one) {
                        return Some((one, one));
                    }
                }
                [] => {}
            }
        }
        let first_item = items.first().copied().unwrap_or(self.parsed.mentions.len());
        first_item.checked_sub(2).map(|first| (first, first + 1))
    }

    pub(super) fn relate_between(
        &mut self,
        items: &[usize],
        first: usize,
        second: usize,
        tokens: Range<usize>,
    ) {
        let kind = LinkKind::Relation(RelationKind::Between);
        for &item in items {
            self.parsed.links.push(Link { second: Some(second), ..Link::new(item, kind, first) });
        }
        let mut to = vec![first, second];
        to.dedup();
        let claim = Claimed::Relation { kind: RelationKind::Between, from: items.to_vec(), to };
        self.parsed.account.claim(tokens, claim);
    }

    /// "in between" without an object of its own, and "between them": the objects are those before. Whether it applies.
    pub(super) fn between_named_before(
        &mut self,
        preposition: Preposition,
        clause_start: bool,
        tokens: &Range<usize>,
    ) -> bool {
        let object = noun_phrase(self.lexicon, self.tokens, self.at);
        let (alone, them) = match &object {
            None => (true, None),
            Some((phrase, end)) if phrase.head == Head::Them => (false, Some(*end)),
            Some((phrase, end)) => {
                let pair = self.word_at(*end) == Some("and") || phrase.plural || phrase.head == Head::All;
                (!pair && phrase.determiner == Determiner::New, None)
            }
        };
        if !(alone && preposition.may_stand_alone || them.is_some()) {
            return false;
        }
        let after = them.unwrap_or(self.at);
        let start = std::mem::replace(&mut self.at, after);
        let fronted = self.fronted(clause_start);
        let items = if fronted { Vec::new() } else { self.attached() };
        let Some((first, second)) = self.pair_before(&items).filter(|_| fronted || !items.is_empty()) else {
            self.at = start;
            return false;
        };
        self.parsed.account.used(tokens.start..after);
        if fronted {
            self.subject.clear();
            self.pending_places.clear();
            self.pending = vec![PendingRelation {
                kind: RelationKind::Between,
                inverse: false,
                targets: vec![first],
                second: Some(second),
                distance_m: None,
                tokens: tokens.clone(),
            }];
        } else {
            self.relate_between(&items, first, second, tokens.clone());
        }
        true
    }

    /// "2 cm from the plate on its right side": the side of a distance that is known. Whether it applies.
    pub(super) fn sided_at_distance(&mut self, from: usize, relation: &PendingRelation, to: usize) -> bool {
        use RelationKind::{Behind, InFrontOf, LeftOf, NextTo, RightOf};
        if relation.distance_m.is_some() || !matches!(relation.kind, LeftOf | RightOf | InFrontOf | Behind) {
            return false;
        }
        let known = self.parsed.links.iter_mut().rev().find(|link| {
            (link.from, link.to) == (from, to)
                && link.kind == LinkKind::Relation(NextTo)
                && link.distance_m.is_some()
        });
        let Some(link) = known else { return false };
        link.kind = LinkKind::Relation(relation.kind);
        let claim = Claimed::Relation { kind: relation.kind, from: vec![from], to: vec![to] };
        self.parsed.account.claim(relation.tokens.clone(), claim);
        true
    }
}
