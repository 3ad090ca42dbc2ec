//! Sides of an owner: "on the crate's left", "to the plate's right side".

use super::{Parser, PendingRelation, Referent};
use crate::text_parser::phrase::{NounPhrase, noun_phrase};
use crate::text_parser::tokens::Token;
use scene::RelationKind;

/// Maximum number of words of the owner.
const MAX_WORDS: usize = 5;

impl Parser<'_, '_> {
    fn has_apostrophe(&self, at: usize) -> bool {
        let span = self.source.spans.get(at).filter(|_| self.word_at(at).is_some());
        span.is_some_and(|span| self.source.text[span.clone()].contains(['\'', '’']))
    }

    /// "on the crate's left" at `at`: the relation, the owner, and the position after it.
    pub(super) fn owned_side_at(&self, at: usize) -> Option<(RelationKind, NounPhrase, usize)> {
        if !matches!(self.word_at(at), Some("on" | "to" | "at" | "in")) {
            return None;
        }
        let first = at + 1;
        let owner = (first..first + MAX_WORDS)
            .take_while(|&p| self.word_at(p).is_some())
            .find(|&p| self.has_apostrophe(p))?;
        let kind = match self.word_at(owner + 1)? {
            "left" => RelationKind::LeftOf,
            "right" => RelationKind::RightOf,
            "front" => RelationKind::InFrontOf,
            "back" | "rear" => RelationKind::Behind,
            "side" => RelationKind::NextTo,
            _ => return None,
        };
        let mut words = self.tokens[first..=owner].to_vec();
        let noun = self.lexicon.vocabulary.singular_of(self.word_at(owner)?);
        *words.last_mut()? = Token::Word(noun);
        let (phrase, length) = noun_phrase(self.lexicon, &words, 0)?;
        let hand = usize::from(matches!(self.word_at(owner + 2), Some("side" | "hand")));
        let is_whole = length == words.len() && !phrase.is_table();
        is_whole.then(|| (kind, phrase.shifted(first), owner + 2 + hand))
    }

    /// Relates the subject, or the phrase that follows, to an owner. Whether the rule applies.
    pub(super) fn owned_side(&mut self, clause_start: bool) -> bool {
        let start = self.at;
        let Some((kind, phrase, end)) = self.owned_side_at(start) else { return false };
        self.at = end;
        let before = self.subject.clone();
        let Referent::Mentions(targets) = self.refer(phrase, true) else { return true };
        self.subject = before;
        let tokens = start..end;
        self.parsed.account.used(tokens.clone());
        let (second, distance_m) = (None, None);
        let relation = PendingRelation { kind, inverse: false, targets, second, distance_m, tokens };
        let subjects = self.attached();
        if subjects.is_empty() || self.fronted(clause_start) {
            self.subject.clear();
            self.pending = vec![relation];
            return true;
        }
        for subject in subjects {
            for &target in &relation.targets.clone() {
                self.relate(subject, &relation, target);
            }
        }
        true
    }
}
