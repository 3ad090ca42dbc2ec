//! Referents of the paths of instructions, and the relations of the start state that they state.

use super::action::{Action, Path, PathKind};
use super::goals::GoalKind;
use super::states::category_shows;
use super::{Link, LinkKind, Parser, PendingRelation, Place, Referent};
use crate::text_parser::account::Claimed;
use crate::text_parser::lexicon::Meaning;
use crate::text_parser::phrase::{Head, NounPhrase, Selector, noun_phrase};
use crate::text_parser::prepositions::{Preposition, preposition_at};
use crate::text_parser::tokens::Token;
use crate::text_parser::verbs::Frame;
use catalog::{Affordance, Category};
use scene::RelationKind;
use scene::text_account::PredicateKind;

impl Parser<'_, '_> {
    pub(super) fn category_of(&self, meanings: &[Meaning]) -> Option<&Category> {
        match meanings.first() {
            Some(Meaning::Category(index)) => Some(&self.lexicon.categories[*index]),
            _ => None,
        }
    }

    /// The preposition at `at`, as an instruction means it.
    pub(super) fn preposition_of(&self, at: usize, frame: Frame) -> Option<(Preposition, usize)> {
        if let Some(length) = self.compartment_at(at) {
            let inside = Preposition {
                kind: RelationKind::In,
                inverse: false,
                may_stand_alone: false,
                two_targets: false,
            };
            return Some((inside, length));
        }
        if self.contact_at(at) {
            let contact = Preposition {
                kind: RelationKind::NextTo,
                inverse: false,
                may_stand_alone: false,
                two_targets: false,
            };
            return Some((contact, 1));
        }
        let (preposition, length) = preposition_at(self.tokens, at)?;
        // "push the red block below the blue one": seen from above.
        let seen_from_above = match self.word_at(at) {
            Some("below") => Some(RelationKind::InFrontOf),
            Some("above") => Some(RelationKind::Behind),
            _ => None,
        };
        match seen_from_above.filter(|_| frame == Frame::Push) {
            Some(kind) => Some((Preposition { kind, inverse: false, ..preposition }, length)),
            None => Some((preposition, length)),
        }
    }

    /// "in the back compartment of", and "in the back of" before a container: the number of words.
    fn compartment_at(&self, at: usize) -> Option<usize> {
        if !matches!(self.word_at(at), Some("in" | "into" | "inside")) || self.word_at(at + 1) != Some("the")
        {
            return None;
        }
        let mut p = at + 2;
        while matches!(
            self.word_at(p),
            Some(
                "left"
                    | "right"
                    | "front"
                    | "back"
                    | "rear"
                    | "middle"
                    | "center"
                    | "top"
                    | "bottom"
                    | "large"
                    | "small"
                    | "first"
                    | "second"
            )
        ) {
            p += 1;
        }
        let is_named = matches!(
            self.word_at(p),
            Some("compartment" | "section" | "slot" | "pocket" | "part" | "half" | "side" | "inside")
        );
        p += usize::from(is_named);
        if p == at + 2 || self.word_at(p) != Some("of") {
            return None;
        }
        let (phrase, _) = noun_phrase(self.lexicon, self.tokens, p + 1)?;
        let Head::Objects(meanings) = &phrase.head else { return None };
        self.category_of(meanings)?.affords(Affordance::Container).then_some(p + 1 - at)
    }

    /// Whether the phrase names something with an inside that is no container of the catalog.
    pub(super) fn names_inside(&self, phrase: &NounPhrase) -> bool {
        let is_drawer = self.tokens[phrase.tokens.clone()]
            .iter()
            .filter_map(Token::word)
            .any(|word| matches!(word, "drawer" | "cabinet" | "oven" | "microwave" | "cupboard"));
        let Head::Objects(meanings) = &phrase.head else { return false };
        is_drawer && self.category_of(meanings).is_some_and(|category| category_shows(category, "closed"))
    }

    /// "its own", "their own" at `at`: the position of the noun.
    pub(super) fn own_at(&self, at: usize) -> Option<usize> {
        let owns = matches!(self.word_at(at), Some("its" | "their" | "an" | "a"));
        (owns && self.word_at(at + 1) == Some("own")).then_some(at + 2)
    }

