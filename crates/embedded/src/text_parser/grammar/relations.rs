//! Spatial relations: regions of the table top, and prepositions with or without an object, before or after their
//! subject.

use super::{Link, LinkKind, Parser, Referent};
use crate::text_parser::lexicon::Meaning;
use crate::text_parser::phrase::{Determiner, Head, noun_phrase};
use crate::text_parser::prepositions::{Preposition, place_at, preposition_at};
use crate::text_parser::tokens::Token;
use scene::RelationKind;

impl Parser<'_, '_> {
    /// Assigns a region of the table top to the subject, or to the phrase that follows.
    pub(super) fn place(&mut self, places: Vec<RelationKind>, clause_start: bool) {
        if self.fronted(clause_start) || self.subject.is_empty() {
            self.subject.clear();
            self.pending.clear();
            self.pending_places = places;
            return;
        }
        for mention in self.attached() {
            for &place in &places {
                if !self.parsed.mentions[mention].places.contains(&place) {
                    self.parsed.mentions[mention].places.push(place);
                }
            }
        }
    }

    /// Whether the preceding phrase is fronted: a noun phrase or a verb of position follows.
    pub(super) fn fronted(&self, clause_start: bool) -> bool {
        let mut ahead = 0;
        if clause_start && matches!(self.tokens.get(self.at), Some(Token::Pause)) {
            return true;
        }
        while matches!(
            self.word(ahead),
            Some(
                "is" | "are"
                    | "there"
                    | "stands"
                    | "stand"
                    | "sits"
                    | "sit"
                    | "lies"
                    | "lie"
                    | "put"
                    | "place"
                    | "rests"
            )
        ) {
            ahead += 1;
        }
        let at = self.at + ahead;
        if place_at(self.tokens, at, &self.table_words()).is_some()
            || preposition_at(self.tokens, at).is_some()
        {
            return clause_start && ahead == 0 && self.subject.is_empty();
        }
        noun_phrase(self.lexicon, self.tokens, at)
            .is_some_and(|(phrase, _)| matches!(phrase.head, Head::Objects(_) | Head::Unknown(_)))
    }

    /// The members of the current list to which a following preposition applies: the last one, or both of "X and Y" if
    /// their categories are in the same group.
    pub(super) fn attached(&self) -> Vec<usize> {
        let Some((&last, before)) = self.subject.split_last() else { return Vec::new() };
        let [.., other] = before else { return vec![last] };
        let bare = |m: usize| self.parsed.links.iter().all(|link| link.from != m && link.to != m);
        let group = |m: usize| match self.parsed.mentions[m].meanings.first() {
            Some(Meaning::Category(index)) => Some(self.lexicon.categories[*index].group.as_str()),
            _ => None,
        };
        let families = group(*other) == group(last) && group(last).is_some();
        if self.joined && bare(*other) && self.parsed.mentions[*other].places.is_empty() && families {
            vec![*other, last]
        } else {
            vec![last]
        }
    }

    /// "to its left", "on its right".
    pub(super) fn side_of_it(&mut self) -> Option<RelationKind> {
        let start = usize::from(matches!(self.word(0), Some("to" | "on" | "at")));
        if !matches!(self.word(start), Some("its" | "their" | "his" | "her")) {
            return None;
        }
        let kind = match self.word(start + 1)? {
            "left" => RelationKind::LeftOf,
            "right" => RelationKind::RightOf,
            "front" => RelationKind::InFrontOf,
            "back" | "rear" => RelationKind::Behind,
            "side" | "sides" => RelationKind::NextTo,
            _ => return None,
        };
        self.at += start + 2 + usize::from(matches!(self.word(start + 2), Some("side" | "hand")));
        Some(kind)
    }

