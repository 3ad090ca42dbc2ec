//! Objects on both sides: "speakers on either side of the monitor", "a fork and a knife left and right of the plate".

use super::{Link, LinkKind, Mention, Parser, Referent};
use crate::text_parser::account::Claimed;
use crate::text_parser::phrase::noun_phrase;
use crate::text_parser::tokens::match_phrase;
use scene::RelationKind;
use scene::text_account::UnrecognizedReason;

pub(super) const FLANKS: &[&str] = &[
    "on either side",
    "on both sides",
    "on each side",
    "to either side",
    "to both sides",
    "at either side",
    "at both sides",
    "to the left and right",
    "on the left and right",
    "to the left and the right",
    "on the left and right side",
    "on the left and the right side",
    "left and right",
];

/// Phrases for both sides with an object after them.
const FLANKS_OF: &[&str] = &[
    "to the left and to the right of",
    "on the left and on the right of",
    "at the left and at the right of",
    "at the left and right of",
    "at the left and the right of",
    "left of and right of",
    "to the left of and to the right of",
];

impl Mention {
    /// "a candle on either side" are two candles.
    pub(super) fn doubled(&mut self) {
        if matches!(self.count, None | Some([1, 1])) {
            (self.count, self.plural) = (Some([2, 2]), true);
        }
    }
}

impl Parser<'_, '_> {
    /// One object on the left, one on the right. Whether the rule applies.
    pub(super) fn flank(&mut self) -> bool {
        let longest =
            |phrases: &[&str]| phrases.iter().filter_map(|p| match_phrase(self.tokens, self.at, p)).max();
        let with_of = longest(FLANKS_OF).map(|length| length - 1);
        let Some(length) = with_of.or_else(|| longest(FLANKS)) else { return false };
        let (Some(&subject), of) = (self.subject.last(), self.word(length) == Some("of")) else {
            return false;
        };
        // "on the left and right": parts of the table.
        if !of && self.word(length - 1) == Some("right") && self.earlier_than(&[subject]).is_none() {
            return false;
        }
        let subjects = match self.subject[..] {
            [.., first, last] if self.joined && !self.is_several(first) && !self.is_several(last) => {
                vec![first, last]
            }
            _ => self.attached(),
        };
        let tokens = self.at..self.at + length + usize::from(of);
        self.at = tokens.end;
        let target = if of {
            let Some((phrase, end)) = noun_phrase(self.lexicon, self.tokens, self.at) else { return true };
            self.at = end;
            match self.refer(phrase, true) {
                Referent::Mentions(targets) => targets.first().copied(),
                _ => None,
            }
        } else {
            self.earlier_than(&[subject])
        };
        let Some(target) = target.filter(|target| !subjects.contains(target)) else {
            self.report(tokens, UnrecognizedReason::NoReferent);
            return true;
        };
        match subjects[..] {
            [left, right] if !self.is_several(left) && !self.is_several(right) => {
                for (mention, kind) in [(left, RelationKind::LeftOf), (right, RelationKind::RightOf)] {
                    self.parsed.links.push(Link::new(mention, LinkKind::Relation(kind), target));
                }
            }
            // "a mug to the left and to the right of the plate" is one mug.
            _ if with_of.is_some() && self.parsed.mentions[subject].count == Some([1, 1]) => {
                self.report(tokens, UnrecognizedReason::Contradiction);
                return true;
            }
            _ => {
                self.parsed.mentions[subject].doubled();
                self.parsed.links.push(Link::new(subject, LinkKind::Flank, target));
            }
        }
        let claim = Claimed::Relation { kind: RelationKind::NextTo, from: subjects, to: vec![target] };
        self.parsed.account.claim(tokens, claim);
        true
    }
}