    /// "each egg in a bowl": every object of its own.
    pub(super) fn one_for_each(
        &mut self,
        targets: &[usize],
        mentions: usize,
        action: &Action,
        is_single: bool,
    ) {
        let [target] = targets[..] else { return };
        let each = action.objects.iter().map(|part| part.mention).find(|m| self.each.contains(m));
        if let Some(each) = each.filter(|_| is_single && target >= mentions) {
            self.parsed.mentions[target].each_of = Some(each);
            self.parsed.mentions[target].count = None;
            self.expected.push(target);
        }
    }

    /// The object of an instruction that a later phrase introduces: "put the eggs in the bowl; there are two eggs",
    /// "separate the bolts from the nuts: bolts go in the jar".
    pub(super) fn introduced(&self, compatible: &[usize], phrase: &NounPhrase) -> Option<usize> {
        let found = *compatible.iter().rev().find(|m| self.expected.contains(m))?;
        let mention = &self.parsed.mentions[found];
        let is_bare = phrase.plural && phrase.count.is_none() && mention.plural;
        let start = phrase.tokens.start;
        let is_later = self.source.has_end(mention.tokens.end.min(start)..start);
        let sentence = (0..start).rev().take_while(|&at| self.tokens[at] != Token::End);
        let adds = sentence.chain([start]).any(|at| {
            matches!(self.word_at(at), Some("also" | "another" | "additionally" | "other" | "more"))
        });
        let is_several = phrase.count.is_some_and(|count| count[1] > 1);
        let agrees = is_several || phrase.plural == mention.plural;
        (is_bare || is_later && !adds && agrees).then_some(found)
    }

    /// Gives an object that was only referred to so far the number that the text states. An instruction about one of
    /// them stays about one.
    pub(super) fn introduce(&mut self, earlier: usize, phrase: &NounPhrase) {
        let mention = &mut self.parsed.mentions[earlier];
        mention.forward = false;
        let is_one_of = !mention.plural && phrase.count.is_some_and(|count| count[1] > 1);
        if phrase.count.is_some() || !mention.plural {
            mention.count = phrase.count;
            mention.plural = phrase.plural;
            mention.each_of = None;
        }
        if is_one_of {
            let goals = self.parsed.goals.iter_mut().filter(|goal| goal.object == earlier);
            for goal in goals.filter(|goal| goal.take.is_none()) {
                goal.take = Some(1);
            }
        }
        self.expected.retain(|expected| *expected != earlier);
    }

    fn shares_meaning(&self, mention: usize, phrase: &NounPhrase) -> bool {
        matches!(&phrase.head, Head::Objects(meanings) if *meanings == self.parsed.mentions[mention].meanings)
    }

    /// "put one block on the other", "put the second book on the first book": another object like the only one.
    pub(super) fn other_of_pair(&mut self, phrase: &NounPhrase, action: &Action) -> Option<usize> {
        let [object] = action.objects[..] else { return None };
        let one = object.mention;
        let ordinal = |at: usize| {
            self.word_at(at).filter(|word| matches!(*word, "first" | "second" | "third" | "other"))
        };
        let own = self.parsed.mentions[one].tokens.start.checked_sub(1).and_then(ordinal);
        let its = phrase.head_tokens.start.checked_sub(1).and_then(ordinal);
        let side = phrase.counted_from.as_ref().map(|(side, _)| *side);
        let from_other_side =
            side.is_some_and(|side| self.parsed.mentions[one].places.iter().all(|place| place.kind != side));
        let by_rank = own.is_some()
            && its.is_some()
            && (own != its || from_other_side)
            && self.shares_meaning(one, phrase);
        let names_other = phrase.head == Head::One && phrase.selector == Some(Selector::Other) || by_rank;
        let meanings = &self.parsed.mentions[one].meanings;
        let is_alone = (0..self.parsed.mentions.len())
            .all(|m| m == one || self.parsed.mentions[m].meanings != *meanings);
        if !names_other || !is_alone || self.is_several(one) {
            return None;
        }
        self.parsed.account.used(phrase.tokens.clone());
        let other = self.duplicate(one);
        if by_rank {
            // Each has its own name and its own place.
            self.parsed.account.claims.retain(|claim| claim.meaning != Claimed::Object(other));
            self.parsed.account.claim(phrase.head_tokens.clone(), Claimed::Object(other));
            self.parsed.mentions[other].tokens = phrase.head_tokens.clone();
            self.parsed.mentions[other].places.clear();
            if let Some((kind, tokens)) = phrase.counted_from.clone() {
                self.set_place(other, Place { kind, distance_m: None }, tokens);
            }
        }
        Some(other)
    }