    pub(super) fn prepositional(&mut self, preposition: Preposition, clause_start: bool) {
        let kind = preposition.kind;
        // "on top", "inside", "beside": relative to the last mention.
        let target = noun_phrase(self.lexicon, self.tokens, self.at)
            .filter(|_| !(preposition.may_stand_alone && self.pause_follows()));
        let Some((phrase, end)) = target else {
            if preposition.may_stand_alone {
                self.relate_or_wait(kind, clause_start);
            }
            return;
        };
        let pronoun = phrase.head == Head::It;
        let subjects = match self.subject.last() {
            Some(&last) if pronoun => vec![last],
            _ => self.attached(),
        };
        self.at = end;
        let each = phrase.determiner == Determiner::Each;
        let mut targets = match self.refer(phrase, true) {
            Referent::Mentions(targets) => targets,
            Referent::Table => {
                // "on the desk": the default position.
                if self.with_at().is_some() || self.fronted(clause_start) {
                    self.subject.clear();
                }
                return;
            }
            Referent::Nothing => return,
        };
        // "between the plate and the vase".
        if preposition.two_targets
            && self.word(0) == Some("and")
            && let Some((second, end)) = noun_phrase(self.lexicon, self.tokens, self.at + 1)
        {
            self.at = end;
            if let Referent::Mentions(more) = self.refer(second, true) {
                targets.extend(more);
            }
        }
        if subjects.is_empty() || self.fronted(clause_start) {
            self.subject.clear();
            self.pending_places.clear();
            self.pending = vec![(kind, targets.clone())];
            self.pending_each = each.then(|| targets[0]);
            self.pending_pronoun = pronoun;
            // "Next to the monitor, a lamp. Beside it ...": "it" is the lamp; before the lamp it is the monitor.
            self.salient = targets.last().copied().or(self.salient);
            return;
        }
        for &subject in &subjects {
            if each && let Some(&target) = targets.first() {
                self.parsed.mentions[subject].each_of = Some(target);
            }
            for &target in &targets {
                self.link(subject, kind, preposition.inverse, target);
            }
        }
    }

    fn pause_follows(&self) -> bool {
        matches!(self.tokens.get(self.at), None | Some(Token::Pause | Token::End))
    }

    /// A relation without an object: relative to the last mention, for the subject or for the phrase that follows.
    pub(super) fn relate_or_wait(&mut self, kind: RelationKind, clause_start: bool) {
        let subjects = self.attached();
        if self.fronted(clause_start) || subjects.is_empty() {
            if let Some(it) = subjects.first().copied().or(self.salient) {
                self.subject.clear();
                self.pending = vec![(kind, vec![it])];
                self.pending_pronoun = true;
            }
            return;
        }
        let opposite = match kind {
            RelationKind::LeftOf => Some(RelationKind::RightOf),
            RelationKind::RightOf => Some(RelationKind::LeftOf),
            _ => None,
        };
        // "a mug to the left of the laptop and a phone to the right".
        let other_side = self.parsed.links.iter().rev().find(|link| {
            opposite.is_some_and(|opposite| link.kind == LinkKind::Relation(opposite))
                && !subjects.contains(&link.from)
                && self.subject.contains(&link.from)
        });
        let it = other_side.map(|link| link.to).or_else(|| self.earlier_than(&subjects));
        for &subject in &subjects {
            match it {
                Some(it) => self.link(subject, kind, false, it),
                None => match kind {
                    RelationKind::LeftOf => self.parsed.mentions[subject].places.push(RelationKind::AtLeft),
                    RelationKind::RightOf => self.parsed.mentions[subject].places.push(RelationKind::AtRight),
                    RelationKind::InFrontOf => {
                        self.parsed.mentions[subject].places.push(RelationKind::AtFront);
                    }
                    RelationKind::Behind => self.parsed.mentions[subject].places.push(RelationKind::AtBack),
                    _ => {}
                },
            }
        }
    }

    pub(super) fn link(&mut self, from: usize, kind: RelationKind, inverse: bool, to: usize) {
        let (from, to) = if inverse { (to, from) } else { (from, to) };
        if from == to {
            return;
        }
        let link = Link { from, kind: LinkKind::Relation(kind), to };
        if !self.parsed.links.contains(&link) {
            self.parsed.links.push(link);
        }
    }
}
