//! Spatial relations: prepositions with or without an object, before or after their subject.

use std::ops::Range;

use super::steps::is_object;
use super::{Link, LinkKind, Parser, PendingRelation, Place, Referent};
use crate::text_parser::account::Claimed;
use crate::text_parser::lexicon::Meaning;
use crate::text_parser::phrase::{Determiner, Head, noun_phrase};
use crate::text_parser::prepositions::{Preposition, place_at, preposition_at};
use crate::text_parser::supports::fits;
use crate::text_parser::tokens::Token;
use scene::RelationKind;
use scene::text_account::UnrecognizedReason;

/// Maximum number of links that are searched for circles.
const MAX_COMPARED: usize = 64;

impl Parser<'_, '_> {
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
        if place_at(self.tokens, at, &Self::is_table_word).is_some()
            || preposition_at(self.tokens, at).is_some()
        {
            return clause_start && ahead == 0 && self.subject.is_empty();
        }
        noun_phrase(self.lexicon, self.tokens, at).is_some_and(|(phrase, _)| is_object(&phrase.head))
    }

    /// Whether the object follows, also after a colon: "phone, 5 cm to the left: pencil".
    fn is_announced(&self, clause_start: bool) -> bool {
        let listed = self.is_colon(self.at)
            && noun_phrase(self.lexicon, self.tokens, self.at + 1)
                .is_some_and(|(phrase, _)| is_object(&phrase.head));
        listed || self.fronted(clause_start)
    }

    /// "a stove and, in front of it, a pan": the words from `start` on stand between commas before their object.
    fn is_aside(&self, start: usize) -> bool {
        let before = start.checked_sub(2).and_then(|at| self.word_at(at));
        start > 1
            && matches!(self.tokens[start - 1], Token::Pause)
            && before == Some("and")
            && matches!(self.tokens.get(self.at), Some(Token::Pause))
            && noun_phrase(self.lexicon, self.tokens, self.at + 1)
                .is_some_and(|(phrase, _)| is_object(&phrase.head))
    }

    /// The members of the current list to which a following preposition applies: the last one, or both of "X and Y" if
    /// their categories are in the same group.
    pub(super) fn attached(&self) -> Vec<usize> {
        let Some((&last, before)) = self.subject.split_last() else { return Vec::new() };
        if self.all_members {
            return self.subject.clone();
        }
        let [.., other] = before else { return vec![last] };
        let bare = |m: usize| self.is_bare(m);
        let group = |m: usize| match self.parsed.mentions[m].meanings.first() {
            Some(Meaning::Category(index)) => Some(self.lexicon.categories[*index].group.as_str()),
            _ => None,
        };
        let families = group(*other) == group(last) && group(last).is_some();
        if self.joined && bare(*other) && families { vec![*other, last] } else { vec![last] }
    }

    fn is_bare(&self, m: usize) -> bool {
        self.parsed.links.iter().all(|link| link.from != m && link.to != m)
            && self.parsed.mentions[m].places.is_empty()
            && self.parsed.mentions[m].position_m.is_none()
    }

    /// Whether a mention is a row, a stack or the like of its own: in "a row of pencils and a marker in a mug", the
    /// marker alone is in the mug.
    fn is_arranged(&self, m: usize) -> bool {
        let last = self.subject.last();
        let is_own =
            |mentions: &[usize]| mentions.contains(&m) && !last.is_some_and(|l| mentions.contains(l));
        self.parsed.mentions[m].stacked
            || self.parsed.arrangements.iter().any(|group| is_own(&group.mentions))
    }

    /// The members of the current list that a support applies to: all of "A, B and C in a box" that fit the target.
    fn supported(&self, kind: RelationKind, targets: &[usize]) -> Vec<usize> {
        let attached = self.attached();
        let [target] = targets else { return attached };
        if !self.joined || !kind.is_support() {
            return attached;
        }
        let category = |m: usize| match self.parsed.mentions[m].meanings.first() {
            Some(Meaning::Category(index)) => Some(&self.lexicon.categories[*index]),
            _ => None,
        };
        let Some(host) = category(*target) else { return attached };
        let last = self.subject.last().copied();
        let mut members: Vec<usize> = self
            .subject
            .iter()
            .rev()
            .copied()
            .take_while(|&m| {
                let is_free =
                    m != *target && self.is_bare(m) && !(kind == RelationKind::In && self.is_arranged(m));
                let fitting = category(m).map(|item| fits(item, host, kind));
                // "a kettle and two mugs on coasters": the kettle does not fit.
                Some(m) == last
                    || attached.contains(&m) && fitting != Some(false)
                    || is_free && fitting == Some(true)
            })
            .collect();
        members.reverse();
        members
    }

    /// "to its left", "on its right".
    pub(super) fn side_of_it(&mut self) -> Option<RelationKind> {
        let start = usize::from(matches!(self.word(0), Some("to" | "on" | "at" | "in")));
        if !matches!(self.word(start), Some("its" | "their" | "his" | "her")) {
            return None;
        }
        let kind = match self.word(start + 1)? {
            "left" => RelationKind::LeftOf,
            "right" => RelationKind::RightOf,
            "front" => RelationKind::InFrontOf,
            "back" | "rear" => RelationKind::Behind,
            "side" | "sides" if self.word(0) != Some("on") => RelationKind::NextTo,
            _ => return None,
        };
        self.at += start + 2 + usize::from(matches!(self.word(start + 2), Some("side" | "hand")));
        Some(kind)
    }

    /// A preposition of `length` tokens at the current position, at a distance from its object.
    pub(super) fn prepositional(
        &mut self,
        preposition: Preposition,
        length: usize,
        clause_start: bool,
        distance: Option<(f64, usize)>,
    ) {
        let start = distance.map_or(self.at, |(_, start)| start);
        self.at += length;
        let tokens = start..self.at;
        let distance_m = distance.map(|(distance_m, _)| distance_m);
        let kind = preposition.kind;
        let also = self.coordinated(preposition);
        if preposition.two_targets && self.between_named_before(preposition, clause_start, &tokens) {
            return;
        }
        // "on top", "inside", "beside": relative to the last mention.
        let target = noun_phrase(self.lexicon, self.tokens, self.at)
            .filter(|_| !(preposition.may_stand_alone && self.pause_follows()));
        let named = self.arrangement_named_at(self.at).filter(|_| !preposition.two_targets);
        if let Some((member, end)) = named {
            let start = std::mem::replace(&mut self.at, end);
            self.parsed.account.used(start..end);
            let (targets, second) = (vec![member], None);
            let relation =
                PendingRelation { kind, inverse: preposition.inverse, targets, second, distance_m, tokens };
            if self.subject.is_empty() || self.fronted(clause_start) {
                self.subject.clear();
                self.pending = vec![relation];
            } else {
                for subject in self.attached() {
                    self.relate(subject, &relation, member);
                }
            }
            return;
        }
        let Some((mut phrase, end)) = target else {
            if preposition.may_stand_alone && !preposition.two_targets {
                self.relate_or_wait(kind, clause_start, tokens, distance_m);
            } else if kind != RelationKind::On && kind != RelationKind::In {
                self.report(tokens, UnrecognizedReason::NoReferent);
            }
            return;
        };
        let distance_m = distance_m.or_else(|| self.bracketed_distance(&mut phrase, kind));
        let pronoun = phrase.head == Head::It;
        let them = phrase.head == Head::Them;
        let is_unknown = matches!(phrase.head, Head::Unknown(_));
        let chained = self.chain.filter(|_| kind.is_support() && !pronoun);
        let chained = chained.or_else(|| self.repeated(kind, start));
        self.at = end;
        let each = phrase.determiner == Determiner::Each;
        let plural = phrase.plural;
        let open_plural = plural && phrase.count.is_none() && phrase.determiner == Determiner::New;
        let before = self.subject.clone();
        let referent = match self.refer(phrase, true) {
            Referent::Table => {
                // "on the desk": the default position.
                self.parsed.account.used(tokens);
                if self.with_at().is_some() || self.fronted(clause_start) {
                    self.subject.clear();
                }
                return;
            }
            referent => referent,
        };
        self.subject = before;
        if let Referent::Mentions(targets) = &referent {
            self.last_target = targets.last().map(|&target| (target, end));
        }
        if let (Referent::Mentions(list), true) = (&referent, open_plural && kind.is_support())
            && let ([target], Some(&subject)) = (&list[..], self.subject.last())
            && self.is_several(subject)
            && self.parsed.mentions[*target].count.is_none()
        {
            // "two cups on saucers": one for each.
            self.parsed.mentions[*target].count = self.parsed.mentions[subject].count;
        }
        let Referent::Mentions(mut targets) = referent else {
            if is_unknown {
                self.report(tokens, UnrecognizedReason::NoReferent);
            }
            return;
        };
        let aside = pronoun && self.is_aside(start);
        if pronoun && !preposition.two_targets {
            let follows = aside || self.is_announced(clause_start);
            for target in &mut targets {
                *target = match self.subject.last() {
                    // "a toolbox, in it a wrench; a bucket, in it a sponge".
                    Some(&last)
                        if follows
                            && self
                                .parsed
                                .links
                                .iter()
                                .all(|link| (link.from, link.to) != (last, *target)) =>
                    {
                        last
                    }
                    _ if kind.is_support() => *target,
                    _ => self.beside(self.other_than_support(*target)),
                };
            }
        }
        if them && !kind.is_support() && !preposition.two_targets && !self.fronted(clause_start) {
            targets = self.others(targets);
        }
        // "between the plate and the vase".
        let mut second = None;
        if preposition.two_targets {
            if self.word(0) == Some("and")
                && let Some((phrase, end)) = noun_phrase(self.lexicon, self.tokens, self.at + 1)
            {
                self.parsed.account.used(self.at..self.at + 1);
                self.at = end;
                if let Referent::Mentions(more) = self.refer(phrase, true) {
                    second = more.first().copied();
                }
            } else if let [first, other, ..] = targets[..] {
                (targets, second) = (vec![first], Some(other));
            } else if plural {
                second = targets.first().copied();
            }
        }
        let kind =
            if kind == RelationKind::Between && second.is_none() { RelationKind::NextTo } else { kind };
        let subjects = match (chained, self.subject.last()) {
            (Some(chain), _) => vec![chain],
            (None, Some(&last)) if pronoun => vec![last],
            _ => self.supported(kind, &targets),
        };
        let relation = PendingRelation {
            kind,
            inverse: preposition.inverse,
            targets: targets.clone(),
            second,
            distance_m,
            tokens,
        };
        let also = also.map(|(preposition, tokens)| PendingRelation {
            kind: preposition.kind,
            inverse: preposition.inverse,
            tokens,
            ..relation.clone()
        });
        let announced = aside || pronoun && self.is_announced(clause_start);
        if chained.is_none() && (subjects.is_empty() || announced || self.fronted(clause_start)) {
            self.subject.clear();
            self.pending_places.clear();
            self.pending = std::iter::once(relation).chain(also).collect();
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
            // "a deck and a die to the right of the deck" says nothing of the deck.
            for &target in targets.iter().filter(|&&target| subjects.len() == 1 || target != subject) {
                self.relate(subject, &relation, target);
                if let Some(also) = &also {
                    self.relate(subject, also, target);
                }
            }
        }
        self.chain = targets.last().copied().filter(|_| kind.is_support());
    }

    fn pause_follows(&self) -> bool {
        matches!(self.tokens.get(self.at), None | Some(Token::Pause | Token::End))
    }

    /// A relation without an object: relative to the last mention, for the subject or for the phrase that follows.
    pub(super) fn relate_or_wait(
        &mut self,
        kind: RelationKind,
        clause_start: bool,
        tokens: Range<usize>,
        distance_m: Option<f64>,
    ) {
        let subjects = self.attached();
        if self.is_announced(clause_start) || subjects.is_empty() {
            match subjects.first().copied().or(self.salient) {
                Some(it) => {
                    self.subject.clear();
                    let (targets, inverse, second) = (vec![it], false, None);
                    self.pending =
                        vec![PendingRelation { kind, inverse, targets, second, distance_m, tokens }];
                    self.pending_pronoun = true;
                }
                None => self.report(tokens, UnrecognizedReason::NoReferent),
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
        let it = it.map(|it| self.beside(it)).filter(|it| !subjects.contains(it)).or(it);
        for &subject in &subjects {
            match it {
                Some(it) => {
                    let (targets, inverse, second) = (vec![it], false, None);
                    let relation = PendingRelation {
                        kind,
                        inverse,
                        targets,
                        second,
                        distance_m,
                        tokens: tokens.clone(),
                    };
                    self.relate(subject, &relation, it);
                }
                None => {
                    let place = match kind {
                        RelationKind::LeftOf => RelationKind::AtLeft,
                        RelationKind::RightOf => RelationKind::AtRight,
                        RelationKind::InFrontOf => RelationKind::AtFront,
                        RelationKind::Behind => RelationKind::AtBack,
                        _ => {
                            self.report(tokens.clone(), UnrecognizedReason::NoReferent);
                            continue;
                        }
                    };
                    self.set_place(subject, Place { kind: place, distance_m: None }, tokens.clone());
                }
            }
        }
    }

    /// Links a subject to a target; a relation that contradicts an earlier one is reported.
    pub(super) fn relate(&mut self, subject: usize, relation: &PendingRelation, target: usize) {
        let (from, to) = if relation.inverse { (target, subject) } else { (subject, target) };
        let tokens = relation.tokens.clone();
        if from == to {
            if !self.parsed.mentions[from].plural {
                self.report(tokens, UnrecognizedReason::NoReferent);
            }
            return;
        }
        if self.contradicts(from, relation.kind, to) {
            self.report(tokens, UnrecognizedReason::Contradiction);
            return;
        }
        if self.sided_at_distance(from, relation, to) {
            return;
        }
        let link = Link {
            second: relation.second,
            distance_m: relation.distance_m,
            ..Link::new(from, LinkKind::Relation(relation.kind), to)
        };
        let mut targets = vec![to];
        targets.extend(relation.second.filter(|second| *second != to));
        self.parsed
            .account
            .claim(tokens, Claimed::Relation { kind: relation.kind, from: vec![from], to: targets });
        if !self.parsed.links.contains(&link) {
            self.parsed.links.push(link);
        }
    }

    /// Whether an earlier relation excludes this one.
    fn contradicts(&self, from: usize, kind: RelationKind, to: usize) -> bool {
        use RelationKind::{Behind, In, InFrontOf, LeftOf, On, RightOf};
        let opposite = |kind: RelationKind| match kind {
            LeftOf => Some(RightOf),
            RightOf => Some(LeftOf),
            InFrontOf => Some(Behind),
            Behind => Some(InFrontOf),
            _ => None,
        };
        let single = |m: usize| !self.parsed.mentions[m].plural;
        self.parsed.links.iter().any(|link| {
            let LinkKind::Relation(known) = link.kind else { return false };
            let same = (link.from, link.to) == (from, to);
            let reversed = (link.from, link.to) == (to, from);
            let sided = (same && opposite(kind) == Some(known))
                || (reversed && opposite(kind).is_some() && known == kind);
            // Supports: of each other, or two supports of one object.
            let mutual = reversed && matches!(kind, On | In) && matches!(known, On | In);
            let second =
                link.from == from && link.to != to && matches!(kind, On | In) && matches!(known, On | In);
            single(from) && single(to) && (sided || mutual || second)
        }) || (single(from) && single(to) && self.closes_circle(from, kind, to))
    }

    /// Whether relations to one side form a circle ("the fork left of the knife, the knife left of the fork").
    fn closes_circle(&self, from: usize, kind: RelationKind, to: usize) -> bool {
        use RelationKind::{Behind, InFrontOf, LeftOf, RightOf};
        // The first of the pair is to the left or in front.
        let ordered = |kind: RelationKind, from: usize, to: usize| match kind {
            LeftOf => Some((0, from, to)),
            RightOf => Some((0, to, from)),
            InFrontOf => Some((1, from, to)),
            Behind => Some((1, to, from)),
            _ => None,
        };
        let Some((axis, first, last)) = ordered(kind, from, to) else { return false };
        if self.parsed.links.len() > MAX_COMPARED {
            return false;
        }
        let mut reached = vec![last];
        let mut k = 0;
        while k < reached.len() {
            for link in &self.parsed.links {
                let LinkKind::Relation(kind) = link.kind else { continue };
                if let Some((other, before, after)) = ordered(kind, link.from, link.to)
                    && other == axis
                    && before == reached[k]
                    && !reached.contains(&after)
                {
                    reached.push(after);
                }
            }
            k += 1;
        }
        reached.contains(&first)
    }
}