    /// The object that "on its left" refers to: that of the side before, or the object before.
    pub(super) fn target_of_its(&self, objects: &[usize]) -> Option<usize> {
        let sided = |kind: &GoalKind| {
            use PredicateKind::{Behind, InFrontOf, LeftOf, RightOf};
            matches!(kind, GoalKind::Predicate(LeftOf | RightOf | InFrontOf | Behind))
        };
        let last = self.parsed.goals.last().filter(|goal| sided(&goal.kind)).and_then(|goal| goal.target);
        last.or(self.before_action)
            .filter(|target| !objects.contains(target))
            .or_else(|| self.earlier_target(objects, None))
    }

    /// The referent of a target; a pronoun is not the object itself.
    pub(super) fn refer_target(
        &mut self,
        phrase: NounPhrase,
        action: &Action,
        support: Option<RelationKind>,
    ) -> Referent {
        if phrase.head != Head::It {
            return self.refer(phrase, true);
        }
        self.parsed.account.used(phrase.tokens.clone());
        let mut others: Vec<usize> = action.objects.iter().map(|part| part.mention).collect();
        others.extend(action.sources.iter().flat_map(|path| path.targets.iter().copied()));
        let found = self.earlier_target(&others, support);
        found.map_or(Referent::Nothing, |it| Referent::Mentions(vec![it]))
    }

    /// The earlier object that "it" is as a target: one that can hold what is put into or onto it.
    pub(super) fn earlier_target(&self, others: &[usize], support: Option<RelationKind>) -> Option<usize> {
        let rest = || (0..self.parsed.mentions.len()).rev().filter(move |m| !others.contains(m));
        let salient = self.salient.filter(|it| !others.contains(it));
        let before = self.before_action.filter(|it| !others.contains(it));
        let holds = |m: &usize| {
            let Some(category) = self.category_of(&self.parsed.mentions[*m].meanings) else { return false };
            let contains = category.affords(Affordance::Container);
            match support {
                Some(RelationKind::In) => contains || category_shows(category, "closed"),
                _ => contains || category.affords(Affordance::Support),
            }
        };
        let usual = salient.or_else(|| rest().next());
        match support {
            Some(kind) if kind.is_support() => {
                before.filter(holds).or(salient.filter(holds)).or_else(|| rest().find(holds)).or(usual)
            }
            _ => usual,
        }
    }

    pub(super) fn second_target(&mut self, path: &mut Path, plural: bool) {
        if self.word(0) == Some("and")
            && let Some((phrase, end)) = noun_phrase(self.lexicon, self.tokens, self.at + 1)
        {
            self.parsed.account.used(self.at..self.at + 1);
            self.at = end;
            if let Referent::Mentions(more) = self.refer(phrase, true) {
                path.second = more.first().copied();
            }
        } else if let [first, second, ..] = path.targets[..] {
            (path.targets, path.second) = (vec![first], Some(second));
        } else if plural {
            path.second = path.targets.first().copied();
        }
    }

    /// Relates mentions by a path that describes the start state.
    pub(super) fn start_relation(&mut self, objects: &[usize], path: &Path) {
        for &object in objects {
            match &path.kind {
                PathKind::Relation(kind) => {
                    for &target in &path.targets {
                        let (kind, inverse, second) = (*kind, path.inverse, path.second);
                        let (targets, distance_m) = (vec![target], path.distance_m);
                        let tokens = path.tokens.clone();
                        let relation = PendingRelation { kind, inverse, targets, second, distance_m, tokens };
                        self.relate(object, &relation, target);
                    }
                }
                PathKind::At => {
                    for &target in &path.targets {
                        if target != object {
                            self.parsed.account.used(path.tokens.clone());
                            self.parsed.links.push(Link::new(object, LinkKind::At, target));
                        }
                    }
                }
                PathKind::Places(places) => {
                    for &kind in places {
                        self.set_place(object, Place { kind, distance_m: None }, path.tokens.clone());
                    }
                }
                PathKind::State(state) => self.set_states(&[object], state, path.tokens.clone()),
                _ => self.parsed.account.used(path.tokens.clone()),
            }
        }
    }
}
